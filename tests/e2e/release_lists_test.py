#!/usr/bin/env python3
"""The lists that come with a release: what is in it, and under which licences."""

import base64
import hashlib
import json
import pathlib
import subprocess
import unittest
import zipfile

from releasing import TIME, tool
from support import ROOT, Case, temporary_folder

DEPS = ("--deps", ROOT / "build" / "deps")
LASZIP = "LASzip, with FastAC (BSD-2-Clause)"
RECORD = "terravox-1.2.3.dist-info/RECORD"
# Between the parts of the file with licences.
RULE = "=" * 78


def make_deb(folder, package, files):
    """@param files texts by their names in the package"""
    stage = folder / package
    control = (
        f"Package: {package}\nVersion: 1.2.3\nArchitecture: all\n"
        "Maintainer: T <t@example.org>\nDepends: libc6 (>= 2.36), tzdata\nDescription: test\n"
    )
    for name, text in {"DEBIAN/control": control, **files}.items():
        (stage / name).parent.mkdir(parents=True, exist_ok=True)
        (stage / name).write_text(text, encoding="utf-8")
    file = folder / f"{package}_1.2.3_all.deb"
    command = ["dpkg-deb", "--root-owner-group", "--build", stage, file]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return file


def make_debs(folder):
    terravox = {
        "usr/lib/terravox/terravox-laz": "program",
        "usr/lib/terravox/grabber/licences.txt": "@scope/one 2.0.1 (MIT)\n\ntext of one\n",
        "usr/share/doc/terravox/licences-page.txt": "two 3.0.0 (BSD-2-Clause)\n\ntext of two\n",
    }
    return [
        make_deb(folder, "terravox", terravox),
        make_deb(folder, "terravox-preview", {"usr/lib/terravox/terravox-preview": "program"}),
        make_deb(folder, "libterravox1.2", {"usr/lib/libterravox.so.1.2.3": "library"}),
        make_deb(folder, "terravox-data", {"usr/share/terravox/config/worker.toml": ""}),
    ]


def make_wheel(folder):
    """With a library that this machine has, as its licence is looked up here."""
    library = next(pathlib.Path("/usr/lib").glob("*/libzstd.so.1.*")).name
    stem, _, rest = library.partition(".so")
    file = folder / "terravox-1.2.3-cp311-cp311-linux_x86_64.whl"
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr(f"terravox.libs/{stem}-0a1b2c3d.so{rest}", "library")
        archive.writestr(RECORD, f"{RECORD},,\n")
    return file


class Lists(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        folder = temporary_folder()
        cls.files = [*make_debs(folder), make_wheel(folder)]
        cls.third_party = ("--third-party", ROOT / "THIRD_PARTY.md")

    def bill(self):
        file = temporary_folder() / "bill.json"
        words = ["-o", file, "--version", "1.2.3", "--time", TIME, *self.third_party]
        self.assertDone(tool("sbom.py", *self.files, *words))
        return file.read_text(encoding="utf-8")

    def test_each_file_and_what_is_in_it_is_listed(self):
        document = json.loads(self.bill())
        packages = {each["name"]: each for each in document["packages"]}
        for file in self.files:
            digest = hashlib.sha256(file.read_bytes()).hexdigest()
            self.assertEqual(packages[file.name]["checksums"][0]["checksumValue"], digest)
        self.assertEqual(
            packages["@scope/one"]["externalRefs"][0]["referenceLocator"],
            "pkg:npm/%40scope/one@2.0.1",
        )
        self.assertEqual(packages["two"]["licenseDeclared"], "BSD-2-Clause")
        self.assertIn(LASZIP, packages)
        self.assertNotIn("Catch2", packages)
        (library,) = (each for name, each in packages.items() if name.startswith("libzstd-0a1b"))
        self.assertEqual(library["licenseDeclared"], "BSD-3-Clause")
        relations = {
            (each["relationshipType"], each["relatedSpdxElement"])
            for each in document["relationships"]
        }
        self.assertIn(("DEPENDS_ON", packages["libc6"]["SPDXID"]), relations)
        self.assertIn(("CONTAINS", library["SPDXID"]), relations)
        for file in self.files:
            self.assertIn(("DESCRIBES", packages[file.name]["SPDXID"]), relations)

    def test_what_is_compiled_in_belongs_to_the_files_with_those_programs(self):
        document = json.loads(self.bill())
        names = {each["SPDXID"]: each["name"] for each in document["packages"]}
        found = {file.name: set() for file in self.files}
        for each in document["relationships"]:
            if each["relationshipType"] == "STATIC_LINK":
                found[names[each["spdxElementId"]]].add(names[each["relatedSpdxElement"]])
        headers = {"toml++, headers"}
        everywhere = {LASZIP, "JSON for Modern C++"}
        programs = everywhere | {"CLI11"}
        window = {"nanoflann", "Dear ImGui, with the font ProggyClean (MIT)"}
        self.assertEqual(found["terravox_1.2.3_all.deb"], programs | headers)
        self.assertEqual(found["terravox-preview_1.2.3_all.deb"], programs | window)
        self.assertEqual(found["libterravox1.2_1.2.3_all.deb"], everywhere | {"nanoflann"})
        self.assertEqual(found["terravox-data_1.2.3_all.deb"], set())
        wheel = found["terravox-1.2.3-cp311-cp311-linux_x86_64.whl"]
        self.assertLess(everywhere | {"nanoflann", "Python, headers", "curl"}, wheel)

    def test_it_has_the_form_of_spdx(self):
        text = self.bill()
        self.assertEqual(text, self.bill())
        document = json.loads(text)
        self.assertEqual(document["spdxVersion"], "SPDX-2.3")
        self.assertRegex(document["creationInfo"]["created"], r"^\d{4}-\d\d-\d\dT[\d:]{8}Z$")
        names = [each["SPDXID"] for each in document["packages"]]
        self.assertEqual(len(set(names)), len(names))
        for name in names:
            self.assertRegex(name, r"^SPDXRef-[A-Za-z0-9.-]+$")
        ends = ("spdxElementId", "relatedSpdxElement")
        used = {each[end] for each in document["relationships"] for end in ends}
        self.assertLessEqual(used, {*names, "SPDXRef-DOCUMENT"})

    def licences(self, *files):
        file = temporary_folder() / "licences.txt"
        self.assertDone(tool("licences.py", *files, "-o", file, *self.third_party, *DEPS))
        return file.read_text(encoding="utf-8")

    def test_licences_of_what_is_brought_and_compiled_in_are_there(self):
        text = self.licences(*self.files)
        for words in ("# Third-party software", "text of one", "text of two", "libzstd1 (Debian's"):
            self.assertIn(words, text)
        window = (
            "Dear ImGui, with the font ProggyClean (MIT) (Debian's copyright file), compiled in"
        )
        for heading, words in {
            f"{LASZIP} (its sources), compiled in": "TERMS AND CONDITIONS FOR USE",
            "nanoflann (Debian's copyright file), compiled in": "Marius Muja",
            window: "Omar Cornut",
            "nanobind, with robin-map (MIT) (its sources), compiled in": "Tessil",
            "GDAL, with libtiff": "Frank Warmerdam",
            "copyright, in Debian packages": "Tristan Grimmer (ProggyClean",
        }.items():
            with self.subTest(heading):
                _, found, rest = text.partition(f"\n{heading}")
                self.assertTrue(found)
                body = rest.partition(f"\n{RULE}\n\n")[2].partition(RULE)[0]
                self.assertIn(words.lower(), body.lower())
        # Only of what is in the files.
        text = self.licences(*make_debs(temporary_folder())[2:])
        self.assertIn("nanoflann (Debian's", text)
        for name in ("Dear ImGui, with", "nanobind, with", "Catch2 ("):
            self.assertNotIn(f"\n{name}", text)

    def test_a_wheel_gets_those_of_what_is_in_it(self):
        wheel = make_wheel(temporary_folder())
        copies = []
        for _ in range(2):
            folder = temporary_folder()
            words = (wheel, "-o", folder, *self.third_party, *DEPS)
            self.assertDone(tool("wheel_licences.py", *words))
            copies.append(folder / wheel.name)
        self.assertEqual(copies[0].read_bytes(), copies[1].read_bytes())
        name = "terravox/licences/third-party.txt"
        with zipfile.ZipFile(copies[0]) as archive, zipfile.ZipFile(wheel) as before:
            self.assertIsNone(archive.testzip())
            names = archive.namelist()
            self.assertEqual(set(names), {*before.namelist(), name})
            text = archive.read(name)
            words = text.decode()
            line, last = archive.read(RECORD).decode().splitlines()
        for holder in ("libzstd1 (Debian's", "Martin Isenburg", "Frank Warmerdam", "Planchon"):
            self.assertTrue(holder in words, holder)
        digest = base64.urlsafe_b64encode(hashlib.sha256(text).digest()).decode().rstrip("=")
        self.assertEqual(line, f"{name},sha256={digest},{len(text)}")
        self.assertEqual(last, f"{RECORD},,")
        self.assertEqual(names[-1], RECORD)

    def test_a_licence_that_is_not_there_is_an_error(self):
        empty = temporary_folder()
        words = ("-o", empty / "licences.txt", *self.third_party, "--deps", empty)
        run = tool("licences.py", *self.files, *words)
        self.assertEqual(run.code, 1, run)
        self.assertRegex(run.err, r"^write licences: \S+AUTHORS.txt of LASzip: .*terravox deps")
        self.assertEqual(list(empty.iterdir()), [])


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
"""Releases: what stands in their way, and the lists that come with them.

With --long a draft of Debian packages and the source archive is made, and the latter compiled.
"""

import hashlib
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tarfile
import unittest
import zipfile

from support import ROOT, Case, Run, temporary_folder

LONG = "--long" in sys.argv
TOOLS = ROOT / "config" / "release"
READ = (
    "CMakeLists.txt",
    "CHANGELOG.md",
    "config/cluster/kubernetes/frames.yaml",
    "config/cluster/kubernetes/pool.yaml",
    "config/debian/control",
    "docs/guide/install.md",
    "grabber/package.json",
    "grabber/package-lock.json",
    "raytracer/python/pyproject.toml",
    "voxelserver/page/package.json",
    "voxelserver/page/package-lock.json",
)
GIT = ("git", "-c", "user.name=T", "-c", "user.email=t@example.org", "-c", "commit.gpgsign=false")
TIME = "1700000000"
BUILD_S = 9000


def tool(name, *arguments):
    return Run([sys.executable, "-B", TOOLS / name, *arguments])


def version():
    text = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
    return re.search(r"project\(terravox VERSION ([0-9.]+)", text)[1]


class Check(Case):
    def setUp(self):
        super().setUp()
        self.folder = temporary_folder() / "checkout"
        for name in READ:
            (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, self.folder / name)
        self.replace("CHANGELOG.md", r"(?m)^## .*", f"## {version()}, 2026-12-01", 1)
        self.git("init", "--quiet")
        self.commit()

    def git(self, *words):
        command = [*GIT, "-C", self.folder, *words]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)

    def commit(self):
        self.git("add", "--all")
        self.git("commit", "--quiet", "--message", "state")

    def replace(self, name, pattern, text, count=0):
        file = self.folder / name
        old = file.read_text(encoding="utf-8")
        new = re.sub(pattern, text, old, count=count)
        self.assertNotEqual(old, new, (name, pattern))
        file.write_text(new, encoding="utf-8")

    def problems(self):
        run = tool("check_release.py", self.folder)
        self.assertDone(run)
        return run.out.splitlines()

    def test_a_checkout_can_be_released_whose_versions_agree(self):
        self.assertEqual(self.problems(), [])

    def test_each_file_with_another_version_is_named(self):
        was = re.escape(version())
        for name in (
            "config/cluster/kubernetes/frames.yaml",
            "config/cluster/kubernetes/pool.yaml",
            "docs/guide/install.md",
            "grabber/package.json",
            "grabber/package-lock.json",
            "voxelserver/page/package.json",
        ):
            with self.subTest(name):
                self.replace(name, was, "7.8.9", 1)
                self.commit()
                found = self.problems()
                self.assertEqual(len(found), 1, found)
                self.assertIn(f"{name} has version 7.8.9", found[0])
                self.git("revert", "--no-edit", "HEAD")

    def test_a_new_version_is_missed_everywhere_else(self):
        self.replace("CMakeLists.txt", rf"VERSION {re.escape(version())}", "VERSION 7.8.9")
        self.commit()
        found = "\n".join(self.problems())
        for name in ("frames.yaml", "pool.yaml", "install.md", "package-lock.json", "CHANGELOG"):
            self.assertIn(name, found)

    def test_a_change_without_a_date_is_named(self):
        self.replace("CHANGELOG.md", r"2026-12-01", "unreleased")
        self.commit()
        self.assertEqual(
            self.problems(),
            [
                f"CHANGELOG.md begins with '{version()}, unreleased'; "
                f"a release wants '{version()}, YYYY-MM-DD'"
            ],
        )

    def test_what_is_not_committed_is_named(self):
        (self.folder / "new file").write_text("x", encoding="utf-8")
        self.replace("CHANGELOG.md", r"\Z", "\nmore\n", 1)
        found = self.problems()
        self.assertEqual(len(found), 2, found)
        self.assertIn("CHANGELOG.md", found[0])
        self.assertIn("new file", found[1])

    def test_this_checkout_misses_no_more_than_its_date_and_commits(self):
        run = tool("check_release.py", ROOT)
        self.assertDone(run)
        lines = run.out.splitlines()
        others = [line for line in lines if not re.match(r"CHANGELOG.md|not committed", line)]
        self.assertEqual(others, [])


class Usage(Case):
    def release(self, *arguments):
        return Run([ROOT / "terravox", "release", *arguments])

    def test_what_it_does_not_know_is_refused(self):
        self.assertRefused(self.release(), 2, "-o FOLDER")
        self.assertRefused(self.release("-o"), 2, "-o FOLDER")
        self.assertRefused(self.release("-o", "x", "--only", "rpm"), 2, "'rpm'", "deb")
        self.assertRefused(self.release("-o", "x", "--only", ""), 2, "--only")
        self.assertRefused(self.release("--check", "x"), 2, "'x'")
        self.assertRefused(self.release("--fast"), 2, "'--fast'")
        self.assertDone(self.release("--help"))


def make_deb(folder):
    stage = folder / "stage"
    files = {
        "DEBIAN/control": "Package: terravox\nVersion: 1.2.3\nArchitecture: all\n"
        "Maintainer: T <t@example.org>\nDepends: libc6 (>= 2.36), tzdata\nDescription: test\n",
        "usr/lib/terravox/grabber/licences.txt": "@scope/one 2.0.1 (MIT)\n\ntext of one\n",
        "usr/share/doc/terravox/licences-page.txt": "two 3.0.0 (BSD-2-Clause)\n\ntext of two\n",
    }
    for name, text in files.items():
        (stage / name).parent.mkdir(parents=True, exist_ok=True)
        (stage / name).write_text(text, encoding="utf-8")
    file = folder / "terravox_1.2.3_all.deb"
    command = ["dpkg-deb", "--root-owner-group", "--build", stage, file]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return file


def make_wheel(folder):
    """With a library that this machine has, as its licence is looked up here."""
    library = next(pathlib.Path("/usr/lib").glob("*/libzstd.so.1.*")).name
    stem, _, rest = library.partition(".so")
    file = folder / "terravox-1.2.3-cp311-cp311-linux_x86_64.whl"
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr(f"terravox.libs/{stem}-0a1b2c3d.so{rest}", "library")
    return file


class Lists(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        folder = temporary_folder()
        cls.files = [make_deb(folder), make_wheel(folder)]
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
        self.assertIn("LASzip", packages)
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

    def test_it_has_the_form_of_spdx(self):
        document = json.loads(self.bill())
        self.assertEqual(document["spdxVersion"], "SPDX-2.3")
        self.assertRegex(document["creationInfo"]["created"], r"^\d{4}-\d\d-\d\dT[\d:]{8}Z$")
        names = [each["SPDXID"] for each in document["packages"]]
        self.assertEqual(len(set(names)), len(names))
        for name in names:
            self.assertRegex(name, r"^SPDXRef-[A-Za-z0-9.-]+$")
        known = {*names, "SPDXRef-DOCUMENT"}
        for each in document["relationships"]:
            self.assertIn(each["spdxElementId"], known)
            self.assertIn(each["relatedSpdxElement"], known)

    def test_the_same_files_make_the_same_list(self):
        self.assertEqual(self.bill(), self.bill())

    def test_licences_of_what_packages_bring_are_there(self):
        file = temporary_folder() / "licences.txt"
        self.assertDone(tool("licences.py", *self.files, "-o", file, *self.third_party))
        text = file.read_text(encoding="utf-8")
        for words in ("# Third-party software", "text of one", "text of two", "libzstd1 (Debian's"):
            self.assertIn(words, text)


def source_archive():
    run = Run(
        [ROOT / "terravox", "package", "sdist", "-o", temporary_folder()],
        environment={"SOURCE_DATE_EPOCH": TIME},
    )
    assert run.code == 0, run
    return pathlib.Path(run.out.strip())


class Sources(Case):
    def test_the_source_archive_holds_what_a_wheel_is_made_of(self):
        file = source_archive()
        top = f"terravox-{version()}"
        with tarfile.open(file) as archive:
            names = set(archive.getnames())
            about = archive.extractfile(f"{top}/PKG-INFO").read().decode()
            project = archive.extractfile(f"{top}/pyproject.toml").read().decode()
        for name in (
            "CMakeLists.txt",
            "LICENSE",
            "build/deps/laszip/src/laszip_dll.cpp",
            "config/materials.toml",
            "raytracer/python/terravox/__init__.py",
            "voxelserver/page/CMakeLists.txt",
        ):
            self.assertIn(f"{top}/{name}", names)
        self.assertEqual([name for name in names if "tests/" in name or "grabber/" in name], [])
        self.assertIn(f"\nVersion: {version()}\n", about)
        self.assertIn('cmake.source-dir = "."', project)
        self.assertNotIn("../", project)

    def test_the_same_commit_makes_the_same_archive(self):
        self.assertEqual(source_archive().read_bytes(), source_archive().read_bytes())


@unittest.skipUnless(LONG, "with --long")
class Draft(Case):
    def test_packages_come_with_lists_and_checksums(self):
        folder = temporary_folder() / "release"
        words = ["release", "-o", folder, "--only", "deb,sdist", "--draft"]
        run = Run(
            [ROOT / "terravox", *words], environment={"TERRAVOX_NO_BUILD": "1"}, timeout_s=7200
        )
        self.assertDone(run)
        names = {file.name for file in folder.iterdir()}
        self.assertIn(f"terravox-{version()}.tar.gz", names)
        self.assertIn(f"terravox-{version()}.spdx.json", names)
        self.assertIn("licences-third-party.txt", names)
        self.assertEqual(sum(name.endswith(".deb") for name in names), 6)
        done = subprocess.run(
            ["sha256sum", "--check", "--strict", "SHA256SUMS"],
            cwd=folder,
            capture_output=True,
            text=True,
            check=False,
        )
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertEqual(done.stdout.count(": OK"), len(names) - 1)


# What a program needs that reads and writes points, without a server's page.
SMALL_BUILD = (
    "-GNinja",
    "-DCMAKE_BUILD_TYPE=Release",
    "-DTERRAVOX_PREVIEW=OFF",
    "-DTERRAVOX_PYTHON=OFF",
    "-DTERRAVOX_TESTS=OFF",
    "-DTERRAVOX_VDB=OFF",
    "-DTERRAVOX_WHEEL=ON",
)
PYTHON = "/usr/bin/python3"
PICTURE = """
import terravox
print(terravox.open("generated:5").render(fields={"output.size": "64x36"}).rgb.shape)
"""


@unittest.skipUnless(LONG, "with --long")
class Compiled(Case):
    """The source archive, where nothing of the checkout is."""

    def compiled_in(self, folder):
        """@return the bytes of a program"""
        folder.mkdir(parents=True)
        with tarfile.open(source_archive()) as archive:
            archive.extractall(folder, filter="data")
        sources = folder / f"terravox-{version()}"
        build = sources / "build" / "small"
        off = {"CCACHE_DISABLE": "1"}
        for command in (
            ["cmake", "-S", sources, "-B", build, *SMALL_BUILD],
            ["cmake", "--build", build, "--target", "terravox-laz"],
        ):
            self.assertDone(Run(command, environment=off, timeout_s=BUILD_S))
        return (build / "bin" / "terravox-laz").read_bytes()

    def test_a_program_has_the_same_bytes_wherever_it_is_compiled(self):
        one = self.compiled_in(temporary_folder() / "one")
        other = self.compiled_in(temporary_folder() / "another" / "longer-name")
        self.assertEqual(one, other)

    def test_pip_makes_a_wheel_of_it(self):
        folder = temporary_folder()
        words = ["wheel", "--no-deps", "--no-cache-dir", "--wheel-dir", folder, source_archive()]
        self.assertDone(Run([PYTHON, "-m", "pip", *words], timeout_s=BUILD_S))
        (wheel,) = folder.glob("terravox-*.whl")
        place = folder / "installed"
        words = ["install", "--no-index", "--no-deps", "--target", place, wheel]
        self.assertDone(Run([PYTHON, "-m", "pip", *words], timeout_s=600))
        installed = {"PYTHONPATH": str(place)}
        run = Run([PYTHON, "-c", PICTURE], cwd=folder, environment=installed)
        self.assertDone(run)
        self.assertEqual(run.out, "(36, 64, 3)\n")


if __name__ == "__main__":
    unittest.main(argv=[a for a in sys.argv if a != "--long"])

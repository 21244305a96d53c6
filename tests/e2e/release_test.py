#!/usr/bin/env python3
"""Releases.

With ./terravox test --all a draft of Debian packages and the source archive is made, and the latter
compiled.
"""

import pathlib
import re
import tarfile
import unittest

from installed import install
from linked import (
    MARKS,
    compiled_in,
    control_fields,
    deb_files,
    marked,
    program_name,
    short_name,
    tables,
)
from releasing import TIME, fetched_licence, version
from support import ROOT, Case, Run, only_in_all, temporary_folder

BUILD_S = 9000
DEBIAN = ROOT / "config" / "debian"
# From the first words of the licences BSD and MIT to their last.
CONDITIONS = r"(?s)Redistribution and use.*?SUCH DAMAGE|Permission is hereby.*?IN THE\W+SOFTWARE"
LIBRARY = "libterravox@SOVERSION@"


class Usage(Case):
    def release(self, *arguments):
        return Run([ROOT / "terravox", "release", *arguments])

    def test_what_it_does_not_know_is_refused(self):
        self.assertRefused(self.release(), 2, "-o FOLDER")
        for words, said in (
            (["--only", "rpm"], "'rpm'"),
            (["--only", "deb,,image"], "''"),
            (["--only", "deb,sdist,deb"], "'deb' twice"),
            (["--only"], "--only"),
            (["--fast"], "'--fast'"),
        ):
            self.assertRefused(self.release("-o", "x", *words), 2, said)
        self.assertDone(self.release("--help"))


def control():
    """@return the fields of each Debian package by its name"""
    text = (DEBIAN / "control").read_text(encoding="utf-8")
    fields = map(control_fields, text.split("\n\n")[1:])
    return {each["Package"]: each for each in fields}


class Dependencies(Case):
    """ADR 30: what has one name follows one version; libraries of several versions can be
    installed next to each other."""

    def test_packages_of_one_name_want_each_other_in_their_own_version(self):
        wanted = {
            "terravox": {"terravox-data"},
            "terravox-preview": {"terravox"},
            "terravox-data": set(),
            LIBRARY: set(),
            "libterravox-dev": {LIBRARY},
            "python3-terravox": {"terravox-data"},
        }
        self.assertEqual(set(control()), set(wanted))
        for name, fields in control().items():
            with self.subTest(name):
                found = re.findall(r"(\S*terravox\S*)( \(.*?\))?", fields.get("Depends", ""))
                exact = {(other, " (= ${binary:Version})") for other in wanted[name]}
                self.assertEqual(set(found), exact)

    def test_a_library_keeps_no_other_version_from_being_installed(self):
        fields = control()[LIBRARY]
        for field in ("Depends", "Pre-Depends", "Conflicts", "Breaks", "Replaces", "Provides"):
            self.assertNotIn("terravox", fields.get(field, ""), field)

    def test_the_files_of_a_library_have_its_version_in_their_names(self):
        prefix = temporary_folder()
        install(prefix, "library")
        files = [str(each.relative_to(prefix)) for each in prefix.rglob("*") if not each.is_dir()]
        minor = version().rpartition(".")[0]
        self.assertIn(f"share/terravox/libterravox.so.{version()}/config/materials.toml", files)
        for name in files:
            self.assertRegex(name, rf"libterravox\.so\.{re.escape(minor)}")


def plain(text):
    """@return its words, without what is only form: case, line breaks, signs of comments"""
    return " ".join(re.findall(r"\w+", text.lower()))


def debian_licence(package):
    """@return the holders of a Debian package's sources, their conditions"""
    file = pathlib.Path("/usr/share/doc") / package / "copyright"
    text = file.read_text(encoding="utf-8")
    first = r"(?ms)^Files: +\*$.*?^Copyright:(.*?)^License: +(.*?)$"
    holders, licence = re.search(first, text).groups()
    conditions = re.search(rf"(?m)^License: +{re.escape(licence)}\n((?: .*\n?)+)", text)[1]
    # An exception that a licence adds is no condition.
    return holders.strip().splitlines(), conditions.partition("--- Optional exception")[0]


class Copyrights(Case):
    """config/debian/copyright, which is in each package, has what the licences of others want."""

    def setUp(self):
        super().setUp()
        self.text = (DEBIAN / "copyright").read_text(encoding="utf-8")
        programs = {program for row in tables()["Compiled in"] for program in row[5].split(", ")}
        # Python's package has its own, and the Python package depends on it.
        rows = compiled_in(tables(), programs - {"tests"})
        self.rows = [row for row in rows if short_name(row) != "Python"]

    def test_everything_that_is_compiled_in_is_named(self):
        self.assertGreater(len(self.rows), 5)
        for row in self.rows:
            self.assertRegex(self.text, rf"(?m)^ \d{{4}}.*\({re.escape(short_name(row))}\)$")

    def test_holders_and_conditions_are_those_that_debian_names(self):
        for name, _, _, package, *_ in self.rows:
            if package:
                with self.subTest(name):
                    holders, conditions = debian_licence(package)
                    for holder in holders:
                        self.assertThere(re.sub(r"^[\d ,-]+|<.*>", "", holder.strip()))
                    self.assertThere(conditions)

    def test_holders_and_conditions_are_those_in_the_sources_that_are_fetched(self):
        for name, count in (("LASzip", 1), ("nanobind", 2)):
            text = fetched_licence(name, ROOT / "build" / "deps")
            holders = re.findall(r"Copyright \(c\) \d+ (?:by )?(\w+ [\w-]+)", text)
            conditions = re.findall(CONDITIONS, text)
            with self.subTest(name):
                self.assertEqual((len(holders), len(conditions)), (count, count))
                for words in holders + conditions:
                    self.assertThere(words)

    def test_each_licence_that_is_named_is_there(self):
        parts = self.text.split("\n\n")
        there = {part.splitlines()[0] for part in parts if part.startswith("License: ")}
        there = {line.removeprefix("License: ") for line in there}
        named = [control_fields(part)["License"] for part in parts if part.startswith("Files: ")]
        self.assertEqual({each for line in named for each in line.split(" and ")}, there)

    def assertThere(self, words):
        self.assertTrue(plain(words) in plain(self.text), words)


def source_archive():
    run = Run(
        [ROOT / "terravox", "package", "sdist", "-o", temporary_folder()],
        environment={"SOURCE_DATE_EPOCH": TIME},
    ).done()
    return pathlib.Path(run.out.strip())


class Sources(Case):
    def test_the_source_archive_holds_what_a_wheel_is_made_of(self):
        file = source_archive()
        top = f"terravox-{version()}"
        with tarfile.open(file) as archive:
            names = set(archive.getnames())
            about = archive.extractfile(f"{top}/PKG-INFO").read().decode()
            project = archive.extractfile(f"{top}/pyproject.toml").read().decode()
        parts = ["CMakeLists.txt", "LICENSE", "build/deps/laszip/src/laszip_dll.cpp"]
        parts += ["config/materials.toml", "raytracer/apps/python/terravox/__init__.py"]
        parts += [f"voxelserver/serve/page/{name}" for name in ("CMakeLists.txt", "appearance.hpp")]
        for name in parts:
            self.assertIn(f"{top}/{name}", names)
        self.assertEqual([name for name in names if "tests/" in name or "grabber/" in name], [])
        self.assertIn(f"\nVersion: {version()}\n", about)
        self.assertIn('cmake.source-dir = "."', project)
        self.assertNotIn("../", project)

    def test_the_same_commit_makes_the_same_archive(self):
        self.assertEqual(source_archive().read_bytes(), source_archive().read_bytes())


@only_in_all
class Draft(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.folder = temporary_folder() / "release"
        words = ["release", "-o", cls.folder, "--only", "deb,sdist", "--draft"]
        Run(
            [ROOT / "terravox", *words], environment={"TERRAVOX_NO_BUILD": "1"}, timeout_s=7200
        ).done()

    def test_packages_come_with_lists_and_checksums(self):
        names = {file.name for file in self.folder.iterdir()}
        self.assertIn(f"terravox-{version()}.tar.gz", names)
        self.assertIn(f"terravox-{version()}.spdx.json", names)
        self.assertIn("licences-third-party.txt", names)
        self.assertEqual(sum(name.endswith(".deb") for name in names), 6)
        done = Run(["sha256sum", "--check", "--strict", "SHA256SUMS"], cwd=self.folder)
        self.assertDone(done)
        self.assertEqual(done.out.count(": OK"), len(names) - 1)

    def test_packages_have_what_the_table_says_and_its_licences(self):
        seen = set()
        for deb in self.folder.glob("*.deb"):
            files = deb_files(deb, "")
            programs = {program_name(name): data for name, data in files.items()}
            programs.pop(None, None)
            seen |= set(programs)
            for name, data in programs.items():
                with self.subTest(f"{deb.name}: {name}"):
                    listed = {short_name(row) for row in compiled_in(tables(), {name})}
                    self.assertEqual(marked(data), listed & set(MARKS))
            package = deb.name.partition("_")[0]
            text = files[f"./usr/share/doc/{package}/copyright"].decode()
            self.assertTrue(text.startswith((DEBIAN / "copyright").read_text(encoding="utf-8")))
        self.assertLessEqual({"raytracer", "worlds.so", "library", "python"}, seen)


# What a program needs that reads and writes points, without a server's page.
SMALL_BUILD = ["-GNinja", "-DCMAKE_BUILD_TYPE=Release", "-DTERRAVOX_WHEEL=ON"]
SMALL_BUILD += [f"-DTERRAVOX_{part}=OFF" for part in ("PREVIEW", "PYTHON", "TESTS", "VDB")]
PYTHON = "/usr/bin/python3"
PICTURE = """
import terravox
print(terravox.open("generated:5").render(fields={"output.size": "64x36"}).rgb.shape)
"""


@only_in_all
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
    unittest.main()

#!/usr/bin/env python3
"""Releases.

With --long a draft of Debian packages and the source archive is made, and the latter compiled.
"""

import pathlib
import re
import subprocess
import sys
import tarfile
import unittest

from installed import install
from linked import control_fields
from releasing import TIME, version
from support import ROOT, Case, Run, temporary_folder

LONG = "--long" in sys.argv
BUILD_S = 9000
DEBIAN = ROOT / "config" / "debian"
LIBRARY = "libterravox@SOVERSION@"


class Usage(Case):
    def release(self, *arguments):
        return Run([ROOT / "terravox", "release", *arguments])

    def test_what_it_does_not_know_is_refused(self):
        self.assertRefused(self.release(), 2, "-o FOLDER")
        self.assertRefused(self.release("-o"), 2, "-o FOLDER")
        self.assertRefused(self.release("-o", "x", "--only", "rpm"), 2, "'rpm'", "deb")
        self.assertRefused(self.release("-o", "x", "--only", ""), 2, "--only")
        self.assertRefused(self.release("-o", "x", "--only", "deb wheel"), 2, "'deb wheel'")
        self.assertRefused(self.release("-o", "x", "--only", "deb,,image"), 2, "''")
        self.assertRefused(self.release("-o", "x", "--only", "deb,sdist,deb"), 2, "'deb' twice")
        self.assertRefused(self.release("-o", "x", "--only"), 2, "--only")
        self.assertRefused(self.release("--check", "x"), 2, "'x'")
        self.assertRefused(self.release("--fast"), 2, "'--fast'")
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

#!/usr/bin/env python3
"""The wheel: what is in it, and whether it works where nothing of this project is.

It compiles GDAL and most of the project, and installs numpy and xarray from the index of Python's
packages. With TERRAVOX_WHEELS, a folder of wheels that are there, it makes none.
"""

import os
import pathlib
import re
import shutil
import subprocess
import unittest
import zipfile

from linked import (
    MARKS,
    WHEEL_MARKS,
    compiled_in,
    compiled_into_wheels,
    marked,
    program_name,
    short_name,
    tables,
    wheel_libraries,
)
from support import ROOT, Case, Run, temporary_folder

MOST_MB = 15
MADE = os.environ.get("TERRAVOX_WHEELS")
# Libraries that only GDAL and libzip are linked with, and so have no row among the shared ones.
OF_LIBRARIES = {"libopenjp2": "OpenJPEG", "libbz2": "bzip2", "libssl": "OpenSSL"}
# What every Linux has by the rules for wheels (manylinux), Python's own zlib among it; the rest
# must be inside.
SYSTEM = re.compile(
    r"(libc|libm|libdl|librt|libpthread|libgcc_s|libstdc\+\+|libz|ld-linux-x86-64)\.so\.\d+"
)
PACKAGE_TEST = ROOT / "tests" / "raytracer" / "apps" / "python" / "package_test.py"


def pythons_for(wheel):
    """@return the names of the Pythons of this machine that a wheel is for, one at least: its own
    version, or with the stable interface of CPython that one and all later ones"""
    _, _, python_tag, abi_tag, _ = wheel.stem.split("-")
    first = int(python_tag.removeprefix("cp3"))
    last = 99 if abi_tag == "abi3" else first
    names = [f"python3.{minor}" for minor in range(first, last + 1)]
    found = [name for name in names if shutil.which(name)]
    assert found, f"{wheel.name}: no Python that it is for is here"
    return found


class Wheel(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.folder = temporary_folder()
        if MADE:
            cls.wheels = sorted(pathlib.Path(MADE).glob("terravox-*.whl"))
        else:
            cls.wheels = cls.make(cls.folder)
        assert cls.wheels, f"no wheel was made, or is in {MADE}"

    @classmethod
    def make(cls, folder):
        Run([ROOT / "terravox", "package", "wheel", "-o", folder], timeout_s=7200).done()
        return sorted(folder.glob("terravox-*.whl"))

    @unittest.skipIf(MADE, "wheels that were there")
    def test_the_same_commit_makes_the_same_bytes(self):
        again = {file.name: file.read_bytes() for file in self.make(temporary_folder())}
        self.assertEqual(again, {file.name: file.read_bytes() for file in self.wheels})

    def test_they_are_small_and_say_what_they_need(self):
        for wheel in self.wheels:
            with self.subTest(wheel.name):
                self.assertLess(wheel.stat().st_size, MOST_MB * 1e6)
                self.assertRegex(wheel.name, r"-manylinux_2_\d+_(x86_64|aarch64)\.whl$")

    def test_one_wheel_of_many_versions_has_no_module_of_one(self):
        # nanobind takes the whole interface without a word where it does not find the stable one.
        for wheel in self.wheels:
            with self.subTest(wheel.name), zipfile.ZipFile(wheel) as archive:
                (core,) = (name for name in archive.namelist() if program_name(name) == "python")
                self.assertEqual(core.endswith("_core.abi3.so"), "-abi3-" in wheel.name, core)

    def test_everything_but_the_system_s_own_is_inside(self):
        folder = temporary_folder()
        with zipfile.ZipFile(self.wheels[0]) as archive:
            archive.extractall(folder)
        objects = [path for path in folder.rglob("*.so*") if path.is_file()]
        inside = {path.name for path in objects}
        self.assertTrue(any(name.startswith("_core") for name in inside))
        for path in objects:
            command = ["readelf", "--dynamic", "--wide", path]
            text = subprocess.run(command, capture_output=True, text=True, check=True).stdout
            for name in re.findall(r"\(NEEDED\).*\[(.+)\]", text):
                self.assertTrue(name in inside or SYSTEM.fullmatch(name), f"{path}: {name}")
        self.assertTrue((folder / "terravox" / "proj" / "proj.db").is_file())
        self.assertTrue((folder / "terravox" / "config" / "materials.toml").is_file())
        text = (folder / "terravox" / "licences" / "third-party.txt").read_text(encoding="utf-8")
        for words in ("Martin Isenburg", "Frank Warmerdam", "libzstd1 (Debian's"):
            self.assertIn(words, text)

    def test_what_is_compiled_in_is_listed(self):
        listed = {short_name(row) for row in compiled_in(tables(), {"python"})}
        wheels_own = {short_name(row) for row in compiled_into_wheels(tables())}
        for wheel in self.wheels:
            with self.subTest(wheel.name), zipfile.ZipFile(wheel) as archive:
                (core,) = (name for name in archive.namelist() if program_name(name) == "python")
                data = archive.read(core)
                self.assertEqual(marked(data), listed & set(MARKS))
                found = {name for name, mark in WHEEL_MARKS.items() if mark in data}
                self.assertEqual(found, wheels_own)

    def test_the_libraries_inside_are_listed(self):
        rows = [row for row in tables()["In the wheel"] if row[2] == "terravox.libs"]
        listed = {name for row in rows for name in row[0].split(", ")}
        owners = {row[0]: row[1] for row in tables()["Shared libraries"]} | OF_LIBRARIES
        owners["libdate-tz"] = "date"
        for wheel in self.wheels:
            with self.subTest(wheel.name):
                stems = {
                    re.sub(r"(-[0-9a-f]{8})?\.so.*", "", name) for name in wheel_libraries(wheel)
                }
                self.assertEqual({owners.get(stem, stem) for stem in stems}, listed)

    def test_the_package_s_tests_pass_with_it(self):
        for wheel in self.wheels:
            for version in pythons_for(wheel):
                with self.subTest(f"{wheel.name} with {version}"):
                    python = self.installed(version, wheel)
                    run = Run(
                        [python, "-B", PACKAGE_TEST],
                        environment={"PATH": os.environ["PATH"], "HOME": str(self.folder)},
                        timeout_s=3600,
                    )
                    self.assertEqual(run.code, 0, run)

    def installed(self, python, wheel):
        """@return the Python of a new environment that has the wheel"""
        folder = temporary_folder() / "environment"
        self.assertDone(Run([python, "-m", "venv", folder], timeout_s=600))
        new = folder / "bin" / "python"
        self.assertDone(Run([new, "-m", "pip", "install", "--quiet", wheel], timeout_s=1800))
        return new


if __name__ == "__main__":
    unittest.main()

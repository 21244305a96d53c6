#!/usr/bin/env python3
"""The wheel: what is in it, and whether it works where nothing of this project is.

It compiles GDAL and most of the project, and installs numpy and xarray from the index of Python's
packages.
"""

import os
import re
import subprocess
import sys
import unittest
import zipfile

from support import ROOT, Case, Run, temporary_folder

MOST_MB = 15
# What every Linux has by the rules for wheels (manylinux), Python's own zlib among it; the rest
# must be inside.
SYSTEM = re.compile(
    r"(libc|libm|libdl|librt|libpthread|libgcc_s|libstdc\+\+|libz|ld-linux-x86-64)\.so\.\d+"
)


class Wheel(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.folder = temporary_folder()
        cls.wheels = cls.make(cls.folder)
        assert cls.wheels, "no wheel was made"

    @classmethod
    def make(cls, folder):
        run = Run([ROOT / "terravox", "package", "wheel", "-o", folder], timeout_s=7200)
        assert run.code == 0, run
        return sorted(folder.glob("terravox-*.whl"))

    def test_the_same_commit_makes_the_same_bytes(self):
        again = {file.name: file.read_bytes() for file in self.make(temporary_folder())}
        self.assertEqual(again, {file.name: file.read_bytes() for file in self.wheels})

    def test_they_are_small_and_say_what_they_need(self):
        for wheel in self.wheels:
            with self.subTest(wheel.name):
                self.assertLess(wheel.stat().st_size, MOST_MB * 1e6)
                self.assertRegex(wheel.name, r"-manylinux_2_\d+_(x86_64|aarch64)\.whl$")

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

    def test_the_package_s_tests_pass_with_it(self):
        for wheel in self.wheels:
            version = re.search(r"-cp3(\d+)-", wheel.name)[1]
            with self.subTest(version):
                python = self.installed(f"python3.{version}", wheel)
                run = Run(
                    [python, "-B", ROOT / "tests" / "raytracer" / "python" / "package_test.py"],
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
    sys.argv = [argument for argument in sys.argv if argument != "--long"]
    unittest.main()

#!/usr/bin/env python3
"""The types of the Python package: what mypy says of it, and of programs that use it."""

import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import terravox

RIGHT = """
import numpy as np
import terravox

world = terravox.open(["a.laz"], voxel_m=0.5)
heights = world.surface((0, 0, 10, 10)).values
voxels = terravox.from_voxels(np.zeros((2, 2, 2), np.uint8)).voxels()
distance = world.cast((0.0, 0.0, 9.0), (0, 0, -1)).distance.max()
names: list[str] = [material.name for material in terravox.MATERIALS]
"""
WRONG = {
    "terravox.open(3)": "arg-type",
    "terravox.open('a.laz', voxel='small')": "call-arg",
    "terravox.open('a.laz').surfaces()": "attr-defined",
    "number: int = terravox.open('a.laz').crs": "assignment",
}


@unittest.skipUnless(shutil.which("mypy"), "mypy is not installed")
class Types(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="terravox-python-")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)

    def mypy(self, path):
        command = ["mypy", "--strict", "--python-executable", sys.executable]
        command += ["--cache-dir", self.folder / "cache", path]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    def program(self, text):
        file = self.folder / "program.py"
        file.write_text(text, encoding="utf-8")
        return file

    def test_the_package_has_none_that_are_wrong(self):
        done = self.mypy(pathlib.Path(terravox.__file__).parent)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_programs_are_checked(self):
        done = self.mypy(self.program(RIGHT))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        lines = list(WRONG)
        done = self.mypy(self.program("import terravox\n" + "\n".join(lines) + "\n"))
        for number, line in enumerate(lines, 2):
            self.assertRegex(done.stdout, rf"program.py:{number}: error: .*\[{WRONG[line]}\]")


if __name__ == "__main__":
    unittest.main()

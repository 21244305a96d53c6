#!/usr/bin/env python3
"""The installed library: the examples are built against it and run, without the checkout."""

import json
import os
import re
import shutil
import struct
import subprocess
import unittest
import urllib.request

from installed import hidden, install
from support import ROOT, Case, Run, square, temporary_folder

EXAMPLES = ROOT / "docs" / "examples" / "cpp"
# What a name of the library's may begin with.
PUBLIC = re.compile(
    r"(typeinfo name for |typeinfo for |vtable for )?terravox::"
    r"(World|Server|VoxelSource|PointSource|Error|UsageError|Stopped|make_survey|materials"
    r"|set_log_level|version)\b"
)


class Library(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        made = temporary_folder() / "made"
        install(made, "library", "development")
        cls.prefix = temporary_folder() / "a prefix"
        made.rename(cls.prefix)
        cls.library = next(cls.prefix.rglob("libterravox.so"))
        cls.sources = temporary_folder() / "sources"
        shutil.copytree(EXAMPLES, cls.sources)
        cls.folder = temporary_folder()
        words = ["cmake", "-S", cls.sources, "-B", cls.folder, f"-DCMAKE_PREFIX_PATH={cls.prefix}"]
        words += ["-DCMAKE_BUILD_TYPE=Release"]
        for command in (words, ["cmake", "--build", cls.folder]):
            run = Run([*hidden(), *command], cwd=cls.sources)
            if run.code != 0:
                raise AssertionError(run.out + run.err)

    def run_example(self, name, *arguments):
        run = Run([*hidden(), self.folder / name, *arguments], cwd=self.folder)
        self.assertDone(run)
        return run.out

    def test_a_picture_is_rendered(self):
        picture = self.folder / "picture.ppm"
        out = self.run_example("render_a_picture", square(), picture)
        self.assertIn("640 x 360 pixels", out)
        data = picture.read_bytes()
        self.assertTrue(data.startswith(b"P6\n640 360\n255\n"))
        self.assertEqual(len(data), 15 + 640 * 360 * 3)
        self.assertGreater(len(set(data[15:])), 50)

    def test_a_world_of_ones_own_is_written(self):
        model = self.folder / "sphere.glb"
        out = self.run_example("world_of_your_own", model)
        self.assertGreater(int(out.split()[0]), 20_000)
        magic, version, length = struct.unpack("<4sII", model.read_bytes()[:12])
        self.assertEqual((magic, version, length), (b"glTF", 2, model.stat().st_size))

    def test_points_of_ones_own_are_voxelized(self):
        rows = [line.split() for line in self.run_example("points_of_your_own").splitlines()]
        heights = {float(one) for row in rows for one in row}
        self.assertIn(301.0, heights)
        self.assertIn(308.0, heights)

    def test_rays_of_ones_own_are_cast(self):
        lines = self.run_example("rays_of_your_own", square()).splitlines()
        self.assertEqual(len(lines), 16)
        self.assertTrue(any(re.search(r": (grass|ground|high_vegetation)", line) for line in lines))

    def test_a_world_is_served(self):
        words = [*hidden(), self.folder / "serve_a_world", square()]
        pipe = subprocess.PIPE
        with subprocess.Popen(words, cwd=self.folder, stdin=pipe, stdout=pipe, text=True) as server:
            address = server.stdout.readline().strip()
            self.assertRegex(address, r"^http://127\.0\.0\.1:\d+$")
            with urllib.request.urlopen(address + "/v2/world") as reply:
                self.assertIn("levels", json.load(reply))
            with urllib.request.urlopen(address + "/") as reply:
                self.assertIn(b"<html", reply.read())
            server.communicate()
        self.assertEqual(server.returncode, 0)

    def test_a_failure_is_told(self):
        run = Run([self.folder / "rays_of_your_own", self.folder / "nothing.laz"])
        self.assertEqual(run.code, 1)
        self.assertIn("nothing.laz does not exist", run.err)

    def test_only_the_interface_is_visible(self):
        command = ["nm", "--dynamic", "--demangle", "--defined-only", self.library]
        names = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        seen = [line.split(maxsplit=2)[2] for line in names.splitlines()]
        self.assertGreater(len(seen), 20)
        others = [name for name in seen if not PUBLIC.match(name) and "TERRAVOX_" not in name[:9]]
        self.assertEqual(others, [])

    def test_pkg_config_names_what_a_compiler_needs(self):
        if shutil.which("pkg-config") is None:
            self.skipTest("pkg-config is missing")
        environment = {**os.environ, "PKG_CONFIG_PATH": str(self.library.parent / "pkgconfig")}
        command = ["pkg-config", "--cflags", "--libs", "terravox"]
        run = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
        self.assertIn("-lterravox", run.stdout)
        self.assertIn("include", run.stdout)
        self.assertTrue((self.prefix / "include" / "terravox" / "terravox.hpp").is_file())


if __name__ == "__main__":
    unittest.main()

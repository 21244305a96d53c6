#!/usr/bin/env python3
"""Invalid input is refused in one line, with the right exit code, and leaves nothing behind.

1 = failed, 2 = wrong usage.
"""

import os
import resource
import struct
import unittest

import mistakes
from support import Case, Run, binary, entries, render, square, temporary_folder

SMALL = ["--size", "48x27", "--samples", "1", "--quiet"]


def laz_with_bytes(folder, name, data):
    (folder / name).write_bytes(data)
    return folder / name


def ply(points):
    """A binary PLY of (east, north, height, class), somewhere in France."""
    header = (
        "ply\nformat binary_big_endian 1.0\ncomment crs EPSG:2154\n"
        f"element vertex {len(points)}\nproperty double x\nproperty double y\n"
        "property double z\nproperty uchar classification\nend_header\n"
    )
    return header.encode() + b"".join(struct.pack(">dddB", *point) for point in points)


HILL = [
    (770_000.25 + x / 2, 6_277_000.25 + y / 2, 150 + x / 20, 2)
    for x in range(120)
    for y in range(120)
]


class BadInput(Case):
    def setUp(self):
        self.inputs = temporary_folder()
        self.out = temporary_folder()
        self.picture = self.out / "a.png"

    def refused(self, code, *said, arguments):
        run = render(*arguments, *SMALL, *([] if "-o" in arguments else ["-o", self.picture]))
        self.assertRefused(run, code, *said)
        self.assertEqual(entries(self.out), [])

    def test_inputs(self):
        whole = square().read_bytes()
        (self.inputs / "empty").mkdir()
        no_crs = bytearray(whole)
        at = no_crs.find(b"LASF_Projection")
        self.assertGreater(at, 0)
        no_crs[at : at + 4] = b"NONE"

        def made(name, data):
            return laz_with_bytes(self.inputs, name, data)

        cases = {
            "missing file": (2, [self.inputs / "none.laz"], "none.laz"),
            "empty folder": (2, [self.inputs / "empty"], "empty"),
            "an empty file": (1, [made("zero.laz", b"")], "zero.laz"),
            "one good, one cut": (1, [square(), made("cut2.laz", whole[:-5000])], "cut2.laz"),
            "no CRS": (2, [made("nowhere.laz", bytes(no_crs))], "--crs EPSG:"),
            "an address and files": (2, [square(), "http://127.0.0.1:1"], "http://127.0.0.1:1"),
            "orthophoto missing": (2, [square(), "--ortho", self.inputs / "none.tif"], "none.tif"),
            "orthophoto that is no image": (
                1,
                [square(), "--ortho", made("bad.tif", b"no image")],
                "bad.tif",
            ),
        }
        for name, (code, arguments, said) in cases.items():
            with self.subTest(name):
                self.refused(code, said, arguments=arguments)

    def test_ply(self):
        whole = ply(HILL)
        good = laz_with_bytes(self.inputs, "good.ply", whole)
        for code, data, said in (
            (1, whole[:-100], "14400 points promised; at most 14396"),
            (2, whole.replace(b"comment crs EPSG:2154\n", b""), "--crs EPSG:"),
        ):
            with self.subTest(said):
                bad = laz_with_bytes(self.inputs, "bad.ply", data)
                self.refused(code, said, "bad.ply", arguments=[bad])
        self.assertDone(render(good, *SMALL, "-o", self.picture))
        self.assertGreater(self.picture.stat().st_size, 500)
        archive = self.out / "hill.tvx"
        self.assertDone(Run([binary("RAYTRACER"), "convert", good, archive, "--quiet"]))
        again = self.out / "again.png"
        self.assertDone(render(archive, *SMALL, "-o", again))
        self.assertAlike(self.picture, again)

    def test_flags(self):
        for flags, said in (
            (["--sun-light", "1e39,1,1"], "--sun-light = 1e+39; allowed: 0 to 1e+06"),
            (
                ["--steps", "-houses"],
                "'-houses' is no step; allowed: all, none, water_equalization",
            ),
            (["--classes", "nonsense"], "asprs"),
            (["--scene", self.inputs / "none.toml"], "none.toml"),
            (["--voxel", "0"], "--voxel = 0; allowed: 0.01 to 1000"),
        ):
            with self.subTest(said):
                self.refused(2, said, arguments=[square(), *flags])

    def test_outputs(self):
        (self.inputs / "file").write_text("in the way")
        for name, (code, target, said) in {
            "unknown ending": (2, self.out / "a.bmp", "allowed: .png .jpg "),
            "a folder with an ending": (2, self.inputs / "dir.png", "this is a folder"),
            "a file as the folder": (1, self.inputs / "file" / "a.png", "file"),
            "a place that cannot be": (1, "/proc/terravox/a.png", "/proc/terravox"),
        }.items():
            with self.subTest(name):
                (self.inputs / "dir.png").mkdir(exist_ok=True)
                self.refused(code, said, arguments=[square(), "-o", target])
        self.assertEqual((self.inputs / "file").read_text(), "in the way")

    def test_one_of_two_outputs_that_cannot_be_written_stops_before_any_work(self):
        self.refused(
            1,
            "/proc/terravox",
            arguments=[square(), "-o", self.picture, "-o", "/proc/terravox/a.exr"],
        )

    @unittest.skipIf(os.geteuid() == 0, "root may write everywhere")
    def test_a_folder_without_permission(self):
        self.out.chmod(0o555)
        try:
            self.refused(1, "not writable", arguments=[square()])
        finally:
            self.out.chmod(0o755)

    def test_a_full_disk(self):
        for ending in (".png", ".exr", ".tif", ".jpg"):
            with self.subTest(ending):
                target = self.out / ("a" + ending)
                target.write_text("older")
                words = ["--size", "160x90", "--samples", "1", "--quiet", "-o", target]
                run = render(square(), *words, limits=[(resource.RLIMIT_FSIZE, 4096)])
                self.assertRefused(run, 1, target.name)
                self.assertEqual(entries(self.out), [target.name], "something was left behind")
                self.assertEqual(target.read_bytes(), b"older")
                target.unlink()


class Mistakes(Case):
    def test_the_message_of_a_plausible_mistake_names_the_remedy(self):
        files, out = mistakes.wrong_files(), temporary_folder()
        for mistake in mistakes.read_mistakes():
            if mistake.is_test:
                with self.subTest(mistake.line):
                    ended, missing = mistakes.run(mistake, files, out)
                    self.assertRefused(ended, mistake.code)
                    self.assertEqual(missing, [], str(ended))
        self.assertEqual(entries(out), [])


if __name__ == "__main__":
    unittest.main()

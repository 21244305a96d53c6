#!/usr/bin/env python3
"""An archive whose index is empty is a world of air, however wide its bounds are."""

import json
import unittest

from pictures import Picture
from raw_archive import made_up_facts, write_archive
from support import Case, Run, Server, binary, render, temporary_folder

WIDTH = 64
HEIGHT = 36
FLAGS = ["--size", f"{WIDTH}x{HEIGHT}", "--samples", "1", "--look", "plain", "--quiet"]
# Edges in boxes: as wide as the format allows, and of one box. With their numbers of levels.
WORLDS = {"wide": (1 << 19, 20), "of one box": (1, 1)}
# Of boxes that a ray may have to look into: some of the coarsest levels.
MOST_BOXES = 64


def archive(*arguments):
    return Run([binary("ARCHIVE"), *arguments])


class EmptyArchive(Case):
    @classmethod
    def setUpClass(cls):
        cls.folder = temporary_folder()
        cls.files = {}
        for name, (side, levels) in WORLDS.items():
            cls.files[name] = cls.folder / f"{side}.tvx"
            bounds = [0, 0, 0], [64 * side, 256, 64 * side]
            write_archive(cls.files[name], made_up_facts(bounds, levels))

    def setUp(self):
        self.out = temporary_folder()

    def assertSky(self, file):
        picture = Picture(file)
        self.assertEqual((picture.width, picture.height), (WIDTH, HEIGHT))
        self.assertEqual(set(picture.channel("Z")), {float("inf")})
        self.assertEqual(set(picture.channel("A")), {0})
        self.assertGreater(min(picture.channel("B")), 0, "the sky has no light")

    def assertFewBoxes(self, report):
        said = json.loads(report.read_text())
        loaded = sum(level["loaded"] for level in said["boxes"]["levels"])
        self.assertLessEqual(loaded, MOST_BOXES)
        self.assertEqual((said["holes"], said["damage"]), (0, []))

    def test_pictures_show_the_sky_alone_and_load_few_boxes(self):
        for name, file in self.files.items():
            with self.subTest(name):
                picture, report = self.out / "a.exr", self.out / "report.json"
                flags = ["--layers", "all", "--integrator", "path", "--report", report]
                self.assertDone(render(file, *FLAGS, *flags, "-o", picture))
                self.assertSky(picture)
                self.assertFewBoxes(report)

    def test_it_is_described_and_found_to_be_whole(self):
        for name, file in self.files.items():
            with self.subTest(name):
                self.assertDone(archive("verify", file))
                said = archive("info", "--json", file)
                self.assertDone(said)
                nothing = {"boxes": 0, "holes": 0, "bytes": 0}
                levels = WORLDS[name][1]
                self.assertEqual(json.loads(said.out)["levels"], [nothing] * levels)
                said = Run([binary("RAYTRACER"), "world", "info", file])
                self.assertDone(said)
                self.assertIn("made up", said.out)

    def test_it_is_served_as_air(self):
        for name, file in self.files.items():
            with self.subTest(name), Server(file, "--cache", "none") as server:
                world = server.json("/v2/world")
                top = world["levels"] - 1
                for box in ("0/0/0/0", f"{top}/0/0/0"):
                    status, _, body = server.get(f"/v2/boxes/{box}")
                    self.assertEqual((status, body), (204, b""), box)
                self.assertEqual(server.get("/map/0/0/0.png")[0], 200)
                self.assertEqual(server.get("/v2/archive.tvx")[2], file.read_bytes())
                picture = self.out / "served.exr"
                run = render(server.url, *FLAGS, "--layers", "all", "-o", picture)
                self.assertDone(run)
                self.assertSky(picture)


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
"""A Luanti world, as a user has it: described, rendered, converted, and refused."""

import contextlib
import json
import shutil
import sqlite3
import unittest

from luanti_world import write_world
from support import Case, Run, binary, render, temporary_folder

SMALL = ["--size", "160x90", "--samples", "1", "--quiet"]


def spoil(world, position, blob):
    with contextlib.closing(sqlite3.connect(world / "map.sqlite")) as database:
        database.execute("UPDATE blocks SET data = ? WHERE pos = ?", (blob, position))
        database.commit()


def info(*arguments):
    return Run([binary("RAYTRACER"), "world", "info", *arguments])


def convert(*arguments):
    return Run([binary("RAYTRACER"), "convert", *arguments, "--quiet"])


class Luanti(Case):
    @classmethod
    def setUpClass(cls):
        cls.made = write_world(temporary_folder() / "isle")

    def setUp(self):
        self.out = temporary_folder()
        self.world = shutil.copytree(self.made, self.out / "isle")

    def test_a_world_is_described(self):
        run = info(self.world)
        self.assertEqual(run.code, 0, str(run))
        for said in (
            "format: Luanti map in SQLite, key pos",
            "name: Isle",
            "game: minetest",
            "map blocks: 320: 0 damaged, 125 of nothing but air",
            "serialization: 320 version 28",
            "extent: x -64 to 63, y -32 to 21, z -64 to 63 (128 x 54 x 128 nodes)",
        ):
            self.assertIn(said, run.out)
        facts = json.loads(info(self.world / "map.sqlite", "--json").out)
        self.assertEqual(facts["name"], "Isle")
        self.assertEqual(facts["extent"], {"min": [-64, -32, -64], "max": [64, 22, 64]})
        self.assertRefused(info(self.world, "--blocks"), 2, "is a Luanti world")

    def test_a_world_becomes_a_picture_and_an_archive_that_gives_the_same(self):
        picture = self.out / "isle.png"
        flags = [*SMALL, "--detail", "0"]
        run = render(self.world, *flags, "-o", picture)
        self.assertEqual(run.code, 0, str(run))
        archive = self.out / "isle.tvx"
        self.assertEqual(convert(self.world, archive).code, 0)
        copy = self.out / "copy.png"
        self.assertEqual(render(archive, *flags, "-o", copy).code, 0)
        self.assertAlike(picture, copy, exact=True)

    def test_a_damaged_block_is_reported_and_the_rest_is_shown(self):
        spoil(self.world, 0, b"\x1d\x00\x01")
        reason = "map block (0, 0, 0): broken zstd data"
        run = info(self.world)
        self.assertEqual(run.code, 3, str(run))
        self.assertIn(f"damaged: {reason}", run.out)
        run = render(self.world, *SMALL, "-o", self.out / "hole.png")
        self.assertEqual(run.code, 3, str(run))
        self.assertIn(reason, run.err)


if __name__ == "__main__":
    unittest.main()

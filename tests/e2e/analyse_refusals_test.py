#!/usr/bin/env python3
"""What `terravox analyse` refuses: in one line, with nothing left behind."""

import unittest

from analysing import YEAR, analyse, area, area_flag, observer
from support import Case, Run, binary, entries, square, temporary_folder


class Refusals(Case):
    def test_what_cannot_be_is_refused_in_one_line_with_nothing_left_behind(self):
        west, south, east, north = area()
        # Each of the square, to a.tif.
        cases = {
            "cells smaller than voxels": ("terrain --resolution 0.5", "allowed: 1"),
            "an area elsewhere": ("sky --area 0,0,10,10", "--area within"),
            "an area upside down": (["sky", "--area", f"{east},{north},{west},{south}"], "--area"),
            "a level that is not there": ("sky --level 19", "level"),
            "an even window": ("terrain --window 4", "odd"),
            "no light": ("terrain --light 400,1", "--light"),
            "tiles that no TIFF has": (["sky", *area_flag(), "--tile", "20"], "multiples of 16"),
            "a period without end": ("sun --from 2026-01-01", "analysis.to is missing"),
            "a day and a period": (
                ["sun", *YEAR, "--date", "2026-01-01"],
                "--date together with --from",
            ),
            "an instant of a period": (
                ["sun", *YEAR, "--at", "12:00"],
                "--at together with --from",
            ),
            "months of a day": ("sun --monthly", "--from and --to"),
            "a time that is none": ("sun --at 25:00", "--at 25:00; allowed: HH:MM"),
            "one of several times that is none": (
                "sun --times 08:00,8",
                "--times 8; allowed: HH:MM",
            ),
            "a time twice": ("sun --times 08:00,08:00", "--times has 0800 twice"),
            "a day of times that is none": (
                "sun --times 2026-02-30T08:00",
                "'2026-02-30' is no day of the calendar",
            ),
            "more times than bands": (
                ["sun", "--times", ",".join(["08:00"] * 97)],
                "more than 96 times",
            ),
            "several times and one": ("sun --times 08:00 --at 08:00", "--times together with --at"),
            "times of a period": (
                ["sun", "--times", "08:00", *YEAR],
                "--times together with --from",
            ),
            "times that go on": ("sun --times 08:00 --resume", "--times together with --resume"),
            "a map of times": (
                "sun --times 08:00 --map a.png",
                "--times together with --report or --map",
            ),
            "two centuries of minutes": (
                "sun --step-min 1 --from 1900-01-01 --to 2100-12-31",
                "allowed: up to 1000000",
            ),
            "a report of no page": ("sky --report a.pdf", "allowed: .html"),
            "a map of no picture": ("sky --map a.jpg", "allowed: .png"),
            "air that is none": ("energy --linke 0.5", "analysis.linke = '0.5'; allowed"),
            "surroundings brighter than light": ("energy --albedo 1.5", "0 to 1"),
            "crowns brighter than light": (
                "energy --crown-light 0.1,1.5",
                "analysis.crown_light = '0.1,1.5'; allowed",
            ),
            "objects that are no GeoPackage": ("energy --objects a.shp", "allowed: .gpkg"),
            "objects on the ground": (
                "energy --objects a.gpkg --surface ground",
                "--surface top, or --polygons",
            ),
            "facades that are no GeoPackage": (
                "energy --facades a.gml",
                "write the facades a.gml: the ending '.gml'; allowed: .gpkg",
            ),
            "facades on the ground": (
                "energy --facades a.gpkg --surface ground",
                "--facades with --surface ground",
            ),
            "facades of a part": (
                "energy --facades a.gpkg --part 1/2",
                "--facades together with --part",
            ),
            "storeys of nothing": ("energy --facades a.gpkg --storey-m 0.2", "allowed: 1 to 1000"),
            "polygons of nothing": ("energy --polygons a.geojson", "--polygons without --objects"),
            "polygons that are none": (
                ["energy", "--objects", "a.gpkg", "--polygons", square()],
                "read the GeoJSON file",
                1,
            ),
            "options of the other kind": ("terrain --directions 64", "--directions"),
            "no observer": (["sight"], "--observer"),
            "a file of observers that is none": (
                ["sight", "--observers", square()],
                "read the GeoJSON file",
                1,
            ),
            "an observer elsewhere": ("sight --observer 1,2,3", "outside of the data; allowed: E "),
            "an observer inside rock": (
                ["sight", "--observer", f"{west + 5},{south + 5},1"],
                "the top there",
            ),
            "an observer of two numbers": (
                ["sight", "--observer", f"{west + 5},{south + 5}"],
                "above-ground",
            ),
            "too many observers": (
                ["sight", *["--observer", f"{west + 5},{south + 5},+2"] * 1025],
                "1 to 1024",
            ),
            "refraction that no air has": (
                ["sight", *observer(), "--refraction", "2"],
                "refraction",
            ),
            "a planned object elsewhere": (
                "terrain --add 0,0,10,10,500",
                "outside of the data; allowed: within",
            ),
            "a planned object without a height": ("terrain --add 0,0,10,10", "TOP"),
        }
        for name, (words, says, *code) in cases.items():
            kind, *flags = words.split() if isinstance(words, str) else words
            self.refused(name, [kind, square(), "-o", "a.tif", *flags], says, *code)
        cases = {
            "no output": (["terrain", square()], "--output"),
            "another format": (["terrain", square(), "-o", "a.png"], ".tif"),
            "one instant of a cube by two names": (
                ["sun", square(), "-o", "a.nc", "--times", "08:00,2026-06-21T08:00"],
                "--times has one instant as sunlit_0800 and sunlit_2026-06-21T0800",
            ),
            "a cube of one instant": (["sun", square(), "-o", "a.nc"], "allowed: .tif .tiff"),
            "energy of no place": (["energy", "generated:3", "-o", "a.tif"], "no place on Earth"),
            "no kind": ([], "a command is missing; allowed: terrain, sky"),
        }
        for name, case in cases.items():
            self.refused(name, *case)

    def refused(self, name, arguments, says, code=2):
        with self.subTest(name):
            folder = temporary_folder()
            run = analyse(*arguments, "--quiet", cwd=folder) if arguments else analyse()
            self.assertEqual((run.code, run.out), (code, ""), run)
            self.assertIn(says, run.err)
            self.assertEqual(entries(folder), [])

    def test_a_picture_of_an_analysis_is_refused(self):
        folder = temporary_folder()
        (folder / "sky.toml").write_text('[analysis]\nkind = "sky"\n', encoding="utf-8")
        run = Run(
            [binary("RAYTRACER"), "render", square(), "--scene", "sky.toml", "-o", "a.png"],
            cwd=folder,
        )
        self.assertEqual(run.code, 2, run)
        self.assertIn("terravox analyse", run.err)

    def test_data_that_is_no_world_ends_with_one_line(self):
        folder = temporary_folder()
        (folder / "a.laz").write_bytes(b"no points")
        run = analyse("sky", "a.laz", "-o", "a.tif", "--quiet", cwd=folder)
        self.assertNotEqual(run.code, 0)
        self.assertEqual(len(run.err.strip().splitlines()), 1, run)
        self.assertEqual(entries(folder), ["a.laz"])


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
"""What `terravox analyse` refuses: in one line, with nothing left behind."""

import unittest

from analysing import YEAR, analyse, area, area_flag, observer
from support import Case, Run, binary, entries, square, temporary_folder


class Refusals(Case):
    def test_what_cannot_be_is_refused_in_one_line_with_nothing_left_behind(self):
        west, south, east, north = area()
        cases = {
            "no output": (["terrain", square()], "--output"),
            "another format": (["terrain", square(), "-o", "a.png"], ".tif"),
            "cells smaller than voxels": (
                ["terrain", square(), "-o", "a.tif", "--resolution", "0.5"],
                "allowed: 1",
            ),
            "an area elsewhere": (
                ["sky", square(), "-o", "a.tif", "--area", "0,0,10,10"],
                "--area within",
            ),
            "an area upside down": (
                ["sky", square(), "-o", "a.tif", "--area", f"{east},{north},{west},{south}"],
                "--area",
            ),
            "an area of three": (["sky", square(), "-o", "a.tif", "--area", "1,2,3"], "--area"),
            "a level that is not there": (
                ["sky", square(), "-o", "a.tif", "--level", "19"],
                "level",
            ),
            "an even window": (["terrain", square(), "-o", "a.tif", "--window", "4"], "odd"),
            "no light": (["terrain", square(), "-o", "a.tif", "--light", "400,1"], "--light"),
            "tiles that no TIFF has": (
                ["sky", square(), *area_flag(), "-o", "a.tif", "--tile", "20"],
                "multiples of 16",
            ),
            "a day that is none": (["sun", square(), "-o", "a.tif", "--date", "2026-02-30"], "day"),
            "a zone that is none": (
                ["sun", square(), "-o", "a.tif", "--zone", "Europe/Atlantis"],
                "Atlantis",
            ),
            "a period without end": (
                ["sun", square(), "-o", "a.tif", "--from", "2026-01-01"],
                "analysis.to is missing",
            ),
            "a period backwards": (
                ["sun", square(), "-o", "a.tif", "--from", "2026-02-01", "--to", "2026-01-01"],
                "not before",
            ),
            "a day and a period": (
                ["sun", square(), "-o", "a.tif", *YEAR, "--date", "2026-01-01"],
                "--date together with --from",
            ),
            "an instant of a period": (
                ["sun", square(), "-o", "a.tif", *YEAR, "--at", "12:00"],
                "--at together with --from",
            ),
            "months of a day": (["sun", square(), "-o", "a.tif", "--monthly"], "--from and --to"),
            "a time that is none": (
                ["sun", square(), "-o", "a.tif", "--at", "25:00"],
                "--at 25:00; allowed: HH:MM",
            ),
            "one of several times that is none": (
                ["sun", square(), "-o", "a.tif", "--times", "08:00,8"],
                "--times 8; allowed: HH:MM",
            ),
            "a time twice": (
                ["sun", square(), "-o", "a.tif", "--times", "08:00,08:00"],
                "--times has 0800 twice",
            ),
            "one instant of a cube by two names": (
                ["sun", square(), "-o", "a.nc", "--times", "08:00,2026-06-21T08:00"],
                "--times has one instant as sunlit_0800 and sunlit_2026-06-21T0800",
            ),
            "a cube of one instant": (["sun", square(), "-o", "a.nc"], "allowed: .tif .tiff"),
            "a day of times that is none": (
                ["sun", square(), "-o", "a.tif", "--times", "2026-02-30T08:00"],
                "'2026-02-30' is no day of the calendar",
            ),
            "more times than bands": (
                ["sun", square(), "-o", "a.tif", "--times", ",".join(["08:00"] * 97)],
                "more than 96 times",
            ),
            "several times and one": (
                ["sun", square(), "-o", "a.tif", "--times", "08:00", "--at", "08:00"],
                "--times together with --at",
            ),
            "times of a period": (
                ["sun", square(), "-o", "a.tif", "--times", "08:00", *YEAR],
                "--times together with --from",
            ),
            "times that go on": (
                ["sun", square(), "-o", "a.tif", "--times", "08:00", "--resume"],
                "--times together with --resume",
            ),
            "a map of times": (
                ["sun", square(), "-o", "a.tif", "--times", "08:00", "--map", "a.png"],
                "--times together with --report or --map",
            ),
            "two centuries of minutes": (
                [
                    *["sun", square(), "-o", "a.tif", "--step-min", "1"],
                    *["--from", "1900-01-01", "--to", "2100-12-31"],
                ],
                "allowed: up to 1000000",
            ),
            "a report of no page": (
                ["sky", square(), "-o", "a.tif", "--report", "a.pdf"],
                "allowed: .html",
            ),
            "a map of no picture": (
                ["sky", square(), "-o", "a.tif", "--map", "a.jpg"],
                "allowed: .png",
            ),
            "air that is none": (
                ["energy", square(), "-o", "a.tif", "--linke", "0.5"],
                "analysis.linke = '0.5'; allowed",
            ),
            "air of eleven months": (
                ["energy", square(), "-o", "a.tif", "--linke", "2,2,2,2,2,2,2,2,2,2,2"],
                "or twelve separated by commas",
            ),
            "surroundings brighter than light": (
                ["energy", square(), "-o", "a.tif", "--albedo", "1.5"],
                "0 to 1",
            ),
            "crowns brighter than light": (
                ["energy", square(), "-o", "a.tif", "--crown-light", "0.1,1.5"],
                "analysis.crown_light = '0.1,1.5'; allowed",
            ),
            "another model of the sky": (
                ["energy", square(), "-o", "a.tif", "--diffuse", "hay"],
                "perez, isotropic",
            ),
            "objects that are no GeoPackage": (
                ["energy", square(), "-o", "a.tif", "--objects", "a.shp"],
                "allowed: .gpkg",
            ),
            "objects on the ground": (
                ["energy", square(), "-o", "a.tif", "--objects", "a.gpkg", "--surface", "ground"],
                "--surface top, or --polygons",
            ),
            "facades that are no GeoPackage": (
                ["energy", square(), "-o", "a.tif", "--facades", "a.gml"],
                "write the facades a.gml: the ending '.gml'; allowed: .gpkg",
            ),
            "facades on the ground": (
                ["energy", square(), "-o", "a.tif", "--facades", "a.gpkg", "--surface", "ground"],
                "--facades with --surface ground",
            ),
            "facades of a part": (
                ["energy", square(), "-o", "a.tif", "--facades", "a.gpkg", "--part", "1/2"],
                "--facades together with --part",
            ),
            "storeys of nothing": (
                ["energy", square(), "-o", "a.tif", "--facades", "a.gpkg", "--storey-m", "0.2"],
                "allowed: 1 to 1000",
            ),
            "polygons of nothing": (
                ["energy", square(), "-o", "a.tif", "--polygons", "a.geojson"],
                "--polygons without --objects",
            ),
            "polygons that are none": (
                [
                    *["energy", square(), "-o", "a.tif", "--objects", "a.gpkg"],
                    *["--polygons", square()],
                ],
                "read the GeoJSON file",
                1,
            ),
            "energy of a day and a period": (
                ["energy", square(), "-o", "a.tif", *YEAR, "--date", "2026-01-01"],
                "analyse energy: --date together",
            ),
            "energy of no place": (["energy", "generated:3", "-o", "a.tif"], "no place on Earth"),
            "a sun of no place": (["sun", "generated:3", "-o", "a.tif"], "no place on Earth"),
            "a surface that is none": (
                ["sky", square(), "-o", "a.tif", "--surface", "cellar"],
                "ground",
            ),
            "options of the other kind": (
                ["terrain", square(), "-o", "a.tif", "--directions", "64"],
                "--directions",
            ),
            "no observer": (["sight", square(), "-o", "a.tif"], "--observer"),
            "a file of observers that is none": (
                ["sight", square(), "-o", "a.tif", "--observers", square()],
                "read the GeoJSON file",
                1,
            ),
            "an observer elsewhere": (
                ["sight", square(), "-o", "a.tif", "--observer", "1,2,3"],
                "outside of the data; allowed: E ",
            ),
            "an observer inside rock": (
                ["sight", square(), "-o", "a.tif", "--observer", f"{west + 5},{south + 5},1"],
                "the top there",
            ),
            "an observer of two numbers": (
                ["sight", square(), "-o", "a.tif", "--observer", f"{west + 5},{south + 5}"],
                "above-ground",
            ),
            "an observer of words": (
                ["sight", square(), "-o", "a.tif", "--observer", "here,there,+2"],
                "above-ground",
            ),
            "too many observers": (
                [
                    *["sight", square(), "-o", "a.tif"],
                    *["--observer", f"{west + 5},{south + 5},+2"] * 1025,
                ],
                "1 to 1024",
            ),
            "refraction that no air has": (
                ["sight", square(), "-o", "a.tif", *observer(), "--refraction", "2"],
                "refraction",
            ),
            "a planned object elsewhere": (
                ["terrain", square(), "-o", "a.tif", "--add", "0,0,10,10,500"],
                "outside of the data; allowed: within",
            ),
            "a planned object without a height": (
                ["terrain", square(), "-o", "a.tif", "--add", "0,0,10,10"],
                "TOP",
            ),
            "no kind": ([], "a command is missing; allowed: terrain, sky"),
        }
        for name, (arguments, says, *code) in cases.items():
            with self.subTest(name):
                folder = temporary_folder()
                run = analyse(*arguments, "--quiet", cwd=folder) if arguments else analyse()
                self.assertEqual(run.code, code[0] if code else 2, run)
                self.assertIn(says, run.err)
                self.assertEqual(run.out, "")
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

    def test_help_names_the_kinds(self):
        run = analyse("--help")
        self.assertEqual(run.code, 0)
        self.assertIn("terrain", run.out)
        self.assertIn("sky", run.out)
        self.assertIn("sight", run.out)

    def test_data_that_is_no_world_ends_with_one_line(self):
        folder = temporary_folder()
        (folder / "a.laz").write_bytes(b"no points")
        run = analyse("sky", "a.laz", "-o", "a.tif", "--quiet", cwd=folder)
        self.assertNotEqual(run.code, 0)
        self.assertEqual(len(run.err.strip().splitlines()), 1, run)
        self.assertEqual(entries(folder), ["a.laz"])


if __name__ == "__main__":
    unittest.main()

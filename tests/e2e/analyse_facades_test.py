#!/usr/bin/env python3
"""Facades of a synthetic survey: the walls of its buildings, storey by storey."""

import contextlib
import os
import shutil
import sqlite3
import subprocess
import unittest

from analysing import analyse, village
from support import Case, entries, square, temporary_folder


class Facades(Case):
    def facades(self, *flags, program=()):
        """@return the rows of the facades of a week, and of its objects"""
        folder = temporary_folder()
        file, objects = folder / "f.gpkg", folder / "a.gpkg"
        out = ["-o", folder / "a.tif", "--facades", file, "--objects", objects]
        days = ["--from", "2026-06-01", "--to", "2026-06-07", "--step-min", "60"]
        words = ["energy", square(), *village(), *days, *flags, "--quiet", *out]
        run = analyse(*words, program=program)
        self.assertEqual((run.code, run.out, run.err), (0, "", ""), run)
        self.assertEqual(entries(folder), ["a.gpkg", "a.tif", "f.gpkg"])
        self.last_objects = objects
        rows = {}
        for layer, of in (("facades", file), ("objects", objects)):
            with contextlib.closing(sqlite3.connect(of)) as data:
                data.row_factory = sqlite3.Row
                rows[layer] = [dict(row) for row in data.execute(f"SELECT * FROM {layer}")]
                styles = data.execute("SELECT f_table_name FROM layer_styles").fetchall()
                self.assertEqual([tuple(style) for style in styles], [(layer,)])
        return rows["facades"], rows["objects"]

    def write_footprints(self, file):
        """Writes the outlines of the objects of the last run as GeoJSON."""
        subprocess.run(["ogr2ogr", "-f", "GeoJSON", file, self.last_objects, "objects"], check=True)

    def test_facades_are_the_walls_of_the_objects_storey_by_storey(self):
        facades, objects = self.facades("--processing-threads", "1")
        self.assertGreater(len(facades), 30)
        ids = {row["id"] for row in objects}
        keys = [(row["building"] or 0, row["facing"], row["storey"]) for row in facades]
        self.assertEqual(len(set(keys)), len(keys))
        self.assertTrue({key[0] for key in keys} <= ids | {0})
        self.assertGreater(len({key[0] for key in keys}), 3)
        for row in facades:
            with self.subTest(fid=row["fid"]):
                self.assertTrue(0 < row["top_m"] - row["bottom_m"] < 40)
                self.assertTrue(0 <= row["sky_view"] <= 0.5 + 1e-6)
                self.assertTrue(0 <= row["beam_kwh_m2"] <= row["kwh_m2"])
                self.assertAlmostEqual(row["kwh"], row["kwh_m2"] * row["area_m2"], delta=1e-6)
                # Rays of the sun come for at most 16 of 24 hours; a wall has half of the sky.
                self.assertTrue(0 <= row["sun_hours"] <= 7 * 16)
                self.assertTrue(0 < row["area_m2"] <= 3 * row["faces"] + 1e-3)

        # Who computes them does not matter, nor in which tiles.
        again, _ = self.facades("--processing-threads", "2", "--quality-tile", "32")
        self.assertEqual(again, facades)

    def test_a_process_that_has_fewer_cores_than_threads_says_nothing_of_it(self):
        core = str(min(os.sched_getaffinity(0)))
        one_core = ["taskset", "--cpu-list", core]
        on_one_core, _ = self.facades("--processing-threads", "4", program=one_core)
        self.assertGreater(len(on_one_core), 30)

    @unittest.skipUnless(shutil.which("ogr2ogr"), "needs GDAL's programs")
    def test_polygons_that_are_the_buildings_have_their_facades(self):
        facades, objects = self.facades()
        footprints = temporary_folder() / "footprints.geojson"
        numbers = [row["id"] for row in objects]
        self.write_footprints(footprints)
        by_polygon, _ = self.facades("--polygons", footprints)

        def area(rows, number_of):
            out = {}
            for row in rows:
                if row["building"]:
                    number = number_of(row["building"])
                    out[number] = out.get(number, 0) + row["area_m2"]
            return out

        wanted = area(facades, lambda building: building)
        found = area(by_polygon, lambda feature: numbers[feature - 1])
        self.assertEqual(set(found), set(wanted))
        for number, area_m2 in wanted.items():
            self.assertAlmostEqual(found[number], area_m2, delta=0.1 * area_m2 + 20)
        self.assertAlmostEqual(sum(found.values()), sum(wanted.values()), delta=60)
        self.assertEqual([row for row in by_polygon if not row["building"]], [])


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
"""Rasters of a synthetic survey: their form, their values, how they go on."""

import base64
import calendar
import contextlib
import json
import os
import re
import shutil
import sqlite3
import subprocess
import unittest
import xml.etree.ElementTree

from analysing import (
    CROWNS,
    ENERGY,
    MONTHS,
    NO_DATA,
    PERIOD,
    SIGHT,
    SKY,
    TERRAIN,
    YEAR,
    analyse,
    area,
    area_flag,
    raster,
    village,
)
from support import (
    FARM_TOKEN,
    Case,
    Program,
    entries,
    only_in_all,
    secret_file,
    square,
    temporary_folder,
)

ZONE = ["--zone", "Europe/Ljubljana"]


@unittest.skipUnless(shutil.which("gdalinfo"), "needs GDAL's programs")
def style_of(band):
    """How a band is drawn, as its metadata say."""
    prefix = "terravox_"
    found = band.get("metadata", {}).get("", {})
    return {key.removeprefix(prefix): found[key] for key in found if key.startswith(prefix)}


class Rasters(Case):
    def info(self, file):
        run = subprocess.run(
            ["gdalinfo", "-json", "-stats", file],
            capture_output=True,
            text=True,
            check=True,
            env={**os.environ, "GDAL_PAM_ENABLED": "NO"},
        )
        return json.loads(run.stdout)

    def values(self, file, band):
        """@return the values of a band by row"""
        grid = temporary_folder() / "a.asc"
        subprocess.run(
            ["gdal_translate", "-q", "-of", "AAIGrid", "-b", str(band), file, grid], check=True
        )
        lines = grid.read_text(encoding="utf-8").splitlines()
        first = next(i for i, line in enumerate(lines) if line.strip()[0] in "-0123456789")
        return [[float(word) for word in line.split()] for line in lines[first:]]

    def test_are_cloud_optimized_and_name_their_bands_units_and_place(self):
        west, south, east, north = area()
        for kind, names, flags in (
            ("terrain", TERRAIN, []),
            ("sky", SKY, []),
            ("sun", ["sun_hours", "first_sun", "last_sun", "hole"], []),
            ("sun", PERIOD, YEAR),
            ("sun", MONTHS, [*YEAR, "--monthly"]),
            ("sun", ["sunlit", "hole"], ["--at", "12:00"]),
            ("energy", ENERGY, YEAR),
            ("sight", SIGHT, []),
            ("clearance", ["clearance", "material", "hole"], []),
        ):
            with self.subTest(kind, flags=flags):
                info = self.info(raster(kind, *flags))
                self.assertEqual(info["metadata"]["IMAGE_STRUCTURE"]["LAYOUT"], "COG")
                self.assertEqual([band["description"] for band in info["bands"]], names)
                self.assertEqual({band["noDataValue"] for band in info["bands"]}, {NO_DATA})
                self.assertEqual(info["geoTransform"], [west, 1, 0, north, 0, -1])
                self.assertEqual(info["size"], [east - west, north - south])
                self.assertIn("3794", info["coordinateSystem"]["wkt"])
                units = {band["description"]: band.get("unit", "") for band in info["bands"]}
                for name, unit in (
                    ("dsm", "m"),
                    ("openness", "degree"),
                    ("sun_hours", "h"),
                    ("beam", "kWh/m2"),
                    ("distance_m", "m"),
                ):
                    if name in units:
                        self.assertEqual(units[name], unit)
                self.assertEqual(info["metadata"][""]["terravox_holes"], "0")
                styles = {band["description"]: style_of(band) for band in info["bands"]}
                hole = {"low": "0", "high": "1", "words": "read|could not be read"}
                hole |= {"title": "Data that could not be read", "ramp": "much"}
                self.assertEqual(styles["hole"], hole)
                self.assertIn("title", styles[names[0]])
                self.assertEqual(styles.get("red", {}), {})
                if "first_sun" in styles:
                    self.assertEqual(styles["first_sun"]["form"], "clock")

    def test_values_of_terrain_agree_with_each_other(self):
        file = raster("terrain")
        bands = {name: self.values(file, i + 1) for i, name in enumerate(TERRAIN)}
        cells = 0
        interpolated = 0
        for y, row in enumerate(bands["dsm"]):
            for x, surface in enumerate(row):
                at = {name: bands[name][y][x] for name in TERRAIN}
                self.assertEqual(at["hole"], 0)
                if surface == NO_DATA:
                    continue
                cells += 1
                self.assertTrue(0 <= at["red"] <= 255 and at["material"] > 0, at)
                if at["dtm"] == NO_DATA:
                    continue
                interpolated += at["dtm_source"] == 2
                self.assertLessEqual(at["dtm"], surface)
                self.assertAlmostEqual(at["ndsm"], surface - at["dtm"], places=3)
                self.assertTrue(0 <= at["slope"] < 90 and 1 <= at["hillshade"] <= 255, at)
                self.assertTrue(at["aspect"] == NO_DATA or 0 <= at["aspect"] < 360, at)
        self.assertGreater(cells, 10_000)
        self.assertGreater(interpolated, 5)

    def test_a_summary_of_what_observers_see_is_that_of_the_file(self):
        west, south, east, north = area()
        first = ["--observer", f"{west + 10},{south + 10},+2"]
        second = ["--observer", f"{east - 10},{north - 10},1.6,above-ground"]
        seen = [v for row in self.values(self.sight([*first, *second]), 1) for v in row]
        run = analyse("sight", square(), *area_flag(), *first, *second, "--json", "-o", self.out)
        self.assertEqual(run.code, 0, run)
        summary = json.loads(run.out)
        self.assertEqual(summary["seen_cells"], sum(v > 0 for v in seen))
        self.assertEqual(summary["cells"], sum(v != NO_DATA for v in seen))
        self.assertAlmostEqual(summary["seen_km2"], summary["seen_cells"] / 1e6)
        for rows in (summary["materials"], summary["classes"]):
            self.assertEqual(sum(row["seen_cells"] for row in rows), summary["seen_cells"])
            self.assertAlmostEqual(sum(row["share_of_seen"] for row in rows), 1)
        run = analyse("sight", square(), *area_flag(), *first, "-o", self.out)
        self.assertEqual(run.code, 0, run)
        self.assertRegex(run.out, r"seen: 0\.\d+ km2 of 0\.\d+ km2")
        self.assertIn("grass", run.out)

    @only_in_all
    def test_observers_of_a_file_are_those_of_the_command_line(self):
        west, south, _, _ = area()
        at = [(west + 20, south + 20), (west + 20, south + 41)]
        file = temporary_folder() / "path.geojson"
        geometry = {"type": "LineString", "coordinates": [[east, north] for east, north in at]}
        crs = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::3794"}}
        feature = {"type": "Feature", "properties": {"height": 3}, "geometry": geometry}
        file.write_text(json.dumps({**feature, "crs": crs}), encoding="utf-8")
        step = ["--observers", str(file), "--observer-step-m", "7"]
        alone = []
        for north in (20, 27, 34, 41):
            alone += ["--observer", f"{west + 20},{south + north},3,above-ground"]
        self.assertEqual(self.values(self.sight(step), 1), self.values(self.sight(alone), 1))

    def sight(self, flags):
        self.out = temporary_folder() / "sight.tif"
        run = analyse("sight", square(), *area_flag(), *flags, "--quiet", "-o", self.out)
        self.assertEqual((run.code, run.out, run.err), (0, "", ""), run)
        return self.out

    @only_in_all
    def test_several_instants_are_bands_with_the_masks_of_each(self):
        zone = ["--date", "2026-06-21", *ZONE]
        cube = raster("sun", *zone, "--times", "13:00,19:30,2026-12-21T12:00")
        info = self.info(cube)
        names = [band["description"] for band in info["bands"]]
        wanted = ["sunlit_1300", "sunlit_1930", "sunlit_2026-12-21T1200", "hole"]
        self.assertEqual(names, wanted)
        self.assertNotIn("Alpha", [band["colorInterpretation"] for band in info["bands"]])
        winter = ["--date", "2026-12-21", *ZONE, "--at", "12:00"]
        for number, one in (
            (1, raster("sun", *zone, "--at", "13:00")),
            (2, raster("sun", *zone, "--at", "19:30")),
            (3, raster("sun", *winter)),
        ):
            masks = self.values(cube, number)
            single = [[255 if v == NO_DATA else v for v in row] for row in self.values(one, 1)]
            self.assertEqual(masks, single)
        self.assertEqual({v for row in self.values(cube, 4) for v in row}, {0})

    def test_a_report_and_a_map_tell_what_the_raster_holds(self):
        folder = temporary_folder()
        page, map_ = folder / "sky.html", folder / "sky.svg"
        out = ["-o", folder / "sky.tif", "--report", page, "--map", map_]
        run = analyse("sky", square(), *area_flag(), "--directions", "64", *out)
        self.assertEqual(run.code, 0, run)
        for file in ("sky.tif", "sky.html", "sky.svg"):
            self.assertIn(f"wrote {folder / file}", run.out)
        sheet = xml.etree.ElementTree.parse(map_).getroot()
        words = [text.text for text in sheet.iter("{http://www.w3.org/2000/svg}text")]
        self.assertEqual(words[0], "Sky-view factor")
        self.assertIn("N", words)
        picture = sheet.find(".//{http://www.w3.org/2000/svg}image").get("href")
        self.assertTrue(base64.b64decode(picture.partition(",")[2]).startswith(b"\x89PNG"))
        text = page.read_text(encoding="utf-8")
        self.assertEqual(text.count("<image"), 3)
        self.assertIn("<tr><td>directions</td><td>64</td></tr>", text)
        self.assertNotIn("http", text.replace("http-equiv", ""))
        shown = re.search(r"<td>svf</td><td></td>" + r'<td class="n">([^<]*)</td>' * 6, text)
        values = [v for row in self.values(folder / "sky.tif", 1) for v in row if v != NO_DATA]
        least, _, mean, _, most = (float(shown[i]) for i in range(2, 7))
        self.assertAlmostEqual(least, min(values), delta=0.001)
        self.assertAlmostEqual(most, max(values), delta=0.001)
        self.assertAlmostEqual(mean, sum(values) / len(values), delta=0.001)

    def objects(self, *flags):
        """@return the objects of the energy of a year by id, and the file, next to its raster"""
        folder = temporary_folder()
        file = folder / "a.gpkg"
        out = ["-o", folder / "a.tif", "--objects", file]
        run = analyse("energy", square(), *YEAR, *flags, "--quiet", *out)
        self.assertEqual((run.code, run.out, run.err), (0, "", ""), run)
        self.assertEqual(entries(folder), ["a.gpkg", "a.tif"])
        with contextlib.closing(sqlite3.connect(file)) as data:
            data.row_factory = sqlite3.Row
            rows = data.execute("SELECT * FROM objects ORDER BY id").fetchall()
        return {row["id"]: dict(row) for row in rows}, file

    @only_in_all
    def test_masks_of_several_instants_are_a_cube_of_netcdf_by_time(self):
        folder = temporary_folder()
        cube = folder / "masks.nc"
        times = [*ZONE, "--times", "2026-12-21T12:00,19:30,13:00"]
        run = analyse("sun", square(), *area_flag(), *times, "--quiet", "-o", cube)
        self.assertEqual((run.code, run.out, run.err), (0, "", ""), run)
        self.assertEqual(entries(folder), ["masks.nc"])
        info = json.loads(
            subprocess.run(["gdalinfo", "-json", cube], check=True, capture_output=True).stdout
        )
        facts = info["metadata"][""]
        # Noon in summer, the evening, and noon in winter, by UTC.
        day = [
            calendar.timegm((2026, *at, 0))
            for at in ((6, 21, 11, 0), (6, 21, 17, 30), (12, 21, 11, 0))
        ]
        self.assertEqual(facts["NETCDF_DIM_time_VALUES"], "{" + ",".join(map(str, day)) + "}")
        self.assertEqual(facts["time#units"], "seconds since 1970-01-01 00:00:00")
        self.assertTrue(facts["NC_GLOBAL#Conventions"].startswith("CF-1."))
        self.assertNotIn("NC_GLOBAL#history", facts)
        self.assertIn("3794", info["coordinateSystem"]["wkt"])
        bands = analyse("sun", square(), *area_flag(), *times, "-q", "-o", folder / "a.tif")
        self.assertEqual(bands.code, 0, bands)
        for in_cube, in_raster in ((1, 3), (2, 2), (3, 1)):
            wanted = self.values(folder / "a.tif", in_raster)
            self.assertEqual(self.values(cube, in_cube), wanted)
        self.assertGreater(len({value for row in wanted for value in row}), 1)

    def test_objects_are_the_roofs_with_their_energy_outlines_and_style(self):
        found, file = self.objects(*village())
        materials = self.values(file.with_name("a.tif"), ENERGY.index("material") + 1)
        roofs = sum(material in (8, 9, 10, 11, 12, 32) for row in materials for material in row)
        self.assertGreater(roofs, 300)
        self.assertEqual(sum(one["cells"] for one in found.values()), roofs)
        self.assertEqual(list(found), list(range(1, len(found) + 1)))
        for one in found.values():
            self.assertEqual((one["area_m2"], one["cells_without_value"]), (one["cells"], 0))
            self.assertTrue(0 < one["best_kwh"] <= one["kwh"] + 0.001, one)
        outlines = temporary_folder() / "a.geojson"
        subprocess.run(["ogr2ogr", "-lco", "RFC7946=NO", outlines, file, "objects"], check=True)
        shapes = json.loads(outlines.read_text(encoding="utf-8"))
        self.assertIn("3794", shapes["crs"]["properties"]["name"])
        for shape in shapes["features"]:
            rings = shape["geometry"]["coordinates"]
            twice = [sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(r, r[1:])) for r in rings]
            area_m2 = abs(twice[0]) / 2 - sum(abs(a) for a in twice[1:]) / 2
            self.assertAlmostEqual(area_m2, shape["properties"]["area_m2"], places=3)
        with contextlib.closing(sqlite3.connect(file)) as data:
            style = data.execute("SELECT f_table_name, useAsDefault, styleQML FROM layer_styles")
            table, is_default, qml = style.fetchone()
        self.assertEqual((table, is_default), ("objects", 1))
        self.assertIn("graduatedSymbol", qml)

    @only_in_all
    def test_a_part_has_the_values_of_the_whole(self):
        west, south, east, north = area()
        part = temporary_folder() / "part.tif"
        flags = ["--area", f"{west + 20},{south + 30},{east - 50},{north - 10}"]
        run = analyse("sky", square(), *flags, "--quiet", "-o", part)
        self.assertEqual(run.code, 0, run)
        whole = self.values(raster("sky"), 1)
        self.assertEqual(self.values(part, 1), [row[20:-50] for row in whole[10:-30]])

    def worker(self):
        """@return the flags with which a worker renders alone"""
        token = ["--token-file", secret_file(FARM_TOKEN)]
        worker = Program("worker", "--listen", "127.0.0.1:0", *token, test=self)
        return ["--threads", "0", "--worker", worker.address(), *token]

    def test_a_worker_measures_the_same(self):
        flags = self.worker()
        for kind, *what in (
            *[["terrain"], ["sky"], ["sight"]],
            # Workers do not look up the laws of a zone.
            ["sun", "--date", "2026-03-29", *ZONE],
            ["sun", "--at", "17:30", *ZONE],
            [*CROWNS, "0.03,0.45", *ZONE],
        ):
            with self.subTest(kind, what=what):
                what += ["--resolution", "2"]
                wanted = raster(kind, *what).read_bytes()
                self.assertEqual(raster(kind, *what, *flags).read_bytes(), wanted)

    @only_in_all
    def test_a_worker_measures_planned_objects_too(self):
        add = ["--area", "0,0,100,80", "--add", "40,30,60,50,300"]
        files = [temporary_folder() / "a.tif", temporary_folder() / "b.tif"]
        for file, flags in zip(files, ([], self.worker())):
            words = ["terrain", "generated:3", *add, *flags, "--quiet", "-o", file]
            self.assertEqual(analyse(*words).code, 0)
        self.assertEqual(files[0].read_bytes(), files[1].read_bytes())
        self.assertEqual(max(v for row in self.values(files[0], 1) for v in row), 300)

    def test_what_cannot_be_read_is_a_hole_and_no_value(self):
        folder = temporary_folder()
        broken = bytearray(square().read_bytes())
        middle = len(broken) // 2
        broken[middle : middle + 400] = bytes(400)
        (folder / "broken.laz").write_bytes(broken)
        file = folder / "a.tif"
        words = [folder / "broken.laz", *area_flag(), "--quiet", "-o", file]
        run = analyse("terrain", *words)
        self.assertEqual(run.code, 3, run)
        self.assertIn("holes", run.err)
        holes, first = self.values(file, len(TERRAIN)), self.values(file, 1)
        is_hole = [[value == 1 for value in row] for row in holes]
        self.assertEqual([[value == NO_DATA for value in row] for row in first], is_hole)
        self.assertGreater(sum(map(sum, is_hole)), 1000)


if __name__ == "__main__":
    unittest.main()

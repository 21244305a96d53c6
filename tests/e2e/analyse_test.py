#!/usr/bin/env python3
"""Rasters of a synthetic survey: their form, their values, how they go on."""

import calendar
import contextlib
import json
import math
import os
import re
import shutil
import signal
import sqlite3
import subprocess
import unittest

from analysing import (
    CROWNS,
    ENERGY,
    MONTHS,
    NO_DATA,
    PERIOD,
    SIGHT,
    SKY,
    SUN,
    TERRAIN,
    YEAR,
    ZONED,
    analyse,
    area,
    area_flag,
    raster,
    village,
)
from support import (
    HANGS_S,
    Case,
    Run,
    binary,
    entries,
    hold_port,
    only_in_all,
    square,
    temporary_folder,
)


def scarce(kind):
    """@return flags with which some to some thousand boxes are loaded again, as the statistics of a
    run with --verbose say

    All boxes take 2 to 4 MiB. With a MiB less than here they are loaded so often that the sky takes
    ten times as long, for nothing that would be found by it.
    """
    memory_mib = {"terrain": "1", "sight": "1", "sun": "2"}.get(kind, "3")
    return ["--memory-mib", memory_mib, "--tile", "112"]


@unittest.skipUnless(shutil.which("gdalinfo"), "needs GDAL's programs")
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
            ("sun", SUN, []),
            ("sun", PERIOD, YEAR),
            ("sun", MONTHS, [*YEAR, "--monthly"]),
            ("sun", ["sunlit", "hole"], ["--at", "12:00"]),
            ("energy", ENERGY, YEAR),
            ("sight", SIGHT, []),
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

    @only_in_all
    def test_values_of_the_sky_are_shares(self):
        file = raster("sky")
        for i in (1, 2):
            values = [v for row in self.values(file, i) for v in row]
            self.assertTrue(all(v == NO_DATA or 0 <= v <= 1.00001 for v in values))
            self.assertLess(min(v for v in values if v != NO_DATA), 0.6)
            self.assertGreater(max(values), 0.9)
        openness = [v for row in self.values(file, 3) for v in row]
        self.assertTrue(all(v == NO_DATA or 0 <= v <= 90.001 for v in openness))

    def test_hours_of_sun_lie_between_first_and_last_sun(self):
        file = raster("sun", "--date", "2026-06-21", "--zone", "Europe/Ljubljana")
        hours, first, last = ([v for row in self.values(file, i) for v in row] for i in (1, 2, 3))
        self.assertGreater(max(hours), 14)
        self.assertLess(min(v for v in hours if v != NO_DATA), 10)
        for of_day, begins, ends in zip(hours, first, last):
            if of_day <= 0:
                self.assertEqual((begins, ends), (NO_DATA, NO_DATA))
                continue
            # Summer time: the sun is due south at about 13:03.
            self.assertTrue(5 <= begins < ends <= 21.2, (begins, ends))
            self.assertLessEqual(of_day, ends - begins + 0.01)

    def test_what_is_seen_has_a_distance_and_a_material(self):
        file = raster("sight")
        seen, distance, _, material, _ = (
            [v for row in self.values(file, i) for v in row] for i in range(1, 6)
        )
        self.assertEqual({v for v in seen if v != NO_DATA}, {0, 1})
        for is_seen, metres, what in zip(seen, distance, material):
            self.assertEqual(is_seen == 1, metres > 0, (is_seen, metres))
            self.assertEqual(is_seen == NO_DATA, what == NO_DATA)
        self.assertLess(max(distance), 250)

    @only_in_all
    def test_observers_add_up_on_the_file_and_in_the_summary(self):
        west, south, east, north = area()
        first = ["--observer", f"{west + 10},{south + 10},+2"]
        second = ["--observer", f"{east - 10},{north - 10},1.6,above-ground"]
        one, other, both = (
            [v for row in self.values(file, 1) for v in row]
            for file in (self.sight(first), self.sight(second), self.sight([*first, *second]))
        )
        self.assertEqual(
            [a if a == NO_DATA else a + b for a, b in zip(one, other)],
            both,
        )
        run = analyse("sight", square(), *area_flag(), *first, *second, "--json", "-o", self.out)
        self.assertEqual(run.code, 0, run)
        summary = json.loads(run.out)
        self.assertEqual(summary["seen_cells"], sum(v > 0 for v in both))
        self.assertEqual(summary["cells"], sum(v != NO_DATA for v in both))
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
    def test_hours_of_a_year_are_those_of_its_months(self):
        year = [self.values(raster("sun", *YEAR), i + 1) for i in range(3)]
        months = [self.values(raster("sun", *YEAR, "--monthly"), i + 1) for i in range(13)]
        self.assertEqual(year[0], months[0])
        lit = 0
        for y, row in enumerate(year[0]):
            for x, hours in enumerate(row):
                if hours == NO_DATA:
                    continue
                lit += hours > 4000
                self.assertAlmostEqual(sum(m[y][x] for m in months[1:]), hours, delta=0.1)
                self.assertAlmostEqual(year[1][y][x], hours / 365, places=3)
                self.assertTrue(0 <= year[2][y][x] <= 1.0001)
                self.assertLessEqual(months[12][y][x], months[6][y][x] + 100)
        self.assertGreater(lit, 1000)

    @only_in_all
    def test_energy_is_the_sum_of_its_parts_and_most_on_southern_roofs(self):
        flags = [*YEAR, "--directions", "64", "--linke", "2,2,2,3,3,3,4,4,3,3,2,2"]
        bands = [self.values(raster("energy", *flags), i + 1) for i in range(6)]
        facing = {"north": [], "south": []}
        for row in zip(*bands):
            for total, beam, diffuse, reflected, slope, aspect in zip(*row):
                if total == NO_DATA:
                    continue
                self.assertAlmostEqual(total, beam + diffuse + reflected, delta=0.01)
                self.assertTrue(0 <= total < 3000 and min(beam, diffuse, reflected) >= 0)
                if 20 < slope < 50 and abs(aspect - 180) < 40:
                    facing["south"].append(total)
                if 20 < slope < 50 and abs(aspect - 180) > 140:
                    facing["north"].append(total)
        means = {side: sum(found) / len(found) for side, found in facing.items()}
        self.assertGreater(len(facing["south"]), 20)
        self.assertGreater(means["south"], 1.3 * means["north"])

    @only_in_all
    def test_crowns_add_light_below_them_and_nowhere_else(self):
        for band in (2, 3):  # of the sun and of the sky
            values = [self.values(raster(*CROWNS, share), band) for share in ("0", "0.1", "1")]
            more = 0
            for rows in zip(*values):
                for none, some, every in zip(*rows):
                    # Rays through crowns are added later: sums are rounded in another order.
                    self.assertTrue(none <= some + 1e-3 <= every + 2e-3, (none, some, every))
                    self.assertAlmostEqual(some, 0.9 * none + 0.1 * every, delta=0.1)
                    more += every > 1.2 * none
            self.assertGreater(more, 200)

    @only_in_all
    def test_an_instant_is_sunlit_or_not(self):
        flags = ["--date", "2026-06-21", "--zone", "Europe/Ljubljana", "--at"]
        noon = [v for row in self.values(raster("sun", *flags, "13:00"), 1) for v in row]
        self.assertEqual({v for v in noon if v != NO_DATA}, {0, 1})
        evening = [v for row in self.values(raster("sun", *flags, "19:30"), 1) for v in row]
        self.assertGreater(noon.count(1), evening.count(1) + 1000)
        night = [v for row in self.values(raster("sun", *flags, "01:00"), 1) for v in row]
        self.assertEqual({v for v in night if v != NO_DATA}, {0})

    @only_in_all
    def test_several_instants_are_bands_with_the_masks_of_each(self):
        zone = ["--date", "2026-06-21", "--zone", "Europe/Ljubljana"]
        cube = raster("sun", *zone, "--times", "13:00,19:30,2026-12-21T12:00")
        info = self.info(cube)
        names = [band["description"] for band in info["bands"]]
        wanted = ["sunlit_1300", "sunlit_1930", "sunlit_2026-12-21T1200", "hole"]
        self.assertEqual(names, wanted)
        self.assertNotIn("Alpha", [band["colorInterpretation"] for band in info["bands"]])
        winter = ["--date", "2026-12-21", "--zone", "Europe/Ljubljana", "--at", "12:00"]
        for number, one in (
            (1, raster("sun", *zone, "--at", "13:00")),
            (2, raster("sun", *zone, "--at", "19:30")),
            (3, raster("sun", *winter)),
        ):
            masks = self.values(cube, number)
            single = [[255 if v == NO_DATA else v for v in row] for row in self.values(one, 1)]
            self.assertEqual(masks, single)
        self.assertEqual({v for row in self.values(cube, 4) for v in row}, {0})

    @only_in_all
    def test_files_are_the_same_for_any_threads_tiles_and_memory(self):
        months = ["sun", *YEAR, "--monthly"]
        crowns = [*CROWNS, "0.03,0.45"]
        times = ["sun", "--times", "09:00,15:00"]
        for kind, *what in (
            *[["terrain"], ["sky"], ["sun"], months, times],
            *[["energy"], crowns, ["sight"]],
        ):
            with self.subTest(kind, what=what):
                wanted = raster(kind, *what).read_bytes()
                for flags in (
                    ["--threads", "1"],
                    ["--threads", "3", "--tile", "32"],
                    scarce(kind),
                ):
                    self.assertEqual(raster(kind, *what, *flags).read_bytes(), wanted, flags)

    def test_a_report_and_a_map_tell_what_the_raster_holds(self):
        folder = temporary_folder()
        page, map_ = folder / "sky.html", folder / "sky.png"
        out = ["-o", folder / "sky.tif", "--report", page, "--map", map_]
        run = analyse("sky", square(), *area_flag(), "--directions", "64", *out)
        self.assertEqual(run.code, 0, run)
        for file in ("sky.tif", "sky.html", "sky.png"):
            self.assertIn(f"wrote {folder / file}", run.out)
        self.assertTrue(map_.read_bytes().startswith(b"\x89PNG"))
        text = page.read_text(encoding="utf-8")
        self.assertEqual(text.count("<img"), 3)
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
        times = ["--zone", "Europe/Ljubljana", "--times", "2026-12-21T12:00,19:30,13:00"]
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

    def test_objects_are_the_connected_roofs_with_all_of_their_energy(self):
        found, file = self.objects(*village())
        energy = file.with_name("a.tif")
        bands = {name: self.values(energy, i + 1) for i, name in enumerate(ENERGY)}
        cells = {
            (x, y)
            for y, row in enumerate(bands["material"])
            for x, material in enumerate(row)
            if material in (8, 9, 10, 11, 12, 32)
        }
        self.assertGreater(len(cells), 300)
        left = set(cells)
        number = 0
        for first in sorted(cells, key=lambda at: (at[1], at[0])):
            if first not in left:
                continue
            number += 1
            mine = [first]
            left.remove(first)
            for x, y in mine:
                for at in ((x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)):
                    if at in left:
                        left.remove(at)
                        mine.append(at)
            surface = kwh = hours = 0
            for x, y in mine:
                part = 1 / math.cos(math.radians(bands["slope"][y][x]))
                surface += part
                kwh += part * bands["kwh_m2"][y][x]
                hours += part * bands["sun_hours"][y][x]
            one = found[number]
            self.assertEqual((one["cells"], one["cells_without_value"]), (len(mine), 0))
            self.assertEqual(one["area_m2"], len(mine))
            self.assertAlmostEqual(one["surface_m2"] / surface, 1, places=5)
            self.assertAlmostEqual(one["kwh"] / kwh, 1, places=5)
            self.assertAlmostEqual(one["kwh_m2"] / (kwh / surface), 1, places=5)
            self.assertAlmostEqual(one["sun_hours"] / (hours / surface), 1, places=5)
            self.assertLessEqual(one["best_kwh"], one["kwh"] + 0.001)
        self.assertEqual(number, len(found))
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
    def test_objects_are_the_same_for_any_threads_tiles_and_memory(self):
        wanted, _ = self.objects(*village())
        for flags in (["--threads", "1"], ["--tile", "32"], scarce("energy")):
            self.assertEqual(self.objects(*village(), *flags)[0], wanted, flags)

    @only_in_all
    def test_objects_of_polygons_are_those_cells(self):
        west, south, _, _ = area()
        ring = [(west + 10, south + 10), (west + 30, south + 10), (west + 30, south + 25)]
        ring = [[*at] for at in [*ring, (west + 10, south + 25), ring[0]]]
        crs = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::3794"}}
        geometry = {"type": "Polygon", "coordinates": [ring]}
        feature = {"type": "Feature", "properties": {}, "geometry": geometry, "crs": crs}
        file = temporary_folder() / "yard.geojson"
        file.write_text(json.dumps(feature), encoding="utf-8")
        found, _ = self.objects(*area_flag(), "--polygons", str(file), "--surface", "ground")
        self.assertEqual(list(found), [1])
        self.assertEqual((found[1]["cells"], found[1]["area_m2"]), (300, 300))
        self.assertGreater(found[1]["kwh"], 300 * 200)

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
        folder = temporary_folder()
        token = folder / "token"
        token.write_text("w5gn8kx2cq7tz4vd9mrj3hp6bf1ys8ae\n", encoding="utf-8")
        token.chmod(0o600)
        address = f"127.0.0.1:{hold_port()}"
        log = (folder / "worker.log").open("w", encoding="utf-8")
        self.addCleanup(log.close)
        worker = subprocess.Popen(
            [binary("RAYTRACER"), "worker", "--listen", address, "--token-file", token],
            stdout=log,
            stderr=log,
        )
        self.addCleanup(worker.wait, HANGS_S)
        self.addCleanup(worker.terminate)
        return ["--threads", "0", "--worker", address, "--token-file", str(token)]

    def test_a_worker_measures_the_same(self):
        flags = self.worker()
        for kind, *what in (
            *[["terrain"], ["sky"], ["sun"], *ZONED],
            *[[*CROWNS, "0.03,0.45"], ["sight"]],
        ):
            with self.subTest(kind, what=what):
                wanted = raster(kind, *what).read_bytes()
                self.assertEqual(raster(kind, *what, *flags).read_bytes(), wanted)

    @only_in_all
    def test_a_planned_object_is_in_the_world_and_hides_what_is_behind(self):
        west, south, _, _ = area()
        box = f"{west + 60},{south + 40},{west + 70},{south + 50}"
        before = self.values(raster("terrain"), 1)
        after = self.values(raster("terrain", "--add", f"{box},700"), 1)
        for y, row in enumerate(after):
            for x, height in enumerate(row):
                is_inside = 60 <= x < 70 and 60 <= y < 70
                self.assertEqual(height, 700 if is_inside else before[y][x], (x, y))
        on_ground = self.values(raster("terrain", "--add", f"{box},+30"), 1)
        self.assertEqual(len({height for row in on_ground[60:70] for height in row[60:70]}), 1)
        self.assertAlmostEqual(on_ground[65][65] - before[65][65], 30, delta=15)
        seen = [v for row in self.values(raster("sight"), 1) for v in row]
        # The observer stands next to it.
        wall = [v for row in self.values(raster("sight", "--add", f"{box},700"), 1) for v in row]
        self.assertLess(wall.count(1), 0.9 * seen.count(1))

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
        west, south, east, north = area()
        above = ["--observer", f"{west + 5},{south + 5},2000"]
        for kind, names, flags in (
            ("terrain", TERRAIN, []),
            ("sky", SKY, []),
            ("sight", SIGHT, above),
        ):
            with self.subTest(kind):
                file = folder / f"{kind}.tif"
                flags = [*area_flag(), *flags]
                run = analyse(kind, folder / "broken.laz", *flags, "--quiet", "-o", file)
                self.assertEqual(run.code, 3, run)
                self.assertIn("holes", run.err)
                holes = self.values(file, len(names))
                first = self.values(file, 1)
                counted = 0
                for holes_of_row, values_of_row in zip(holes, first):
                    for hole, value in zip(holes_of_row, values_of_row):
                        self.assertEqual(hole == 1, value == NO_DATA)
                        counted += hole == 1
                self.assertGreater(counted, 1000)

    @only_in_all
    def test_coarser_cells_lie_on_the_same_grid(self):
        info = self.info(raster("terrain", "--resolution", "4"))
        west, south, east, north = area()
        self.assertEqual(info["geoTransform"][1], 4)
        self.assertEqual(info["geoTransform"][0] % 4, 0)
        self.assertEqual(info["geoTransform"][3] % 4, 0)
        self.assertTrue(0 <= west - info["geoTransform"][0] < 4)
        self.assertTrue(0 <= info["geoTransform"][3] - north < 4)

    @only_in_all
    def test_an_interrupted_raster_goes_on_where_it_was(self):
        file = temporary_folder() / "a.tif"
        words = ["analyse", "sky", square(), *area_flag(), "--tile", "16", "--resume", "-o", file]
        process = subprocess.Popen(
            [binary("RAYTRACER"), *words, "--directions", "1024", "--threads", "1"],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        tiles = file.with_name("a.tif.tiles")
        while process.poll() is None and not (tiles.exists() and tiles.stat().st_size > 30_000):
            pass
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=HANGS_S)
        self.assertIn("interrupted", err)
        self.assertEqual(entries(file.parent), ["a.tif.tiles"])
        other = analyse(*words[1:], "--quiet")
        self.assertEqual(other.code, 1, other)  # with other directions
        self.assertIn("analysis.directions", other.err)
        run = Run([binary("RAYTRACER"), *words, "--directions", "1024"])
        self.assertEqual(run.code, 0, run)
        self.assertIn("tiles are in", run.out + run.err)
        self.assertEqual(entries(file.parent), ["a.tif"])
        whole = raster("sky", "--tile", "16", "--directions", "1024")
        self.assertEqual(self.values(file, 1), self.values(whole, 1))


if __name__ == "__main__":
    unittest.main()

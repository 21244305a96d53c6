#!/usr/bin/env python3
"""Small inputs as other people's programs write them, each with its right value.

A row stands for a kind. What it says is right, or it is refused with the reason; nothing may be
quietly wrong.
"""

import dataclasses
import json
import pathlib
import shutil
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "e2e"))

import game_worlds
from las_files import SITE_GRID, Las, Record, copc_records, key_record, wkt_record

from support import Case, Run, binary, temporary_folder

SLOVENIA = "EPSG:3794"
OTHER_KEYS = key_record((1024, 1), (1025, 1), (3072, 32632))
UNITS_ALONE = key_record((1024, 1), (1025, 2), (3076, 9001), (4099, 9001))


def las(**facts):
    return Las(**{"records": (key_record(),), **facts}).write


@dataclasses.dataclass
class Row:
    """An input, and what is right: the system it lies in, or the words of the refusal."""

    name: str
    ending: str
    write: object  # a function of a file's name
    crs: str = SLOVENIA
    refused: str = ""
    says: str = ""  # a part of a warning; without it there is none
    flags: tuple = ()
    means: dict = dataclasses.field(default_factory=dict)  # of bands of `analyse terrain`


def system_of(name, says="", **facts):
    return Row(name, "las", las(**facts), says=says)


LAS_ROWS = [
    system_of("a WKT record", records=(wkt_record(),)),
    system_of("a WKT record behind the points", records=(), extended=(wkt_record(),)),
    system_of("keys behind the points", records=(), extended=(key_record(),)),
    system_of("WKT behind the points, other keys", records=(OTHER_KEYS,), extended=(wkt_record(),)),
    system_of("no WKT in the WKT record", records=(wkt_record("not specified"), key_record())),
    system_of(
        "no WKT in the first record",
        records=(wkt_record("not specified"),),
        extended=(wkt_record(),),
    ),
    system_of(
        "a superseded record",
        records=(Record("LASF_Spec", 7, wkt_record(SITE_GRID).payload), key_record()),
    ),
    system_of("records of another user", records=(Record("else", 2112, b"LOCAL"), key_record())),
    system_of("LAS 1.2", minor=2, point_format=1),
    system_of("LAS 1.3", minor=3, point_format=3),
    system_of("LAS 1.5", minor=5, records=(wkt_record(),)),
    system_of("LAS 1.5 in colour", minor=5, point_format=7, records=(wkt_record(),)),
    system_of("LAS 1.5, WKT behind", minor=5, records=(), extended=(wkt_record(),)),
    system_of(
        "records behind the end",
        extended=(wkt_record(SITE_GRID),),
        extended_at=1 << 40,
        says="an extended record runs beyond the end",
    ),
    system_of(
        "a record that is too long",
        extended=(wkt_record(SITE_GRID),),
        extra_record_bytes=1 << 50,
        says="an extended record runs beyond the end",
    ),
    system_of(
        "records of COPC in another order of points",
        point_format=7,
        records=(copc_records(), key_record()),
        says="its index is not used, since it does not fit",
    ),
    Row(
        "LAS 1.5 of an old format", "las", las(minor=5, point_format=1), refused="allowed: 6 to 10"
    ),
    Row("LAS 1.5 without a system", "las", las(minor=5, records=()), refused="--crs EPSG:"),
    Row("a site's own grid", "las", las(records=(wkt_record(SITE_GRID),)), refused="--crs EPSG:"),
    Row("a unit alone", "las", las(records=(UNITS_ALONE,)), refused="--crs EPSG:"),
    Row(
        "a site's own grid, placed by the user",
        "las",
        las(records=(wkt_record(SITE_GRID),)),
        flags=("--crs", SLOVENIA),
    ),
    Row(
        "black points first",
        "las",
        las(point_format=7, red=lambda i: 0 if i < 2048 else 200 * 257),
        means={"red": 100},
    ),
    Row(
        "dark points first",
        "las",
        las(point_format=7, red=lambda i: 200 if i < 1024 else 60 * 257),
        means={"red": 45},
    ),
    Row("colours of 8 bits", "las", las(point_format=7, red=lambda _: 200), means={"red": 200}),
    Row("colours of 16 bits", "las", las(point_format=7, red=lambda _: 51400), means={"red": 200}),
]


class Strangers(Case):
    def info(self, row, file):
        return Run([binary("RAYTRACER"), "world", "info", "--json", file, *row.flags])

    def check(self, row, folder):
        file = folder / f"stranger.{row.ending}"
        row.write(file)
        run = self.info(row, file)
        if row.refused:
            self.assertIn(run.code, (1, 2), run)
            self.assertIn(row.refused, run.err, run)
            self.assertIn(file.name, run.err, run)
            return
        self.assertEqual(run.code, 0, run)
        self.assertEqual(json.loads(run.out)["crs"], row.crs, run)
        if row.says:
            self.assertIn(row.says, run.err, run)
        else:
            self.assertEqual(run.err, "", run)
        if row.means:
            self.check_means(row, file, folder / "a.tif")

    def check_means(self, row, file, raster):
        if not shutil.which("gdalinfo"):
            self.skipTest("needs GDAL's programs")
        words = [binary("RAYTRACER"), "analyse", "terrain", file, *row.flags, "--quiet"]
        run = Run([*words, "-o", raster])
        self.assertEqual(run.code, 0, run)
        bands = json.loads(Run(["gdalinfo", "-json", "-stats", raster]).out)["bands"]
        found = {band["description"]: band for band in bands}
        for name, mean in row.means.items():
            self.assertAlmostEqual(found[name]["mean"], mean, delta=0.5, msg=str(row))

    def check_world(self, row, folder):
        path = row.write(folder)
        run = Run([binary("RAYTRACER"), "world", "info", "--json", "--blocks", path])
        if row.refused:
            self.assertEqual(run.code, 2, run)
            self.assertIn(row.refused, run.err, run)
            self.assertIn(str(folder), run.err, run)
            return
        facts = json.loads(run.out)
        first = facts["dimensions"][0]
        self.assertEqual([each["name"] for each in facts["dimensions"]], [*row.dimensions], run)
        self.assertEqual(first["versions"], row.versions, run)
        self.assertEqual(first["chunks"]["all"], 4, run)
        self.assertEqual(first["chunks"]["damaged"], row.damaged, run)
        self.assertEqual(first["chunks"]["finished"], 4 - row.damaged, run)
        self.assertEqual(run.code, 3 if row.damage else 0, run)
        for part, lines in ((row.damage, first["damage"]), (row.note, first["notes"])):
            self.assertEqual(bool(lines), bool(part), run)
            self.assertIn(part, "\n".join(lines), run)
        self.assertEqual(bool(run.err), bool(row.says), run)
        self.assertIn(row.says, run.err, run)
        if row.has_tables:
            text = Run([binary("RAYTRACER"), "world", "info", "--blocks", path])
            self.assertIn("minecraft:straw_bed (plain)", text.out, text)
            self.assertNotIn("in no table", text.out, text)

    def check_all(self, rows):
        for row in rows:
            with self.subTest(row.name):
                folder = temporary_folder()
                self.check(row, folder)
                shutil.rmtree(folder)

    def test_las_files(self):
        self.check_all(LAS_ROWS)

    def test_game_worlds(self):
        for row in game_worlds.ROWS:
            with self.subTest(row.name):
                folder = temporary_folder()
                self.check_world(row, folder)
                shutil.rmtree(folder)


if __name__ == "__main__":
    unittest.main()

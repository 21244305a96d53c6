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
from las_files import SITE_GRID, SOUTH, WEST, Las, Record, copc_records, key_record, wkt_record
from raster_files import (
    ALPHA,
    DEGREES,
    FLOAT,
    METRES,
    MINISBLACK,
    MINISWHITE,
    NORTH,
    OTHER,
    SIGNED,
    Tiff,
    descriptions,
    grid_of_text,
    heights,
    item,
)

from support import Case, Run, binary, only_in_all, temporary_folder

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
    is_read_by_newer_gdal: bool = False  # right, too, where it is refused by older ones
    says: str = ""  # a part of a warning; without it there is none
    flags: tuple = ()
    means: dict = dataclasses.field(default_factory=dict)  # of bands of `analyse terrain`
    under: object = None  # of a photograph: what writes the world that it is of
    extent: tuple = ()  # west, south, east, north of the world's bounds, to a metre
    covered: float = 1  # of the survey, by the photograph
    valid: float = 100  # cells of the means that have a value, percent
    notes: str = ""  # a part of what is said besides


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


SURVEY = las()
COLOUR = (200, 40, 40)
SEEN = dict(zip(("red", "green", "blue"), COLOUR, strict=True))


def photo(name, bands=COLOUR, says="", means=None, **facts):
    tiff = Tiff(tuple(bands), **{k: v for k, v in facts.items() if k in Tiff.__dataclass_fields__})
    row = {k: v for k, v in facts.items() if k not in Tiff.__dataclass_fields__}
    means = SEEN if means is None and not row.get("refused") else means or {}
    row = {"ending": "tif", "write": tiff.write, "under": SURVEY, **row}
    return Row(name, says=says, means=means, **row)


def times(factor):
    return tuple(value * factor for value in COLOUR)


def translated(tiff, *words):
    """Rewrites a TIFF by GDAL's program. The TIFF stays: a mosaic reads it."""

    def write(file):
        if not shutil.which("gdal_translate"):
            raise unittest.SkipTest("needs GDAL's programs")
        whole = file.with_name("whole.tif")
        tiff.write(whole)
        Run(["gdal_translate", "-q", *words, whole, file]).done()

    return write


def folder_of(**rasters):
    def write(folder):
        folder.mkdir()
        for name, tiff in rasters.items():
            tiff.write(folder / f"{name}.tif")

    return write


TWELVE = "12 bits: 4095 is white; if another value is, make images of 8 bits: gdal_translate"
SENTINEL = descriptions("B02 (blue)", "B03 (green)", "B04 (red)")
TURNED = (40, 40, 200)

PHOTO_ROWS = [
    photo("8 bits"),
    photo("8 bits in 16", bits=16, notes="from 0 to 200 are taken for 8 bits: 255 is white"),
    photo("12 bits in 16", times(16), TWELVE, bits=16),
    photo("12 bits, as the file states", times(16), bits=12),
    photo("16 bits", times(256), bits=16, notes="are taken for 16 bits: 65535 is white"),
    photo(
        "12 bits in 16 with a white edge",
        tuple(lambda x, y, v=v: 65535 if y < 4 else 16 * v for v in COLOUR),
        TWELVE,
        bits=16,
        means={"red": 203.4, "green": 53.4},
    ),
    photo(
        "12 bits in 16 with one hot pixel",
        tuple(lambda x, y, v=v: 60000 if (x, y) == (3, 3) else 16 * v for v in COLOUR),
        TWELVE,
        bits=16,
    ),
    photo(
        "reflectance in parts of 10000",
        tuple(round(v / 255 * 10000) for v in COLOUR),
        "reflectance in parts of 10000: 10000 is white",
        bits=16,
    ),
    photo(
        "reflectance with scale and offset",
        tuple(round(v / 255 * 10000) + 1000 for v in COLOUR),
        bits=16,
        items="".join(
            item("SCALE", "0.0001", i, "scale") + item("OFFSET", "-0.1", i, "offset")
            for i in range(3)
        ),
        notes="are taken for parts of 1: 1 is white",
    ),
    photo("signed 16 bits", times(16), TWELVE, bits=16, kind=SIGNED),
    photo("0 to 1", times(1 / 255), bits=32, kind=FLOAT, notes="are taken for parts of 1"),
    photo("0 to 255", bits=32, kind=FLOAT, notes="are taken for 0 to 255: 255 is white"),
    photo(
        "0 to 1 with nan",
        tuple(lambda x, y, v=v: float("nan") if x < 32 else v / 255 for v in COLOUR),
        bits=64,
        kind=FLOAT,
        covered=0.5,
    ),
    photo(
        "the lowest number is no data",
        tuple(lambda x, y, v=v: -1.7976931348623157e308 if x < 32 else v / 255 for v in COLOUR),
        bits=64,
        kind=FLOAT,
        nodata="-1.7976931348623157e+308",
        covered=0.5,
    ),
    photo(
        "12 bits with a scale to radiance",
        times(16),
        TWELVE,
        bits=16,
        items="".join(item("SCALE", "0.01", i, "scale") for i in range(3)),
    ),
    photo("black", (0, 0, 0), "all of it that was read is black", means={"red": 0}),
    photo(
        "black of 16 bits",
        (0, 0, 0),
        "all of it that was read is black",
        bits=16,
        means={"red": 0},
    ),
    photo(
        "no data declared",
        tuple(lambda x, y, v=v: 0 if x < 32 else v for v in COLOUR),
        nodata="0",
        covered=0.5,
    ),
    photo("named as Sentinel-2", TURNED, photometric=MINISBLACK, extra=(0, 0), items=SENTINEL),
    photo(
        "numbered as Sentinel-2",
        TURNED,
        photometric=MINISBLACK,
        extra=(0, 0),
        items=descriptions("B2", "B3", "B4"),
    ),
    photo(
        "in words",
        TURNED,
        photometric=MINISBLACK,
        extra=(0, 0),
        items=descriptions("Blue band", "Green band", "Red band"),
    ),
    photo(
        "in letters",
        (40, 90, 40, 200),
        photometric=MINISBLACK,
        extra=(0, 0, 0),
        items=descriptions("B", "NIR", "G", "R"),
    ),
    photo(
        "red edge first",
        (90, 200, 40, 40),
        photometric=MINISBLACK,
        extra=(0, 0, 0),
        items=descriptions("red edge 1", "red", "green", "blue"),
    ),
    photo(
        "names against tags",
        TURNED,
        "band 3 is named 'B04 (red)', but tagged blue; it is taken for red",
        items=SENTINEL,
    ),
    photo(
        "two reds",
        (200, 40, 40, 90),
        "bands 1 and 4 are both named red; the first is taken",
        photometric=MINISBLACK,
        extra=(0, 0, 0),
        items=descriptions("red", "green", "blue", "red"),
    ),
    photo(
        "one name against the order",
        says="band 1 is named 'blue'; it is taken for red",
        photometric=MINISBLACK,
        extra=(0, 0),
        items=descriptions("blue"),
    ),
    photo("a palette", (7,), palette=lambda i: COLOUR if i == 7 else (1, 2, 3)),
    photo(
        "white is 0, 16 bits",
        (100 * 256,),
        bits=16,
        photometric=MINISWHITE,
        means={"red": 155},
    ),
    photo("one bit", (lambda x, y: x // 2 % 2,), bits=1, means={"red": 127.5}),
    photo("alpha", (*COLOUR, lambda x, y: 0 if x < 32 else 255), extra=(ALPHA,), covered=0.5),
    photo(
        "alpha of 12 bits in 16",
        (*times(16), lambda x, y: 0 if x < 32 else 4095),
        TWELVE,
        bits=16,
        extra=(ALPHA,),
        covered=0.5,
    ),
    photo(
        "near infrared and alpha",
        (*COLOUR, 90, lambda x, y: 0 if x < 32 else 255),
        extra=(OTHER, ALPHA),
        covered=0.5,
    ),
    photo("south up", step=(0.5, 0.5), corner=(WEST, SOUTH)),
    photo("the corner is a middle", point=True, corner=(WEST + 0.25, NORTH - 0.25)),
    photo(
        "longitudes from 0 to 360",
        keys=DEGREES,
        corner=(345.999, 46.001),
        step=(7e-5, -7e-5),
        under=heights(bands=(300,), keys=DEGREES, corner=(-14, 46), step=(7e-5, -7e-5)).write,
        valid=99,
    ),
    photo(
        "across 180 degrees",
        keys=DEGREES,
        corner=(179.998, -15.999),
        step=(7e-5, -7e-5),
        under=heights(bands=(300,), keys=DEGREES, corner=(179.999, -16), step=(7e-5, -7e-5)).write,
        valid=99,
    ),
    photo(
        "degrees beyond a turn",
        keys=DEGREES,
        corner=(400, 46),
        step=(1e-5, -1e-5),
        refused="longitudes are 400 to 400.001",
    ),
    photo(
        "degrees that are metres", keys=DEGREES, refused="allowed: -180 to 360, one turn, and -90"
    ),
    photo(
        "a mask",
        write=translated(
            Tiff((*COLOUR, lambda x, y: 0 if x < 32 else 255), extra=(ALPHA,)),
            "-b",
            "1",
            "-b",
            "2",
            "-b",
            "3",
            "-mask",
            "4",
            "--config",
            "GDAL_TIFF_INTERNAL_MASK",
            "YES",
        ),
        covered=0.5,
    ),
    photo(
        "bands apart",
        write=translated(Tiff(times(16), bits=16), "-co", "INTERLEAVE=BAND", "-co", "TILED=YES"),
        says=TWELVE,
    ),
    photo(
        "12 bits in a mosaic",
        ending="vrt",
        write=translated(Tiff(times(16), bits=16), "-of", "VRT"),
        says=TWELVE,
    ),
    photo(
        "JPEG 2000 of 12 bits",
        ending="jp2",
        write=translated(
            Tiff(times(16), bits=16),
            "-of",
            "JP2OpenJPEG",
            "-co",
            "NBITS=12",
            "-co",
            "REVERSIBLE=YES",
            "-co",
            "QUALITY=100",
        ),
    ),
    photo(
        "control points alone",
        write=translated(
            Tiff(COLOUR),
            "-gcp",
            "0",
            "0",
            "462000",
            "101032",
            "-gcp",
            "64",
            "0",
            "462032",
            "101032",
            "-gcp",
            "0",
            "64",
            "462000",
            "101000",
            "-a_srs",
            SLOVENIA,
        ),
        refused="placed by control points alone",
    ),
    photo(
        "complex values",
        write=translated(Tiff(COLOUR), "-ot", "CFloat32"),
        refused="its values are complex",
    ),
    Row(
        "tiles of JPEG in YCbCr",
        "tif",
        translated(
            Tiff(COLOUR), "-co", "COMPRESS=JPEG", "-co", "PHOTOMETRIC=YCBCR", "-co", "TILED=YES"
        ),
        means=SEEN,
        under=SURVEY,
    ),
    Row(
        "a PNG of 16 bits",
        "png",
        translated(Tiff(times(256), bits=16), "-of", "PNG", "-co", "WORLDFILE=YES"),
        means=SEEN,
        under=SURVEY,
    ),
]


def grid(name, bands=(300,), ending="tif", means=None, **facts):
    tiff = heights(
        bands=bands, **{k: v for k, v in facts.items() if k in Tiff.__dataclass_fields__}
    )
    row = {k: v for k, v in facts.items() if k not in Tiff.__dataclass_fields__}
    if means is None:
        means = {} if row.get("refused") else {"dsm": 301}  # the top of a voxel
    return Row(name, ending, row.pop("write", tiff.write), means=means, **row)


LAND = (WEST, SOUTH, WEST + 32, NORTH)
WEST_OF_GREENWICH = (577432, 5094287, 577607, 5094536)

HEIGHT_ROWS = [
    grid("heights", extent=LAND),
    grid("heights south up", step=(1, 1), corner=(WEST, SOUTH), extent=LAND),
    grid("the first cell's middle", point=True, corner=(WEST + 0.5, NORTH - 0.5), extent=LAND),
    grid("turned heights", turned=(0.5, 0.5), valid=52.8),
    grid("heights of 16 bits", bits=16, kind=SIGNED),
    grid("heights below zero of 8 bits", (-20,), bits=8, kind=SIGNED, means={"dsm": -19}),
    grid(
        "feet",
        (1000,),
        items=item("UNITTYPE", "ft", 0, "unittype"),
        means={"dsm": 305},
    ),
    grid(
        "feet of the survey",
        (1000,),
        items=item("UNITTYPE", "US survey foot", 0, "unittype"),
        means={"dsm": 305},
    ),
    grid("feet by a key", (1000,), keys=(*METRES, (4099, 9002)), means={"dsm": 305}),
    grid(
        "feet by a vertical system",
        (1000,),
        keys=(*METRES, (4096, 6360), (4099, 9003)),
        means={"dsm": 305},
    ),
    grid(
        "tenths of a metre above 100 m",
        (2000,),
        bits=16,
        items=item("SCALE", "0.1", 0, "scale") + item("OFFSET", "100", 0, "offset"),
    ),
    grid(
        "an unknown unit",
        items=item("UNITTYPE", "fathom", 0, "unittype"),
        refused="unit of heights = 'fathom'",
    ),
    grid("no data", (lambda x, y: -32767 if x < 16 else 300,), nodata="-32767", valid=50),
    grid("no data by custom", (lambda x, y: -9999 if x < 16 else 300,), valid=50),
    grid(
        "the lowest float is no data",
        (lambda x, y: -3.4028234663852886e38 if x < 16 else 300,),
        valid=50,
    ),
    grid(
        "heights with alpha",
        (200, lambda x, y: 0 if x < 16 else 255),
        bits=8,
        extra=(ALPHA,),
        means={"dsm": 201},
        valid=50,
    ),
    grid("three bands", COLOUR, bits=8, refused="it has 3 bands, and heights have one"),
    grid("three bands of 16 bits", COLOUR, bits=16, refused="give it with --ortho"),
    grid(
        "colours of a palette",
        (7,),
        bits=8,
        palette=lambda i: (i, i, i),
        refused="give it with --ortho",
    ),
    grid(
        "longitudes from 0 to 360",
        keys=DEGREES,
        corner=(346, 46),
        step=(7e-5, -7e-5),
        crs="EPSG:32628",
        extent=WEST_OF_GREENWICH,
        valid=99,
    ),
    grid(
        "across 180 degrees",
        keys=DEGREES,
        corner=(179.999, -16),
        step=(7e-5, -7e-5),
        crs="EPSG:32701",
        valid=99,
    ),
    grid(
        "degrees beyond a turn",
        keys=DEGREES,
        corner=(400, 46),
        step=(7e-5, -7e-5),
        refused="longitudes are 400 to 400.002",
    ),
    grid("degrees that are metres", keys=DEGREES, refused="or --crs with the system"),
    grid(
        "nan first",
        ending="asc",
        write=grid_of_text([["nan", *["300"] * 3], *[["300"] * 4] * 3]),
        flags=("--crs", SLOVENIA),
        refused="its first value is nan",
        is_read_by_newer_gdal=True,
        means={"dsm": 301},
        valid=93.75,
    ),
    grid(
        "nan first in all rows",
        ending="asc",
        write=grid_of_text([["nan", *["300"] * 3]] * 4, nodata="NODATA_value nan\n"),
        flags=("--crs", SLOVENIA),
        refused="its first value is nan",
        is_read_by_newer_gdal=True,
        means={"dsm": 301},
        valid=75,
    ),
    grid(
        "nan among whole numbers",
        ending="asc",
        write=grid_of_text([["300"] * 4, ["300", "nan", "nan", "300"], ["300"] * 4, ["300"] * 4]),
        flags=("--crs", SLOVENIA),
        valid=87.5,
    ),
]


def statistics(raster):
    """@return the mean of each band, and the share of cells that have a value, percent"""
    bands = json.loads(Run(["gdalinfo", "-json", "-stats", raster]).out)["bands"]
    return {
        band["description"]: (
            band["mean"],
            float(band["metadata"][""]["STATISTICS_VALID_PERCENT"]),
        )
        for band in bands
        if "mean" in band
    }


class Strangers(Case):
    def info(self, row, file):
        return Run([binary("RAYTRACER"), "world", "info", "--json", file, *row.flags])

    def check(self, row, folder):
        file = folder / f"stranger.{row.ending}"
        row.write(file)
        if row.under:
            self.check_photo(row, folder, file)
            return
        run = self.info(row, file)
        if row.refused and not (row.is_read_by_newer_gdal and run.code == 0):
            self.check_refused(row, file, run)
            return
        self.assertEqual(run.code, 0, run)
        info = json.loads(run.out)
        self.assertEqual(info["crs"], row.crs, run)
        if row.extent:
            (west, _, north), (east, _, south) = info["bounds"]["min"], info["bounds"]["max"]
            for found, right in zip((west, -south, east, -north), row.extent, strict=True):
                self.assertAlmostEqual(found, right, delta=1, msg=str(run))
        self.check_warnings(row, run)
        if row.means:
            self.check_means(row, [file], folder / "a.tif")

    def check_refused(self, row, file, run):
        self.assertIn(run.code, (1, 2), run)
        self.assertIn(row.refused, run.last, run)
        self.assertIn(file.name, run.last, run)

    def check_warnings(self, row, run):
        if row.says:
            self.assertIn(row.says, run.err, run)
        else:
            self.assertEqual(run.err, "", run)

    def check_photo(self, row, folder, file):
        survey = folder / "survey"
        row.under(survey)
        words = [survey, "--ortho", file, "--photo", "raw"]
        if row.refused:
            self.check_refused(row, file, self.terrain(words, folder / "a.tif"))
            return
        if row.covered < 1:
            bare = folder / "bare.tif"
            self.terrain([survey], bare)
            means = {
                name: row.covered * row.means[name] + (1 - row.covered) * mean
                for name, (mean, _) in statistics(bare).items()
                if name in row.means
            }
            row = dataclasses.replace(row, means=means)
        run = self.check_means(row, words, folder / "a.tif")
        warnings = [line for line in run.err.splitlines() if "[warning]" in line]
        self.assertEqual(len(warnings), 1 if row.says else 0, run)
        self.assertIn(row.says, "".join(warnings), run)
        self.assertIn(row.notes, run.err, run)

    def terrain(self, words, raster):
        return Run([binary("RAYTRACER"), "analyse", "terrain", *words, "-o", raster])

    def check_means(self, row, words, raster):
        if not shutil.which("gdalinfo"):
            self.skipTest("needs GDAL's programs")
        run = self.terrain([*words, *row.flags], raster)
        self.assertEqual(run.code, 0, run)
        for name, (mean, share) in statistics(raster).items():
            if name in row.means:
                self.assertAlmostEqual(mean, row.means[name], delta=0.5, msg=f"{row} {name}")
                self.assertAlmostEqual(share, row.valid, delta=2, msg=f"{row} {name}")
        return run

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

    @only_in_all
    def test_photographs(self):
        self.check_all(PHOTO_ROWS)

    @only_in_all
    def test_heights(self):
        self.check_all(HEIGHT_ROWS)


if __name__ == "__main__":
    unittest.main()

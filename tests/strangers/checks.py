"""What other people's inputs are checked for: a table's rows, and the classes' common part."""

import dataclasses
import json
import pathlib
import shutil
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "e2e"))

from las_files import Las, key_record

from support import Case, Run, binary, temporary_folder

SLOVENIA = "EPSG:3794"


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


SURVEY = las()
COLOUR = (200, 40, 40)


def translated(tiff, *words):
    """Rewrites a TIFF by GDAL's program. The TIFF stays: a mosaic reads it."""

    def write(file):
        if not shutil.which("gdal_translate"):
            raise unittest.SkipTest("needs GDAL's programs")
        whole = file.with_name("whole.tif")
        tiff.write(whole)
        Run(["gdal_translate", "-q", *words, whole, file]).done()

    return write


def with_prj(tiff, wkt):
    """Writes a system beside a raster that has none, as Esri's programs do."""

    def write(file):
        tiff.write(file)
        file.with_suffix(".prj").write_text(wkt, encoding="utf-8")

    return write


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

    def check_all(self, rows):
        for row in rows:
            with self.subTest(row.name):
                folder = temporary_folder()
                self.check(row, folder)
                shutil.rmtree(folder)

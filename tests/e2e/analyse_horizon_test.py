#!/usr/bin/env python3
"""Hills beyond the data, from a coarse raster of heights: what they hide, on threads and workers;
rasters that are refused."""

import shutil
import subprocess
import unittest

import analyse_test
from analysing import NO_DATA, analyse, area, area_flag
from support import Case, entries, square, temporary_folder

CELL_M = 100
HALF_CELLS = 150
RIDGE_M = 3000
WINTER = ["--date", "2026-12-21", "--zone", "Europe/Ljubljana"]


def heights(height_at):
    """@param height_at of metres east and north of the data
    @return a raster of heights, 15 km around the data"""
    folder = temporary_folder()
    west, south, east, north = area()
    left = (west + east) / 2 - HALF_CELLS * CELL_M
    bottom = (south + north) / 2 - HALF_CELLS * CELL_M
    lines = [f"ncols {2 * HALF_CELLS}", f"nrows {2 * HALF_CELLS}", f"xllcorner {left}"]
    lines += [f"yllcorner {bottom}", f"cellsize {CELL_M}", "NODATA_value -9999"]
    places = [(i + 0.5 - HALF_CELLS) * CELL_M for i in range(2 * HALF_CELLS)]
    for y in reversed(places):
        lines.append(" ".join(str(height_at(x, y)) for x in places))
    text = folder / "heights.asc"
    text.write_text("\n".join(lines) + "\n", encoding="ascii")
    file = folder / "heights.tif"
    command = ["gdalwarp", "-q", "-s_srs", "EPSG:3794", "-t_srs", "EPSG:3794", str(text), str(file)]
    subprocess.run(command, check=True)
    return file


def ridge(_east, north):
    """A ridge of 3000 m in the south."""
    return RIDGE_M if -6000 < north < -5000 else 300


@unittest.skipUnless(shutil.which("gdalwarp"), "needs GDAL's programs")
class Horizon(Case):
    values = analyse_test.Rasters.values
    worker = analyse_test.Rasters.worker

    def raster(self, kind, *flags):
        file = temporary_folder() / "a.tif"
        run = analyse(kind, square(), *area_flag(), *flags, "--quiet", "-o", file)
        self.assertEqual((run.code, run.out, run.err), (0, "", ""), run)
        return file

    def cells(self, file):
        """@return the values of the first band that are there"""
        return [v for row in self.values(file, 1) for v in row if v != NO_DATA]

    def test_the_bytes_do_not_depend_on_who_looks_at_the_hills(self):
        flags = [*WINTER, "--horizon", heights(ridge)]
        raster = self.raster("sun", *flags)
        # The ridge is 26 degrees high, the sun 21 at noon.
        free, hidden = self.cells(self.raster("sun", *WINTER)), self.cells(raster)
        self.assertLess(sum(hidden), 0.4 * sum(free))
        wanted = raster.read_bytes()
        self.assertEqual(self.raster("sun", *flags, *self.worker()).read_bytes(), wanted)

    def test_what_is_no_horizon_is_refused_in_one_line(self):
        good = heights(ridge)
        folder = temporary_folder()
        words = folder / "words.tif"
        words.write_text("mountains", encoding="ascii")
        bare = good.with_suffix(".asc")
        cases = {
            "no raster": (["energy", "--horizon", words], 1, "words.tif"),
            "an address": (["sky", "--horizon", "/vsicurl/http://x/y.tif"], 1, "y.tif"),
            "without a system": (["sky", "--horizon", bare], 1, "coordinate reference system"),
            "a range too": (["sky", "--horizon", good, "--range-m", "100"], 2, "--range-m"),
            "too far": (["sky", "--horizon", good, "--horizon-km", "1000"], 2, "400"),
            "a kind without sky": (["terrain", "--horizon", good], 2, "--horizon"),
        }
        for name, (arguments, code, says) in cases.items():
            with self.subTest(name):
                out = temporary_folder()
                kind, *flags = arguments
                run = analyse(kind, square(), *area_flag(), *flags, "-q", "-o", out / "a.tif")
                self.assertEqual(run.code, code, run)
                self.assertIn(says, run.err)
                self.assertEqual(len(run.err.strip().splitlines()), 1, run)
                self.assertEqual(entries(out), [])


if __name__ == "__main__":
    unittest.main()

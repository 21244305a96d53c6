#!/usr/bin/env python3
"""The commands of the README on small parts of real surveys.

Skipped where the shared data are missing.
"""

import json
import unittest

from support import SHARED, Case, render, temporary_folder

SMALL = ["--size", "160x90", "--samples", "1", "--quiet"]


@unittest.skipUnless(SHARED.is_dir(), f"{SHARED} is not there")
class RealData(Case):
    def pictured(self, *arguments):
        out = temporary_folder()
        self.assertDone(
            render(
                *arguments,
                *SMALL,
                "-o",
                out / "a.png",
                "-o",
                out / "a.exr",
                "--report",
                out / "r.json",
            )
        )
        self.assertEqual(json.loads((out / "r.json").read_text())["holes"], 0)
        self.assertGreater((out / "a.png").stat().st_size, 3000)
        return out

    def test_delft(self):
        folder = SHARED / "tudelft-3dfier-ahn3" / "ahn3"
        files = [folder / "ahn3_cropped_1.laz", folder / "ahn3_cropped_2.laz"]
        a = self.pictured(*files, "--crs", "EPSG:28992", "--classes", "nl-ahn")
        b = self.pictured(
            *reversed(files), "--crs", "EPSG:28992", "--classes", "nl-ahn", "--threads", "3"
        )
        self.assertAlike(a / "a.exr", b / "a.exr", exact=True)

    def test_montpellier_with_its_orthophoto(self):
        files = sorted((SHARED / "ign-pdal-tools").glob("test_data_770*_LA93_IGN69.laz"))
        self.assertEqual(len(files), 6)
        world = [*files, "--classes", "fr-lidarhd", "--voxel", "0.5"]
        plain = self.pictured(*world)
        coloured = self.pictured(
            *world, "--ortho", SHARED / "ign-pdal-tools" / "color" / "test_data_rgb.tif"
        )
        self.assertNotEqual((plain / "a.png").read_bytes(), (coloured / "a.png").read_bytes())

    def test_feet(self):
        self.pictured(SHARED / "pdal" / "las" / "autzen_trim.las")


if __name__ == "__main__":
    unittest.main()

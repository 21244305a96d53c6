"""Shapes that are added to a survey."""

import dataclasses
import json
import shutil

from checks import SURVEY, Strangers, statistics

from support import Run, binary, only_in_all, temporary_folder

# Longitudes and latitudes of 16 m x 16 m in the middle of the survey.
WEST_DEG, SOUTH_DEG, EAST_DEG, NORTH_DEG = 14.509077, 46.047816, 14.509283, 46.047960
HOUSE = {
    "type": "Polygon",
    "coordinates": [
        [
            [WEST_DEG, SOUTH_DEG],
            [EAST_DEG, SOUTH_DEG],
            [EAST_DEG, NORTH_DEG],
            [WEST_DEG, NORTH_DEG],
            [WEST_DEG, SOUTH_DEG],
        ]
    ],
}
GROUND_M, SHARE = 101, 0.25  # of the survey's cells, which the house covers


def feature(height=12, geometry=HOUSE):
    return {"type": "Feature", "properties": {"height": height}, "geometry": geometry}


@dataclasses.dataclass
class Row:
    name: str
    text: str
    height_m: float = 12
    says: str = ""  # a part of a warning; without it there is none
    refused: str = ""


def collection(name, *features, **right):
    whole = {"type": "FeatureCollection", "features": [*features]}
    return Row(name, json.dumps(whole), **right)


ROWS = [
    Row("a feature on each line", json.dumps(feature()) + "\n" + json.dumps(feature()) + "\n"),
    collection("a height below zero", feature(-3), height_m=0, says="1 of 1 objects have no"),
    Row("a topology", '{"type": "Topology", "arcs": []}', refused="feature 0 is a Topology"),
]


class Objects(Strangers):
    @only_in_all
    def test_shapes(self):
        for row in ROWS:
            with self.subTest(row.name):
                folder = temporary_folder()
                self.check_shapes(row, folder)
                shutil.rmtree(folder)

    def check_shapes(self, row, folder):
        survey, file, raster = folder / "survey.las", folder / "shapes.geojson", folder / "a.tif"
        SURVEY(survey)
        file.write_text(row.text, encoding="utf-8")
        words = ["analyse", "terrain", survey, "--add", file, "-o", raster]
        run = Run([binary("RAYTRACER"), *words])
        if row.refused:
            self.check_refused(row, file, run)
            return
        self.assertEqual(run.code, 0, run)
        warnings = [line for line in run.err.splitlines() if "[warning]" in line]
        self.assertEqual(len(warnings), 1 if row.says else 0, run)
        self.assertIn(row.says, "".join(warnings), run)
        if not shutil.which("gdalinfo"):
            self.skipTest("needs GDAL's programs")
        mean, _ = statistics(raster)["dsm"]
        self.assertAlmostEqual(mean, GROUND_M + SHARE * row.height_m, delta=0.3, msg=str(run))

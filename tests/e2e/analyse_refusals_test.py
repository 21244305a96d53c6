#!/usr/bin/env python3
"""What `terravox analyse` refuses: in one line, with nothing left behind."""

import unittest

from analysing import YEAR, analyse, area, area_flag, observer
from support import Case, Run, binary, entries, square, temporary_folder

# Words behind `terravox analyse` => what the message says. The exit code is 2, or the one in front.
# SQUARE is the survey's; YEAR, AREA and OBSERVER are options, PLACE the corner of the area.
REFUSED = """
sky SQUARE -o a.tif --area 0,0,10,10 => --area within
sky SQUARE -o a.tif --area 9,9,1,1 => --area
sky SQUARE -o a.tif --level 19 => level
sky SQUARE -o a.tif AREA --tile 20 => multiples of 16
sky SQUARE -o a.tif --report a.pdf => allowed: .html
sky SQUARE -o a.tif --map a.jpg => allowed: .svg
terrain SQUARE -o a.tif --window 4 => odd
terrain SQUARE -o a.tif --light 400,1 => --light
terrain SQUARE -o a.tif --directions 64 => --directions
terrain SQUARE -o a.tif --add 0,0,10,10 => TOP
sun SQUARE -o a.tif YEAR --date 2026-01-01 => --date together with --from
sun SQUARE -o a.tif YEAR --at 12:00 => --at together with --from
sun SQUARE -o a.tif --from 2026-01-01 => analysis.to is missing
sun SQUARE -o a.tif --monthly => --from and --to
sun SQUARE -o a.tif --at 25:00 => --at 25:00; allowed: HH:MM
sun SQUARE -o a.tif --times 08:00,8 => --times 8; allowed: HH:MM
sun SQUARE -o a.tif --times 08:00,08:00 => --times has 0800 twice
sun SQUARE -o a.tif --times 2026-02-30T08:00 => '2026-02-30' is no day of the calendar
sun SQUARE -o a.tif --times MANY => more than 96 times
sun SQUARE -o a.tif --times 08:00 --at 08:00 => --times together with --at
sun SQUARE -o a.tif --times 08:00 YEAR => --times together with --from
sun SQUARE -o a.tif --times 08:00 --resume => --times together with --resume
sun SQUARE -o a.tif --times 08:00 --map a.svg => --times together with --report or --map
sun SQUARE -o a.nc --times 08:00,2026-06-21T08:00 => sunlit_0800 and sunlit_2026-06-21T0800
sun SQUARE -o a.nc => allowed: .tif .tiff
energy SQUARE -o a.tif --albedo 1.5 => 0 to 1
energy SQUARE -o a.tif --crown-light 0.1,1.5 => analysis.crown_light = '0.1,1.5'; allowed
energy SQUARE -o a.tif --objects a.shp => allowed: .gpkg
energy SQUARE -o a.tif --objects a.gpkg --surface ground => --surface top, or --polygons
energy SQUARE -o a.tif --facades a.gml => write the facades a.gml: the ending '.gml'; allowed: .gpkg
energy SQUARE -o a.tif --facades a.gpkg --surface ground => --facades with --surface ground
energy SQUARE -o a.tif --facades a.gpkg --part 1/2 => --facades together with --part
energy SQUARE -o a.tif --facades a.gpkg --storey-m 0.2 => allowed: 1 to 1000
energy SQUARE -o a.tif --polygons a.geojson => --polygons without --objects
1 energy SQUARE -o a.tif --objects a.gpkg --polygons SQUARE => read the GeoJSON file
energy generated:3 -o a.tif => no place on Earth
sight SQUARE -o a.tif => --observer
1 sight SQUARE -o a.tif --observers SQUARE => read the GeoJSON file
sight SQUARE -o a.tif --observer 1,2,3 => outside of the data; allowed: E
sight SQUARE -o a.tif --observer PLACE => above-ground
sight SQUARE -o a.tif CROWD => 1 to 1024
sight SQUARE -o a.tif OBSERVER --refraction 2 => refraction
terrain SQUARE => --output
terrain SQUARE -o a.png => .tif
"""


class Refusals(Case):
    def test_what_cannot_be_is_refused_in_one_line_with_nothing_left_behind(self):
        place = ",".join(map(str, area()[:2]))
        stands_for = {"SQUARE": [square()], "YEAR": YEAR, "AREA": area_flag(), "PLACE": [place]}
        stands_for |= {"OBSERVER": observer(), "CROWD": ["--observer", f"{place},+2"] * 1025}
        stands_for["MANY"] = [",".join(["08:00"] * 97)]
        for row in REFUSED.strip().splitlines():
            line, says = row.split(" => ")
            code = 1 if line.startswith("1 ") else 2
            words = [
                w for word in line.removeprefix("1 ").split() for w in stands_for.get(word, [word])
            ]
            with self.subTest(line):
                folder = temporary_folder()
                run = analyse(*words, "--quiet", cwd=folder)
                self.assertEqual(run.out, "")
                self.assertRefused(run, code, says)
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

    def test_data_that_is_no_world_ends_with_one_line(self):
        folder = temporary_folder()
        (folder / "a.laz").write_bytes(b"no points")
        run = analyse("sky", "a.laz", "-o", "a.tif", "--quiet", cwd=folder)
        self.assertNotEqual(run.code, 0)
        self.assertEqual(len(run.err.strip().splitlines()), 1, run)
        self.assertEqual(entries(folder), ["a.laz"])


if __name__ == "__main__":
    unittest.main()

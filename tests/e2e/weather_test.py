#!/usr/bin/env python3
"""Energy by a weather file: its light, on threads and workers, and files that are refused."""

import json
import math
import shutil
import subprocess
import unittest

import analyse_test
from analyse_test import YEAR, analyse, area_flag
from support import Case, entries, square, temporary_folder

MONTHS = [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31]
LATITUDE = math.radians(45.9)
LONGITUDE = 14.5


def light(hour_of_year):
    """@return made-up light of an hour, Wh/m2: global, beam, diffuse"""
    day, hour = divmod(hour_of_year, 24)
    declination = math.radians(23.45) * math.sin(2 * math.pi * (285 + day) / 365)
    angle = math.radians(15 * (hour + 0.5 - 12) + LONGITUDE - 15)
    sine = math.sin(LATITUDE) * math.sin(declination)
    sine = max(0, sine + math.cos(LATITUDE) * math.cos(declination) * math.cos(angle))
    cloud = math.fmod(hour_of_year * 0.6180339887, 1)
    beam = round(900 * math.sqrt(sine) * (1 - cloud)) if cloud < 0.7 else 0
    diffuse = round(sine * (100 + 250 * cloud))
    return round(beam * sine + diffuse), beam, diffuse


def epw(light_at=light, place=(45.9, LONGITUDE), zone=1):
    """@return a weather file of a year"""
    lines = [f"LOCATION,Town,-,SVN,formula,0,{place[0]},{place[1]},{zone},300"]
    lines += ["DESIGN CONDITIONS,0", "TYPICAL/EXTREME PERIODS,0", "GROUND TEMPERATURES,0"]
    lines += ["HOLIDAYS/DAYLIGHT SAVINGS,No,0,0,0", "COMMENTS 1,", "COMMENTS 2,"]
    lines += ["DATA PERIODS,1,1,Data,Sunday, 1/ 1,12/31"]
    times = [(m + 1, d + 1, h + 1) for m in range(12) for d in range(MONTHS[m]) for h in range(24)]
    for i, (month, day, hour) in enumerate(times):
        radiation = ",".join(str(value) for value in light_at(i))
        lines.append(f"2001,{month},{day},{hour},60,?9,15,8,60,98000,9999,9999,300,{radiation},0")
    file = temporary_folder() / "town.epw"
    file.write_text("\r\n".join(lines) + "\r\n", encoding="utf-8")
    return file


@unittest.skipUnless(shutil.which("gdalinfo"), "needs GDAL's programs")
class Weather(Case):
    values = analyse_test.Rasters.values
    worker = analyse_test.Rasters.worker

    def energy(self, *flags):
        """@return the raster of a year"""
        file = temporary_folder() / "a.tif"
        run = analyse("energy", square(), *area_flag(), *YEAR, *flags, "--quiet", "-o", file)
        self.assertEqual((run.code, run.out, run.err), (0, "", ""), run)
        return file

    def test_a_raster_has_less_light_than_under_a_clear_sky_and_tells_it(self):
        file = self.energy("--weather", epw())
        info = subprocess.run(["gdalinfo", "-json", file], capture_output=True, check=True)
        scene = json.loads(info.stdout)["metadata"][""]["terravox_scene"]
        self.assertRegex(scene, r"light = '[0-9.]+,-?[0-9.]+,0;")
        clear = self.values(self.energy(), 1)
        for row, clear_row in zip(self.values(file, 1), clear):
            self.assertTrue(all(a <= b for a, b in zip(row, clear_row)))
        self.assertNotEqual(self.values(file, 1), clear)

    def test_workers_need_no_file(self):
        flags = ["--weather", epw()]
        wanted = self.energy(*flags).read_bytes()
        self.assertEqual(self.energy(*flags, *self.worker()).read_bytes(), wanted)

    def test_weather_from_afar_or_at_other_times_is_used_with_a_warning(self):
        far = epw(place=(48.2, 16.4))
        late = epw(light_at=lambda i: light((i - 5) % 8760))
        day = ["--date", "2026-06-21", "--directions", "16"]
        for file, says in (
            (epw(), ""),
            (far, "the weather is that of Town, 2"),
            (late, "does not fit the sun"),
        ):
            out = ["--weather", file, "-o", temporary_folder() / "a.tif"]
            run = analyse("energy", square(), *area_flag(), *day, *out)
            self.assertEqual(run.code, 0, run)
            self.assertIn(says, run.err)
            self.assertEqual(run.err.count("[warning]"), 1 if says else 0, run)

    def test_what_cannot_be_is_refused_in_one_line_with_nothing_left_behind(self):
        cases = {
            "no weather": (["--weather", square()], 1, "does not begin with LOCATION"),
            "a haze too": (["--weather", epw(), "--linke", "3"], 2, "together with --linke"),
            "odd steps": (["--weather", epw(), "--step-min", "45"], 2, "that fill an hour"),
            "too many directions": (
                ["--weather", epw(), "--bin-deg", "0", "--step-min", "30"],
                2,
                "bin_deg",
            ),
        }
        for name, (flags, code, says) in cases.items():
            with self.subTest(name):
                folder = temporary_folder()
                period = YEAR if "--step-min" not in flags else YEAR[:4]
                flags = [*period, *flags] if "--bin-deg" not in flags else [*YEAR[:4], *flags]
                out = ["--quiet", "-o", "a.tif"]
                run = analyse("energy", square(), *area_flag(), *flags, *out, cwd=folder)
                self.assertEqual((run.code, run.out), (code, ""), run)
                self.assertIn(says, run.err)
                self.assertEqual(len(run.err.strip().splitlines()), 1, run)
                self.assertEqual(entries(folder), [])


if __name__ == "__main__":
    unittest.main()

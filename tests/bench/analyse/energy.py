#!/usr/bin/env python3
"""Energy of clear days on level ground, beside r.sun of GRASS where installed; cost of a year."""

import numpy

from peers import CRS, Bench, bands_of, grass, installed, write_heights

HEIGHT_M = 300
LINKE = 3
DAYS = (("2026-03-21", 80), ("2026-06-21", 172), ("2026-12-21", 355))
YEAR = ["--from", "2026-01-01", "--to", "2026-12-31", "--step-min", 30]


def by_grass(bench, file, day):
    """@return global irradiation of the day, kWh/m2"""
    out = bench.scratch / "grass.tif"
    grass(
        bench.scratch,
        f"r.in.gdal -o input={file} output=heights",
        "g.region raster=heights",
        f"r.sun elevation=heights glob_rad=light linke_value={LINKE} albedo_value=0.2 "
        f"day={day} step=0.1 aspect_value=0 slope_value=0",
        f"r.out.gdal --overwrite -f input=light output={out} type=Float32",
    )
    return next(iter(bands_of(out, bench.scratch).values())).mean() / 1000


def level_days(bench):
    file = bench.scratch / "level.tif"
    write_heights(file, numpy.full((20, 20), HEIGHT_M))
    for date, day in DAYS:
        words = [
            file,
            "--date",
            date,
            "--step-min",
            6,
            "--linke",
            LINKE,
            "--zone",
            "Europe/Ljubljana",
        ]
        bands, _ = bench.analyse("energy", *words)
        ours = bands["kwh_m2"].mean()
        bench.add(f"level ground, {date}", "kWh/m2", ours)
        if installed("grass"):
            peer = by_grass(bench, file, day)
            bench.add(
                f"level ground, {date}: beside r.sun", "%", 100 * abs(ours / peer - 1), "<= 2"
            )
    if not installed("grass"):
        bench.note("GRASS is not installed: level ground has no peer.")


def year(bench):
    """Half hours of a year, over the square kilometre of the survey."""
    bands, seconds = bench.analyse("energy", bench.survey, *YEAR)
    cells = bands["kwh_m2"].size
    bench.add(
        "energy of a year in half hours, CPU time of 10^6 cells",
        "s",
        seconds * 1e6 / cells,
        "<= 120",
    )
    bands, seconds = bench.analyse("sun", bench.survey, *YEAR)
    cells = bands["sun_hours"].size
    bench.add(
        "hours of sun of a year in half hours, CPU time of 10^6 cells",
        "s",
        seconds * 1e6 / cells,
        "<= 120",
    )
    extent = ["--area", "462400,101400,462500,101500"]
    binned, _ = bench.analyse("sun", bench.survey, *YEAR, *extent)
    single, _ = bench.analyse("sun", bench.survey, *YEAR, *extent, "--bin-deg", 0)
    error = binned["sun_hours"] - single["sun_hours"]
    rms = numpy.sqrt((error**2).mean()) / single["sun_hours"].mean()
    bench.add("hours by bins beside those of all positions, of their mean", "%", 100 * rms, "<= 1")


def main():
    bench = Bench(__doc__)
    level_days(bench)
    year(bench)
    bench.note(f"Coordinates: {CRS}, without the turn of its north from the sun's.")
    bench.finish()


if __name__ == "__main__":
    main()

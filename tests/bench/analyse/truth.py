#!/usr/bin/env python3
"""Sun and sky on ground below bridges, crowns and slabs of a synthetic survey, against its truth.

The truth is walked in columns (survey_truth.py). A peer that knows heights only, any tool on a
surface model, sees their tops: its answer is that of the same walk over the true tops. The sun is
right at one of three times, the sky where its view factor is within 0.1; a cell without a value is
neither right nor counted as such."""

import numpy

from peers import NO_DATA, Bench, direction_of, latitude_longitude, sun_of
from survey_truth import NOTHING, is_free, sky_view, true_columns

AREA = (462290, 101240, 462960, 101700)  # has all that the survey builds
DATE = "2026-06-21"
TIMES = ("08:00", "11:00", "15:00")
CELLS = 300
VOXELS = ()
ALLOWED_SVF = 0.1
EYE_M = 0.5
WORDS = {"deck": "below bridges", "crown": "below crowns", "slab": "below slabs"}


def cells_of(columns, random):
    """@return by what is above them, rows of cells' middles and their height: ground with one thing
    above it, and nothing else in its cell"""
    rows, width = columns.shape
    there = {name: high > -NOTHING for name, (_, high) in columns.layers.items()}
    out = {}
    for name in ("deck", "crown", "slab"):
        only = there[name].copy()
        for other, mask in there.items():
            if other != name:
                only &= ~mask
        # Clear of the ground, so that a person could stand there.
        only &= columns.layers[name][0] > columns.ground + 2
        cells = only.reshape(rows // 2, 2, width // 2, 2).all((1, 3))
        row, column = numpy.nonzero(cells)
        east = columns.west + column
        north = columns.north - row
        inner = (east >= AREA[0]) & (east < AREA[2]) & (north > AREA[1]) & (north <= AREA[3])
        row, column = row[inner], column[inner]
        picked = random.permutation(len(row))[:CELLS]
        out[name] = (row[picked], column[picked])
    return out


def compare(bench, columns, name, places, answers, suns):
    """@param answers bands by name: sky and times
    @param suns directions by time"""
    row, column = places
    east = columns.west + column + 0.5
    north = columns.north - row - 0.5
    at = (row * 2 + 1, column * 2 + 1)
    cell = (row - round(columns.north - AREA[3]), column - round(AREA[0] - columns.west))
    ground = columns.ground[at]
    if name == "deck":
        ground = numpy.maximum(ground, columns.water[at])
    below = numpy.stack([east, north, ground + EYE_M], 1)
    tops = columns.tops()
    above = numpy.stack([east, north, tops[at] + 0.01], 1)
    known = answers["sky"][cell] != NO_DATA
    sun_right = {"": [], ", heights only": []}
    for time, sun in suns.items():
        truth = is_free(columns, below, sun, None)
        sun_right[""].append(((answers[time][cell] > 0) == truth)[known])
        sun_right[", heights only"].append(is_free(columns, above, sun, tops) == truth)
    sky = sky_view(columns, below, None)
    error = answers["sky"][cell][known] - sky[known]
    sky_right = {
        "": numpy.abs(error) <= ALLOWED_SVF,
        ", heights only": numpy.abs(sky_view(columns, above, tops) - sky) <= ALLOWED_SVF,
    }
    label = f"{WORDS[name]} ({len(row)} cells)"
    bench.add(f"{label}: with a value", "%", 100 * known.mean())
    for who, bound in (("", ">= 95"), (", heights only", "")):
        bench.add(f"{label}{who}: sun right", "%", 100 * numpy.mean(sun_right[who]), bound)
        bench.add(f"{label}{who}: sky right", "%", 100 * sky_right[who].mean(), bound)
    bench.add(f"{label}: mean error of the sky-view factor", "", error.mean())


def main():
    bench = Bench(__doc__)
    random = numpy.random.default_rng(5)
    columns = true_columns(bench.survey, bench.scratch)
    lat, lon = latitude_longitude(
        (columns.west + columns.east) / 2, (columns.south + columns.north) / 2
    )
    area = ",".join(map(str, AREA))
    ground = ["--surface", "ground", "--area", area, *VOXELS]
    bands, _ = bench.analyse("sky", bench.survey, *ground)
    answers = {"sky": bands["svf"]}
    suns = {}
    for time in TIMES:
        words = [*ground, "--date", DATE, "--zone", "UTC", "--at", time]
        bands, _ = bench.analyse("sun", bench.survey, *words)
        answers[time] = bands["sunlit"]
        hours, minutes = time.split(":")
        altitude, azimuth = sun_of(DATE, int(hours) + int(minutes) / 60, lat, lon)
        suns[time] = direction_of(altitude, azimuth)
    for name, places in cells_of(columns, random).items():
        compare(bench, columns, name, places, answers, suns)
    bench.finish()


if __name__ == "__main__":
    main()

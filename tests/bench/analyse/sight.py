#!/usr/bin/env python3
"""Viewsheds of a raster of heights, beside gdal_viewshed, and r.viewshed of GRASS where installed.

All see the same heights: those of the voxels that Terravox makes of a synthetic survey. Compared
are cells off edges: without a neighbour of another answer in either raster. Some of them are also
held to a slow answer, a walk over the squares of the raster in steps of a quarter of a cell."""

import numpy

from peers import (
    NO_DATA,
    NORTH,
    WEST,
    Bench,
    bands_of,
    grass,
    installed,
    near_edge,
    run,
    write_heights,
)

EARTH_M = 6371008.8
REFRACTION = 0.13
OBSERVERS = [(1.75, 0), (10, 1.75), (30, 0), (1.75, 1.75), (10, 0), (30, 1.75)]
PROBES = 1000


def is_free(heights, eye, cell, target):
    """Whether the line over the squares of the raster is free.

    @param eye column, row, height
    """
    column, row, height = eye
    x, y = cell
    distance = numpy.hypot(x - column, y - row)
    steps = int(distance * 4) + 2
    t = (numpy.arange(steps) + 0.5) / steps
    line = height + (heights[y, x] + target - height) * t
    line -= (1 - REFRACTION) / (2 * EARTH_M) * distance**2 * t * (1 - t)
    rows = (row + 0.5 + (y - row) * t).astype(int)
    columns = (column + 0.5 + (x - column) * t).astype(int)
    return bool((heights[rows, columns] <= line).all())


def by_gdal(bench, east, north, above, target):
    """@return what is seen, CPU seconds"""
    out = bench.scratch / "gdal.tif"
    seconds = run(
        *["gdal_viewshed", "-q", "-ox", east, "-oy", north, "-oz", above, "-tz", target],
        *["-vv", 1, "-iv", 0, "-ov", 0, "-cc", 1 - REFRACTION],
        *[bench.scratch / "heights.tif", out],
    )
    return next(iter(bands_of(out, bench.scratch).values())) > 0, seconds


def by_grass(bench, east, north, above, target):
    """@return what is seen, CPU seconds with the program's start"""
    out = bench.scratch / "grass.tif"
    seconds = grass(
        bench.scratch,
        f"r.in.gdal -o input={bench.scratch}/heights.tif output=heights",
        "g.region raster=heights",
        f"r.viewshed -b -c -r input=heights output=seen coordinates={east},{north} "
        f"observer_elevation={above} target_elevation={target} refraction_coeff={REFRACTION}",
        f"r.out.gdal --overwrite -f input=seen output={out} type=Byte",
    )
    return next(iter(bands_of(out, bench.scratch).values())) == 1, seconds


class Totals:
    """Sums over all observers."""

    def __init__(self):
        self.agree = {}
        self.counted = {}
        self.right = {}
        self.probes = 0
        self.seconds = {}

    def add(self, name, agree, counted, seconds):
        self.agree[name] = self.agree.get(name, 0) + agree
        self.counted[name] = self.counted.get(name, 0) + counted
        self.seconds[name] = self.seconds.get(name, 0) + seconds


def compare(bench, heights, random, case, totals):
    above, target = case
    column = int(random.integers(50, heights.shape[1] - 50))
    row = int(random.integers(50, heights.shape[0] - 50))
    east, north = WEST + column + 0.5, NORTH - row - 0.5
    bands, seconds = bench.analyse(
        *["sight", bench.scratch / "heights.tif"],
        *["--observer", f"{east},{north},+{above}", "--target-height", target],
    )
    valid = bands["seen"] != NO_DATA
    ours = bands["seen"] > 0
    totals.seconds["terravox"] = totals.seconds.get("terravox", 0) + seconds
    peers = {"gdal_viewshed": by_gdal}
    if installed("grass"):
        peers["r.viewshed"] = by_grass
    answers = {"terravox": ours}
    for name, peer in peers.items():
        answers[name], peer_s = peer(bench, east, north, above, target)
        counted = valid & ~near_edge(ours) & ~near_edge(answers[name])
        totals.add(name, ((ours == answers[name]) & counted).sum(), counted.sum(), peer_s)
    certain = valid.copy()
    for seen in answers.values():
        certain &= ~near_edge(seen)
    rows, columns = numpy.nonzero(certain)
    eye = (column, row, float(heights[row, column]) + above)
    totals.probes += PROBES
    for i in random.integers(0, len(rows), PROBES):
        cell = (int(columns[i]), int(rows[i]))
        free = is_free(heights, eye, cell, target)
        for name, seen in answers.items():
            totals.right[name] = totals.right.get(name, 0) + (free == seen[cell[1], cell[0]])


def main():
    bench = Bench(__doc__)
    random = numpy.random.default_rng(3)
    surface, _ = bench.analyse("terrain", bench.survey)
    heights = numpy.round(surface["dsm"])
    heights[heights < 0] = heights[heights >= 0].min()
    write_heights(bench.scratch / "heights.tif", heights)
    surface, _ = bench.analyse("terrain", bench.scratch / "heights.tif")
    heights = surface["dsm"].astype(float)
    write_heights(bench.scratch / "heights.tif", heights)
    totals = Totals()
    for case in OBSERVERS:
        compare(bench, heights, random, case, totals)
    for name, agree in totals.agree.items():
        bench.add(f"agree with {name}", "%", 100 * agree / totals.counted[name], ">= 98")
    for name, right in totals.right.items():
        bench.add(f"right: {name}", "%", 100 * right / totals.probes)
    for name, seconds in totals.seconds.items():
        bench.add(f"CPU time of {len(OBSERVERS)} observers: {name}", "s", seconds)
    if "r.viewshed" not in totals.agree:
        bench.note("GRASS is not installed: gdal_viewshed is the only peer.")
    bench.finish()


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Viewsheds of a raster of heights by terravox analyse sight, beside gdal_viewshed.

Both see the same heights: those of the voxels that Terravox makes of the raster. Compared are cells
off edges: without a neighbour of another answer in either raster. Some of them are also held to a
slow third answer, a walk over the squares of the raster in steps of a quarter of a cell.
Needs GDAL's programs and NumPy."""

import argparse
import pathlib
import re
import resource
import subprocess
import tempfile

import numpy

EARTH_M = 6371008.8
REFRACTION = 0.13
NO_DATA = -9999
OBSERVERS = [(1.75, 0), (10, 1.75), (30, 0), (1.75, 1.75), (10, 0), (30, 1.75)]
PROBES = 4000


def run(*words):
    """@return CPU seconds"""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([str(word) for word in words], check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def read(file, scratch):
    """@return the first band by row, and the west and north of the raster"""
    raw = scratch / "band.raw"
    run("gdal_translate", "-q", "-of", "ENVI", "-ot", "Float32", "-b", 1, file, raw)
    header = raw.with_suffix(".hdr").read_text(encoding="utf-8")
    rows = int(re.search(r"lines\s*=\s*(\d+)", header).group(1))
    place = re.search(r"map info = \{[^,]*, *1, *1, *([-\d.]+), *([-\d.]+)", header)
    return numpy.fromfile(raw, "<f4").reshape(rows, -1), float(place[1]), float(place[2])


def near_edge(seen):
    """@return the cells with a neighbour of another answer"""
    out = numpy.zeros(seen.shape, bool)
    for dy in (-1, 0, 1):
        for dx in (-1, 0, 1):
            out |= numpy.roll(numpy.roll(seen, dy, 0), dx, 1) != seen
    return out


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


def compare(args, scratch, heights, west, north, random, case):
    above, target = case
    column = int(random.integers(50, heights.shape[1] - 50))
    row = int(random.integers(50, heights.shape[0] - 50))
    east, northing = west + column + 0.5, north - row - 0.5
    peer_s = run(
        *["gdal_viewshed", "-q", "-ox", east, "-oy", northing, "-oz", above, "-tz", target],
        *["-vv", 1, "-iv", 0, "-ov", 0, "-cc", 1 - REFRACTION],
        *[scratch / "heights.tif", scratch / "peer.tif"],
    )
    ours_s = run(
        *[args.program, "analyse", "sight", args.heights, "-q", "-o", scratch / "ours.tif"],
        *["--observer", f"{east},{northing},+{above}", "--target-height", target],
    )
    ours, _, _ = read(scratch / "ours.tif", scratch)
    peer, _, _ = read(scratch / "peer.tif", scratch)
    valid = ours != NO_DATA
    ours = ours > 0
    peer = peer > 0
    counted = valid & ~near_edge(ours) & ~near_edge(peer)
    agree = (ours == peer) & counted
    rows, columns = numpy.nonzero(counted)
    eye = (column, row, float(heights[row, column]) + above)
    probes = random.integers(0, len(rows), PROBES)
    right = {"ours": 0, "peer": 0}
    for i in probes:
        cell = (int(columns[i]), int(rows[i]))
        free = is_free(heights, eye, cell, target)
        right["ours"] += free == ours[cell[1], cell[0]]
        right["peer"] += free == peer[cell[1], cell[0]]
    print(
        f"| +{above} m | {target} m | {ours[valid].mean():.1%} | {peer[valid].mean():.1%} "
        f"| {agree.sum() / counted.sum():.2%} | {right['ours'] / PROBES:.2%} "
        f"| {right['peer'] / PROBES:.2%} | {ours_s:.2f} | {peer_s:.2f} |"
    )
    return agree.sum(), counted.sum()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("heights", help="a raster of heights, cells of 1 m")
    parser.add_argument("--program", default="terravox-raytracer")
    parser.add_argument("--seed", type=int, default=3)
    args = parser.parse_args()
    random = numpy.random.default_rng(args.seed)
    with tempfile.TemporaryDirectory() as folder:
        scratch = pathlib.Path(folder)
        terrain = scratch / "terrain.tif"
        run(args.program, "analyse", "terrain", args.heights, "-q", "-o", terrain)
        run("gdal_translate", "-q", "-b", 1, terrain, scratch / "heights.tif")
        heights, west, north = read(scratch / "heights.tif", scratch)
        print(
            "| observer | target | seen | peer | agree | ours right | peer right | CPU s | peer |"
        )
        print("|---|---|---|---|---|---|---|---|---|")
        agree, counted = numpy.sum(
            [compare(args, scratch, heights, west, north, random, case) for case in OBSERVERS],
            axis=0,
        )
        print(f"all: {agree / counted:.2%} of {counted} cells off edges")


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Sky-view factors against closed forms, and their cost, beside solweig (PyPI) where installed."""

import logging

import numpy

from peers import Bench, module, own_seconds, town, write_heights

PATCHES = 153


def canyon(width, height, side=401):
    heights = numpy.full((side, side), 100.0 + height)
    first = side // 2 - width // 2
    heights[:, first : first + width] = 100
    middle = (
        slice(side // 2 - 32, side // 2 + 32),
        slice(first + width // 2, first + width // 2 + 1),
    )
    return heights, middle, numpy.sin(numpy.pi / 2 - numpy.arctan(2 * height / width))


def basin(radius, height):
    half = radius + 20
    y, x = numpy.mgrid[-half : half + 1, -half : half + 1]
    heights = numpy.where(numpy.hypot(x, y) <= radius, 100.0, 100.0 + height)
    middle = (slice(half, half + 1), slice(half, half + 1))
    return heights, middle, numpy.cos(numpy.arctan(height / radius)) ** 2


CASES = (
    ("canyon H/W 0.5", canyon(41, 20), 0.005),
    ("canyon H/W 1", canyon(41, 41), 0.005),
    ("canyon H/W 2", canyon(41, 82), 0.005),
    ("basin H/R 0.5", basin(160, 80), 0.01),
    ("basin H/R 1", basin(120, 120), 0.01),
    ("basin H/R 2", basin(70, 140), 0.01),
)


def solweig_sky(heights):
    """@return the peer's factors, or None"""
    solweig = module("solweig")
    if solweig is None:
        return None
    logging.disable(logging.CRITICAL)
    solweig.disable_gpu()
    surface = heights.astype(numpy.float32)
    none = numpy.zeros_like(surface)
    highest = float(surface.max())
    sky = solweig.rustalgos.skyview
    return numpy.asarray(sky.calculate_svf(surface, none, none, 1.0, False, highest, 2).svf)


def main():
    bench = Bench(__doc__)
    file = bench.scratch / "heights.tif"
    for name, (heights, middle, truth), allowed in CASES:
        write_heights(file, heights)
        bands, _ = bench.analyse("sky", file)
        bench.add(f"{name}: error", "", abs(bands["svf"][middle].mean() - truth), f"<= {allowed}")
        peer = solweig_sky(heights)
        if peer is not None:
            bench.add(f"{name}: error, solweig", "", abs(peer[middle].mean() - truth))
    heights = town(1000)
    write_heights(file, heights)
    bands, seconds = bench.analyse("sky", file, "--directions", PATCHES)
    bench.add(f"10^6 cells, {PATCHES} directions: CPU time", "s", seconds)
    peer, peer_seconds = own_seconds(lambda: solweig_sky(heights))
    if peer is None:
        bench.note("solweig is not installed: no peer.")
    else:
        bench.add("10^6 cells: CPU time, solweig", "s", peer_seconds)
        bench.add("10^6 cells: CPU time / solweig's", "x", seconds / peer_seconds, "<= 0.5")
        _, few = bench.analyse("sky", file, "--directions", 64)
        bench.add("the same with 64 directions: CPU time / solweig's", "x", few / peer_seconds)
        bench.add("10^6 cells: mean / solweig's mean", "x", bands["svf"].mean() / peer.mean())
    bench.finish()


if __name__ == "__main__":
    main()

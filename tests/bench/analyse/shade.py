#!/usr/bin/env python3
"""Shadow masks and hours of sun of an invented town, beside an exact walk over its raster of
heights, and solweig (PyPI) where installed; the sun is pvlib's."""

import numpy

from peers import (
    NORTH,
    WEST,
    Bench,
    latitude_longitude,
    module,
    near_edge,
    sun_of,
    town,
    write_heights,
)

SIDE = 400
DATE = "2026-06-21"
STEP_MIN = 30


def squares(azimuth, reach):
    """Visits the squares that a ray from the middle of one goes through: columns to the east, rows
    to the south, and the distance at which it enters."""
    east, south = numpy.sin(numpy.radians(azimuth)), -numpy.cos(numpy.radians(azimuth))
    along = []
    for axis, part in enumerate((east, south)):
        if abs(part) < 1e-12:
            continue
        for k in range(int(reach * abs(part)) + 1):
            along.append(((k + 0.5) / abs(part), axis, int(numpy.sign(part))))
    at = [0, 0]
    for distance, axis, step in sorted(along):
        if distance > reach:
            return
        at[axis] += step
        yield at[0], at[1], distance


def walk(heights, altitude, azimuth):
    """Which cells the sun reaches: exact for squares with flat tops, seen from their middles."""
    rows, columns = heights.shape
    lit = numpy.ones(heights.shape, bool)
    rise = numpy.tan(numpy.radians(altitude))
    reach = (heights.max() - heights.min()) / rise
    for dx, dy, distance in squares(azimuth, min(reach, rows + columns)):
        y0, y1 = max(0, -dy), min(rows, rows - dy)
        x0, x1 = max(0, -dx), min(columns, columns - dx)
        if y0 >= y1 or x0 >= x1:
            break
        above = heights[y0 + dy : y1 + dy, x0 + dx : x1 + dx]
        lit[y0:y1, x0:x1] &= above <= heights[y0:y1, x0:x1] + distance * rise
    return lit


def solweig_mask(heights, altitude, azimuth):
    """@return the peer's mask, or None"""
    solweig = module("solweig")
    if solweig is None:
        return None
    solweig.disable_gpu()
    surface = heights.astype(numpy.float32)
    shadowing = solweig.rustalgos.shadowing
    highest = float(surface.max() - surface.min())
    found = shadowing.calculate_shadows_wall_ht_25(azimuth, altitude, 1.0, highest, surface)
    return numpy.asarray(found.bldg_sh) > 0.5


def agreement(ours, other):
    counted = ~near_edge(ours) & ~near_edge(other)
    return 100 * (ours == other)[counted].mean()


def main():
    bench = Bench(__doc__)
    file = bench.scratch / "heights.tif"
    write_heights(file, town(SIDE))
    surface, _ = bench.analyse("terrain", file)
    heights = surface["dsm"].astype(float)
    lat, lon = latitude_longitude(WEST + SIDE / 2, NORTH - SIDE / 2)
    for hour in (4.5, 6, 8, 11, 15, 17.5):
        altitude, azimuth = sun_of(DATE, hour, lat, lon)
        at = f"{int(hour):02}:{round(hour % 1 * 60):02}"
        bands, _ = bench.analyse("sun", file, "--date", DATE, "--zone", "UTC", "--at", at)
        ours = bands["sunlit"] > 0
        name = f"{at} UTC, sun at {altitude:.0f} degrees"
        bench.add(f"{name}: agree", "%", agreement(ours, walk(heights, altitude, azimuth)), ">= 99")
        peer = solweig_mask(heights, altitude, azimuth)
        if peer is not None:
            bench.add(f"{name}: agree with solweig", "%", agreement(ours, peer), ">= 99")
    words = ["--date", DATE, "--zone", "UTC", "--step-min", STEP_MIN]
    bands, _ = bench.analyse("sun", file, *words)
    hours = {"the walk": numpy.zeros(heights.shape), "solweig": numpy.zeros(heights.shape)}
    has_peer = module("solweig") is not None
    for middle in numpy.arange(STEP_MIN / 120, 24, STEP_MIN / 60):
        altitude, azimuth = sun_of(DATE, middle, lat, lon)
        if altitude <= 0:
            continue
        hours["the walk"] += walk(heights, altitude, azimuth) * STEP_MIN / 60
        if has_peer:
            hours["solweig"] += solweig_mask(heights, altitude, azimuth) * STEP_MIN / 60
    for name, other in hours.items():
        if name == "solweig" and not has_peer:
            bench.note("solweig is not installed: the walk is the only peer.")
            continue
        error = bands["sun_hours"] - other
        rms = numpy.sqrt((error**2).mean())
        bench.add(f"hours of a day: root mean square beside {name}", "h", rms, "<= 0.1")
        bench.add(f"hours of a day: mean difference to {name}", "h", error.mean())
    bench.finish()


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Facades of a synthetic survey against its truth: the direction, area, hours of sun and view of
the sky of the walls of its houses.

A wall of the truth is a side of a house that stands alone, from the ground to the eaves. Its sun
and sky are those of points half a metre before it, by the walk of survey_truth.py. It is compared
with what `--facades` gives for that building in that direction. The sun is right within an hour of
the day, the sky within 0.05 (half of what a wall can see is 0.25)."""

import contextlib
import json
import sqlite3
import struct

import numpy

from peers import CRS, Bench, direction_of, latitude_longitude, run, sun_of
from survey_truth import in_polygon, is_free, true_columns
from true_voxels import write_true_voxels

AREA = (462290, 101240, 462960, 101700)
DATE = "2026-06-21"
STEP_MIN = 10  # the sun goes by 2.5 degrees, less than the directions of walls are off
BEFORE_M = 0.55  # a column of the truth is half a metre wide
VOXEL_M = 1
LEAST_SIDE_M = 5
LEAST_WALL_M = 2.5
SAME_WAY_DEG = 22.5
ALLOWED_H = 1
ALLOWED_SKY = 0.05
RAYS = 128


class Side:
    """A wall of a house in the truth."""

    def __init__(self, house, ends, ground_m):
        self.house = house
        (x0, y0), (x1, y1) = ends
        self.length_m = numpy.hypot(x1 - x0, y1 - y0)
        # Footprints run anticlockwise, so their outside is to the right.
        self.normal = numpy.array([(y1 - y0), -(x1 - x0)]) / self.length_m
        self.azimuth_deg = numpy.degrees(numpy.arctan2(*self.normal)) % 360
        self.bottom_m = ground_m
        self.top_m = house["eaves_m"]
        along = numpy.arange(0.5, self.length_m, 1)
        up = numpy.arange(self.bottom_m + 0.5, self.top_m, 1)
        share, height = numpy.meshgrid(along / self.length_m, up)
        self.eyes = numpy.stack(
            [
                (x0 + (x1 - x0) * share + self.normal[0] * BEFORE_M).ravel(),
                (y0 + (y1 - y0) * share + self.normal[1] * BEFORE_M).ravel(),
                height.ravel(),
            ],
            1,
        )

    def area_m2(self):
        return self.length_m * (self.top_m - self.bottom_m)

    def cosine(self, direction):
        return max(numpy.dot(self.normal, direction[:2]), 0)


def even_sky():
    """@return directions of equal solid angles over the upper half sphere"""
    i = numpy.arange(RAYS)
    up = (i + 0.5) / RAYS
    level = numpy.sqrt(1 - up * up)
    turn = i * 2.39996322972865332
    return numpy.stack([level * numpy.sin(turn), level * numpy.cos(turn), up], 1)


def free_shares(columns, sides, direction):
    """@return of each wall the share of its points from which a direction is free; 0 from behind"""
    facing = [side for side in sides if side.cosine(direction) > 0]
    out = {}
    if facing:
        free = is_free(columns, numpy.concatenate([s.eyes for s in facing]), direction, None)
        ends = numpy.cumsum([len(side.eyes) for side in facing])
        parts = numpy.split(free, ends[:-1])
        out = {id(side): part.mean() for side, part in zip(facing, parts, strict=True)}
    return [out.get(id(side), 0) for side in sides]


def true_hours(columns, sides, suns):
    return sum(numpy.array(free_shares(columns, sides, to)) for to in suns) * STEP_MIN / 60


def true_sky(columns, sides):
    """@return shares of an even sky's light"""
    out = numpy.zeros(len(sides))
    for to in even_sky():
        cosines = numpy.array([side.cosine(to) for side in sides])
        out += numpy.array(free_shares(columns, sides, to)) * cosines * 2 / RAYS
    return out


def outline_of(blob):
    """@return the corners of the first ring of a polygon in a GeoPackage"""
    envelope = (0, 32, 48, 48, 64)[(blob[3] >> 1) & 7]
    at = 8 + envelope
    order = "<" if blob[at] else ">"
    (kind,) = struct.unpack_from(order + "I", blob, at + 1)
    at += 9 + (9 if kind % 1000 == 6 else 0)
    (count,) = struct.unpack_from(order + "I", blob, at)
    numbers = struct.unpack_from(f"{order}{2 * count}d", blob, at + 4)
    return list(zip(numbers[::2], numbers[1::2], strict=True))


def rows_of(file, layer):
    with contextlib.closing(sqlite3.connect(file)) as data:
        data.row_factory = sqlite3.Row
        return [dict(row) for row in data.execute(f"SELECT * FROM {layer}")]


def middle_of(house):
    return numpy.mean(house["footprint"], 0)


def holds(corners, point):
    x, y = numpy.array([[point[0]]]), numpy.array([[point[1]]])
    return bool(in_polygon(x, y, corners)[0, 0])


def houses_of(survey):
    """@return houses with straight walls, slabs and all others"""
    place = json.loads((survey / "truth/place.json").read_text(encoding="utf-8"))
    name = place["files"][0]["name"]
    truth = json.loads((survey / f"truth/truth_{name}.json").read_text(encoding="utf-8"))
    every = [house for house in truth["buildings"] if "underside_m" not in house]
    return [house for house in every if len(house["footprint"]) == 4], every


def stand_alone(houses, every, objects):
    """@return pairs of a house and the number of the building that it alone is"""
    out = []
    for thing in objects:
        corners = outline_of(thing["geom"])
        within = [house for house in every if holds(corners, middle_of(house))]
        if len(within) == 1 and within[0] in houses:
            out.append((within[0], thing["id"]))
    return out


def sides_of(house, columns):
    corners = house["footprint"]
    for ends in zip(corners, corners[1:] + corners[:1], strict=True):
        (x, y) = numpy.mean(ends, 0)
        row = int((columns.north - y) / 0.5)
        column = int((x - columns.west) / 0.5)
        side = Side(house, ends, max(house["ground_m"], columns.ground[row, column]))
        if side.length_m >= LEAST_SIDE_M and side.top_m - side.bottom_m >= LEAST_WALL_M:
            yield side


def turned(a, b):
    return abs((a - b + 180) % 360 - 180)


class Found:
    """What the facades of one building have in one direction."""

    def __init__(self, rows):
        area = numpy.array([row["area_m2"] for row in rows])
        self.area_m2 = area.sum()

        def mean(name):
            return sum(row[name] * row["area_m2"] for row in rows) / self.area_m2

        self.hours = mean("sun_hours")
        self.sky = mean("sky_view")
        azimuth = numpy.radians([row["azimuth_deg"] for row in rows])
        east = (numpy.sin(azimuth) * area).sum()
        north = (numpy.cos(azimuth) * area).sum()
        self.azimuth_deg = numpy.degrees(numpy.arctan2(east, north)) % 360


def matched(pairs, facades, columns):
    """@return walls of the truth, with what is found of them, and the number of those without"""
    sides, founds = [], []
    missing = 0
    for house, building in pairs:
        own = [row for row in facades if row["building"] == building]
        for side in sides_of(house, columns):
            rows = [r for r in own if turned(r["azimuth_deg"], side.azimuth_deg) <= SAME_WAY_DEG]
            if not rows:
                missing += 1
                continue
            sides.append(side)
            founds.append(Found(rows))
    return sides, founds, missing


def compare(bench, measured, columns, suns, what=""):
    """@param what begins the names of the readings; these have no targets then"""
    facades, objects = measured
    pairs = stand_alone(*houses_of(bench.survey), objects)
    sides, founds, missing = matched(pairs, facades, columns)
    both = list(zip(sides, founds, strict=True))
    errors = {
        "azimuth": [turned(found.azimuth_deg, side.azimuth_deg) for side, found in both],
        "area": [f.area_m2 / s.area_m2() - 1 for s, f in both if s.house["roof"] != "gable"],
        "hours": [found.hours for found in founds] - true_hours(columns, sides, suns),
        "sky": [found.sky for found in founds] - true_sky(columns, sides),
    }
    errors = {name: numpy.array(values) for name, values in errors.items()}
    count = len(sides)
    label = f"{what}{count} walls"
    target = "" if what else ">= 95"
    bench.add(f"{label}: have a facade", "%", 100 * count / (count + missing), target)
    bench.add(f"{label}: direction, mean error", "degrees", errors["azimuth"].mean())
    bench.add(f"{label}: direction within 5 degrees", "%", 100 * (errors["azimuth"] <= 5).mean())
    area = 100 * errors["area"].mean()
    bench.add(f"{label}: area below hipped and flat roofs, mean error", "%", area)
    within = numpy.abs(errors["hours"]) <= ALLOWED_H
    bench.add(f"{label}: hours of sun within an hour", "%", 100 * within.mean(), target)
    bench.add(f"{label}: hours of sun, mean error", "h", errors["hours"].mean())
    within = numpy.abs(errors["sky"]) <= ALLOWED_SKY
    bench.add(f"{label}: view of the sky within 0.05", "%", 100 * within.mean(), target)
    bench.add(f"{label}: view of the sky, mean error", "", errors["sky"].mean())


def measure(bench, data):
    """@return rows of facades and of objects"""
    facades, objects = bench.scratch / "facades.gpkg", bench.scratch / "objects.gpkg"
    words = ["--area", ",".join(map(str, AREA)), "--date", DATE, "--zone", "UTC"]
    words += ["--step-min", STEP_MIN, "--facades", facades]
    words += ["--objects", objects, "-q", "-o", bench.scratch / "e.tif"]
    run(bench.program, "analyse", "energy", data, *words)
    return rows_of(facades, "facades"), rows_of(objects, "objects")


def compare_limit(bench, columns, suns):
    """Readings of what voxels of that size can reach: the same walls in the truth's own voxels."""
    archive = bench.scratch / "truth.tvx"
    archive.unlink(missing_ok=True)
    try:
        write_true_voxels(columns, VOXEL_M, CRS, archive)
    except ImportError as missing:
        bench.note(f"no limit by the truth's own voxels: {missing}")
        return
    compare(bench, measure(bench, archive), columns, suns, "the truth as voxels, ")


def main():
    bench = Bench(__doc__)
    columns = true_columns(bench.survey, bench.scratch)
    lat, lon = latitude_longitude(
        (columns.west + columns.east) / 2, (columns.south + columns.north) / 2
    )
    middles = numpy.arange(STEP_MIN / 120, 24, STEP_MIN / 60)
    places = [sun_of(DATE, hour, lat, lon) for hour in middles]
    suns = [direction_of(*place) for place in places if place[0] > 0]
    compare(bench, measure(bench, bench.survey), columns, suns)
    compare_limit(bench, columns, suns)
    bench.finish()


if __name__ == "__main__":
    main()

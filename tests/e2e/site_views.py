"""A site in a browser next to the ray tracer's pictures of it, pixel by pixel."""

import array
import json
import math
import os
import pathlib
import subprocess

from static_host import StaticHost
from support import HANGS_S, ROOT, Run, binary, render

# One sample for each pixel, of which nothing is left to chance.
PLAIN = ["--look", "plain", "--samples", "1", "--quality-cut-outs", "no", "--sun-size", "0"]
PLAIN += ["--layers", "all"]
LATITUDE_DEG = 46.1
SOLAR_NOON_H = 11.05  # UTC, at the longitude of the synthetic survey
SUN_AT_LEAST_DEG = 4
YEAR_STARTS_MS = 1767225600000  # 2026, UTC
DAY_MIN = 1440
SUMMER_AFTERNOON_MIN = 171 * DAY_MIN + 15 * 60 + 30  # 21 June, 15:30 UTC


class NoBrowser(Exception):
    pass


class View:
    """A camera and a time. @param position, target voxels: x east, y up, z south"""

    def __init__(self, name, position, target, fov_deg=42, minute=SUMMER_AFTERNOON_MIN):
        self.name = name
        self.position = position
        self.target = target
        self.fov_deg = fov_deg
        self.minute = minute  # of the year 2026, UTC

    def at(self, name, minute):
        return View(name, self.position, self.target, self.fov_deg, minute)

    def link(self):
        east, up, south = (t - p for t, p in zip(self.target, self.position, strict=True))
        heading = math.degrees(math.atan2(east, -south)) % 360
        pitch = math.degrees(math.atan2(up, math.hypot(east, south)))
        place = ",".join(map(repr, map(float, self.position)))
        time = YEAR_STARTS_MS // 60_000 + self.minute
        return f"#at={place}&look={heading!r},{pitch!r},{self.fov_deg}&time={time}"

    def flags(self, size):
        """Of the ray tracer."""
        day, minute = divmod(self.minute, DAY_MIN)
        date = Run(["date", "-u", "-d", f"2026-01-01 + {day} days", "+%Y-%m-%d"]).out.strip()
        return [
            "--camera-space",
            "voxel",
            "--camera-inside-rock",
            "yes",
            f"--camera-position={','.join(map(str, self.position))}",
            f"--camera-target={','.join(map(str, self.target))}",
            f"--fov={self.fov_deg}",
            f"--sun-date={date}",
            f"--sun-time-h={minute / 60!r}",
            "--sun-utc-offset-h=0",
            f"--size={size[0]}x{size[1]}",
        ]


def three_views(archive):
    """Into a place from outside, over its middle, and from high above: many levels of detail."""
    told = Run([binary("RAYTRACER"), "world", "info", archive, "--json"]).done()
    bounds = json.loads(told.out)["bounds"]
    low, high = bounds["min"], bounds["max"]
    width = high[0] - low[0]

    def at(east, up, south, above=low[1]):
        """A place by shares of the width; heights are above the lowest voxel, or another."""
        return (low[0] + east * width, above + up * width, low[2] + south * width)

    return [
        View("outside", at(-0.3, 0.45, 1.2), at(0.45, 0.05, 0.5)),
        View("inside", at(0.45, 0.4, 0.55), at(0.8, 0.1, 0.2), fov_deg=60),
        View("above", at(0.5, 2.2, 0.8, high[1]), at(0.5, 0, 0.5), fov_deg=40),
    ]


def minutes_of_the_year(count):
    """Times that are spread over the year and its days, with the sun above the horizon."""
    out = []
    for i in range(count):
        day = round((i + 0.5) * 365 / count)
        tilt = math.radians(-23.44 * math.cos(2 * math.pi * (day + 10) / 365))
        latitude = math.radians(LATITUDE_DEG)
        high = math.sin(math.radians(SUN_AT_LEAST_DEG))
        low = (high - math.sin(latitude) * math.sin(tilt)) / (math.cos(latitude) * math.cos(tilt))
        half_day_h = math.degrees(math.acos(low)) / 15
        # From morning to evening in an order that has nothing to do with the season.
        share = 2 * ((i * 0.618) % 1) - 1
        out.append(day * DAY_MIN + round(60 * (SOLAR_NOON_H + share * half_day_h)))
    return out


def show(site, views, size, folder, light=()):
    """Shows views of a folder in a browser, as show_at() does."""
    host = StaticHost(site)
    try:
        show_at(host.url, views, size, folder, light)
    finally:
        host.stop()


def show_at(url, views, size, folder, light=(), trusts_all=False):
    """Shows views of a site in a browser.

    @param light names of views of which light is wanted
    @param trusts_all certificates of no known authority will do
    @throws NoBrowser; AssertionError with what the page says where it shows nothing
    """
    job = folder / "job.json"
    listed = [{"name": v.name, "link": v.link(), "light": v.name in light} for v in views]
    width, height = size
    facts = {"url": url, "width": width, "height": height, "folder": str(folder)}
    job.write_text(json.dumps({**facts, "views": listed, "trustsAll": trusts_all}))
    run = subprocess.run(
        [
            os.environ.get("TERRAVOX_NODE") or "node",
            ROOT / "tests" / "e2e" / "site_views.mjs",
            job,
        ],
        capture_output=True,
        text=True,
        timeout=6 * HANGS_S,
        check=False,
    )
    if run.returncode == 3:
        raise NoBrowser(run.stdout)
    assert run.returncode == 0, run.stdout + run.stderr


class Traced:
    """The ray tracer's picture of a view, with its layers. @param flags camera, sun and size"""

    def __init__(self, archive, flags, folder):
        picture = folder / "traced.exr"
        render(archive, *flags, *PLAIN, "-o", picture).done()
        raw = folder / "traced.values"
        told = Run([binary("VALUES"), picture, raw]).done()
        facts = json.loads(told.out)
        self.channels = [channel["name"] for channel in facts["channels"]]
        self.values = array.array("f", raw.read_bytes())
        raw.unlink()
        picture.unlink()
        self.origin = _numbers(facts["metadata"]["terravox:origin"])
        self.voxel_m = _numbers(facts["metadata"]["terravox:voxel_m"])[0]

    def channel(self, name):
        return self.values[self.channels.index(name) :: len(self.channels)]


def _numbers(value):
    """A number, or several, of a picture's metadata."""
    return [float(word) for word in (value.split() if isinstance(value, str) else value)]


def numbers_of(path, kind):
    return array.array(kind, pathlib.Path(path).read_bytes())


def compare_hits(hits, traced):
    """First hits. @return shares of pixels: solid; same voxel, face and level; same shadow"""
    depth, sun = traced.channel("Z"), traced.channel("sun.V")
    normals = [traced.channel(f"normal.{a}") for a in "XYZ"]
    points = [traced.channel(f"position.{a}") for a in "XYZ"]
    same = lit = solid = 0
    pixels = len(depth)
    for i in range(pixels):
        *voxel, bits = hits[4 * i : 4 * i + 4]
        is_hit = bits >> 13 & 1 == 1
        if not is_hit or math.isinf(depth[i]):
            same += is_hit != math.isinf(depth[i])
            continue
        solid += 1
        size = 1 << (bits >> 4 & 31)
        normal = [channel[i] for channel in normals]
        axis = max(range(3), key=lambda k, n=normal: abs(n[k]))
        face = 2 * axis + (normal[axis] > 0)
        inside = [
            math.floor(
                (
                    traced.origin[k]
                    + points[k][i] / traced.voxel_m
                    - (0.25 * size if k == axis else 0) * normal[k]
                )
                / size
            )
            for k in range(3)
        ]
        same += inside == voxel and face == bits & 7
        lit += (bits >> 14 & 1 == 1) == (sun[i] > 0.5)
    return solid / pixels, same / pixels, lit / solid


def compare_shadows(hits, traced):
    """@return shares of solid pixels: in the sun in the ray tracer's picture, same in both"""
    depth, sun = traced.channel("Z"), traced.channel("sun.V")
    solid = [i for i, z in enumerate(depth) if not math.isinf(z) and hits[4 * i + 3] >> 13 & 1]
    sunny = sum(sun[i] > 0.5 for i in solid)
    same = sum((hits[4 * i + 3] >> 14 & 1 == 1) == (sun[i] > 0.5) for i in solid)
    return sunny / len(solid), same / len(solid)


def rmse_of_light(light, traced):
    """Root of the mean square of what the light differs by, as a share of its mean."""
    square = total = 0
    for k, name in enumerate("RGB"):
        reference = traced.channel(name)
        total += sum(reference)
        square += sum((a - b) ** 2 for a, b in zip(light[k::4], reference, strict=True))
    count = 3 * len(reference)
    return math.sqrt(square / count) / (total / count)

#!/usr/bin/env python3
"""Projections, from the scene to the pixel, and invalid cameras, suns and sizes.

The invalid ones are refused in one line, with nothing left behind.
"""

import math
import shutil
import unittest

from pictures import Picture, camera_place, distance, transformed
from support import ROOT, Case, entries, render, square, temporary_folder

WIDE = ["--size", "160x90", "--samples", "1", "--quiet"]
# Above the shore of the lake: land and sky all around.
STANDING = ["--camera-position", "462480,101480,560", "--camera-target", "462400,101520,500"]
PROJECTIONS = {
    "perspective": [*STANDING, "--fov", "70"],
    "orthographic": STANDING,
    "isometric": [],
    "panorama": STANDING,
    "fisheye": [*STANDING, "--fov", "200"],
}

_pictures = {}


def picture(projection):
    if projection not in _pictures:
        file = temporary_folder() / "a.exr"
        run = render(
            square(),
            *WIDE,
            "--layers",
            "all",
            "--projection",
            projection,
            *PROJECTIONS[projection],
            "-o",
            file,
        )
        if run.code != 0:
            raise AssertionError(str(run))
        _pictures[projection] = Picture(file)
    return _pictures[projection]


def pixel_of(projection, picture, place):
    """@return the pixel that shows a point, metres from terravox:origin (docs/formats/scene.md)"""
    if projection in ("perspective", "orthographic", "isometric"):
        u, v, _ = transformed(picture.metadata["worldToNDC"], place)
        return u * picture.width, v * picture.height
    x, y, z = transformed(
        picture.metadata["worldToCamera"], place
    )  # x right, y up, looking down -z
    if projection == "panorama":
        turn = math.atan2(x, -z)
        height = math.atan2(y, math.hypot(x, z))
        return (
            turn / math.pi + 1
        ) * picture.width / 2, picture.height / 2 - height / math.pi * picture.width / 2
    angle = math.atan2(math.hypot(x, y), -z)
    shorter = min(picture.width, picture.height)
    radius = angle / math.radians(200 / 2) * shorter / 2
    return picture.width / 2 + radius * x / math.hypot(
        x, y
    ), picture.height / 2 - radius * y / math.hypot(x, y)


class Projections(Case):
    def test_each_pixel_shows_what_lies_there(self):
        for projection in PROJECTIONS:
            with self.subTest(projection):
                p = picture(projection)
                self.assertEqual(
                    "worldToNDC" in p.metadata, projection not in ("panorama", "fisheye")
                )
                eye = camera_place(p)
                seen = 0
                for i, (a, z, *place) in enumerate(
                    p.channels("A", "Z", "position.X", "position.Y", "position.Z")
                ):
                    if a == 0:
                        continue
                    seen += 1
                    x, y = pixel_of(projection, p, place)
                    self.assertTrue(
                        -0.02 <= x - i % p.width <= 1.02 and -0.02 <= y - i // p.width <= 1.02,
                        f"pixel {i} shows what lies at {x}, {y}",
                    )
                    depth = distance(place, eye)
                    if projection in ("orthographic", "isometric"):
                        depth = -transformed(p.metadata["worldToCamera"], place)[2]
                    self.assertAlmostEqual(z, depth, delta=2e-3, msg=f"depth of pixel {i}")
                self.assertGreater(seen, 1500)

    def test_all_differ(self):
        pictures = {picture(projection).channel("R").tobytes() for projection in PROJECTIONS}
        self.assertEqual(len(pictures), len(PROJECTIONS))

    def test_the_edges_of_a_panorama_fit_together(self):
        p = picture("panorama")
        places = p.channels("position.X", "position.Y", "position.Z")

        def step(left, right):
            """@return median distance of neighbours in two columns, relative to their depth"""
            both = [
                y
                for y in range(p.height)
                if p.channel("A")[y * p.width + left] and p.channel("A")[y * p.width + right]
            ]
            self.assertGreater(len(both), 20)
            steps = sorted(
                distance(places[y * p.width + left], places[y * p.width + right])
                / p.channel("Z")[y * p.width + left]
                for y in both
            )
            return steps[len(steps) // 2]

        inner = [step(x, x + 1) for x in range(10, p.width - 10, 20)]
        self.assertLess(step(p.width - 1, 0), 1.5 * max(inner))
        self.assertGreater(step(p.width // 2, 0), 5 * max(inner))

    def test_outside_of_a_fisheyes_circle_all_is_black(self):
        p = picture("fisheye")
        for i, values in enumerate(
            p.channels("R", "G", "B", "A", "albedo.G", "CryptoMaterial00.g")
        ):
            away = (
                math.hypot(i % p.width + 0.5 - p.width / 2, i // p.width + 0.5 - p.height / 2)
                - min(p.width, p.height) / 2
            )
            if away > 0.75:
                self.assertEqual(set(values), {0.0}, f"pixel {i}")
            elif away < -0.75:
                self.assertGreater(sum(values[:3]), 0, f"pixel {i}")

    def test_straight_down_and_straight_up_have_north_above(self):
        out = temporary_folder()
        for name, height in (("down", "400"), ("up", "1200")):
            self.assertDone(
                render(
                    square(),
                    *WIDE,
                    "--layers",
                    "all",
                    "--camera-position",
                    "462500,101500,900",
                    "--camera-target",
                    f"462500,101500,{height}",
                    "-o",
                    out / f"{name}.exr",
                )
            )
        down = Picture(out / "down.exr")
        up = Picture(out / "up.exr")
        self.assertGreater(sum(down.channel("A")), 3000)
        self.assertEqual(sum(up.channel("A")), 0)
        hits = [i for i, a in enumerate(down.channel("A")) if a]
        # z grows to the south, and so do rows.
        self.assertGreater(
            down.channel("position.Z")[hits[-1]], down.channel("position.Z")[hits[0]]
        )

    def test_a_view_of_another_place_is_warned_of(self):
        loud = [x for x in WIDE if x != "--quiet"]
        out = temporary_folder()
        far = ("--camera-position", "462620,101500,700", "--camera-target", "432620,101500,600")
        for flags, said in {
            (
                "--look",
                "Bled island",
            ): "the view 'Bled island' shows nothing of the world: it stands at 43",
            far: "the camera looks at what is far from the world",
        }.items():
            with self.subTest(said):
                run = render(square(), *loud, *flags, "-o", out / "a.png")
                self.assertDone(run)
                (warning,) = [line for line in run.err.splitlines() if line.startswith("[warning]")]
                self.assertIn(said, warning)
                self.assertIn("the world reaches from 462368, 1013", warning)
                self.assertIn("EPSG:3794", warning)
        run = render(square(), *loud, *STANDING, "-o", out / "a.png")
        self.assertDone(run)
        self.assertNotIn("[warning]", run.err)


_POINT = ["--camera-position", "462400,101400,700", "--camera-target"]
_ON_EARTH = ["--camera-space", "latlon", "--camera-target", "46,14,0"]
# Invalid cameras, suns and pictures: flags, and a part of the message.
REFUSED = {
    "a field of view of 0": (["--fov", "0"], "--fov = 0; allowed: 1 to 360"),
    "of 1000": (["--fov", "1000"], "--fov = 1000"),
    "of no number": (["--fov", "NaN"], "--fov = nan"),
    "of 175, perspective": (
        ["--fov", "175"],
        "camera.fov_deg = 175; allowed for a perspective: 1 to 170",
    ),
    "a fisheye of 361": (
        ["--projection", "fisheye", "--fov", "361"],
        "--fov = 361",
    ),
    "a panorama with a lens": (
        ["--projection", "panorama", "--camera-aperture-m", "1"],
        "camera.aperture_m = 1; allowed for a panorama: 0",
    ),
    "another projection": (
        ["--projection", "mercator"],
        "allowed: perspective, orthographic, isometric, panorama, fisheye",
    ),
    "a map of no height": (
        ["--projection", "orthographic", "--camera-height-m", "0"],
        "--camera-height-m = 0",
    ),
    "target where the camera is": ([*_POINT, "462400,101400,700"], "the same point"),
    "a place that is no number": (
        [*_POINT, "nan,1,2"],
        "--camera-target = (nan, 1, 2); allowed: three finite numbers",
    ),
    "a place beyond all maps": (
        [*_POINT, "1e300,1,2"],
        "camera.target = (1e+300, 1, 2) lies beyond 10^9 voxels",
    ),
    "a latitude of 91": (
        [*_ON_EARTH, "--camera-position", "91,14,900"],
        "latitude = 91; allowed: -90 to 90",
    ),
    "a longitude of 500": (
        [*_ON_EARTH, "--camera-position", "46,500,900"],
        "longitude = 500",
    ),
    "an unknown view": (["--look", "Bled iland"], "names no view; did you mean Bled island"),
    "a view in no file": (["--look", "./nothing.toml"], "nothing.toml"),
    "30 February": (
        ["--sun-date", "2026-02-30"],
        "sun.date = '2026-02-30' is no day of the calendar",
    ),
    "month 13": (
        ["--sun-date", "2026-13-01"],
        "sun.date = '2026-13-01' is no day of the calendar",
    ),
    "the year 99999": (["--sun-date", "99999-01-01"], "allowed: YYYY-MM-DD"),
    "25 o'clock": (["--sun-time-h", "25"], "--sun-time-h = 25; allowed: 0 to 24"),
    "no time": (["--sun-time-h", "nan"], "--sun-time-h = nan"),
    "no zone": (["--sun-zone", "Europe/Atlantis"], "'Europe/Atlantis' is not known"),
    "a zone that is a path": (["--sun-zone", "../../etc/passwd"], "is not known"),
    "UTC+15": (["--sun-utc-offset-h", "15"], "--sun-utc-offset-h = 15; allowed: -14 to 14"),
    "half a sun": (["--sun-altitude-deg", "20"], "sun.azimuth_deg is missing"),
    "two colours": (["--sky-colour", "1,1"], "--sky-colour = 2 numbers"),
    "a dark colour": (["--sky-colour=-1,1,1"], "--sky-colour = -1; allowed: 0 to"),
    "another curve": (["--tone", "sepia"], "allowed: photographic, filmic, agx, linear"),
    "noise below none": (["--noise", "-1"], "--noise = -1"),
    "time below none": (["--time", "-1"], "--time = -1"),
}


class Refused(Case):
    def test_cameras_suns_and_sizes(self):
        for name, (flags, said) in REFUSED.items():
            with self.subTest(name):
                out = temporary_folder()
                self.assertRefused(render(square(), *WIDE, *flags, "-o", out / "a.png"), 2, said)
                self.assertEqual(entries(out), [])

    def test_sizes(self):
        cases = {
            "0x0": (["-o", "a.exr"], "--size = 0; allowed: whole numbers from 1 to 65536"),
            "100000x100000": (
                ["-o", "a.exr"],
                "--size = 100000; allowed: whole numbers from 1 to 65536",
            ),
            "65536x65536": (
                ["-o", "a.png"],
                "65536x65536 pixels; allowed for .png: up to 715827882 in all; "
                ".exr and .tif hold more",
            ),
            "65536x8192": (
                ["-o", "a.png"],
                "need 14336 MiB, more than there is for a picture, and '.png' "
                "cannot be written in parts; allowed at this size: "
                ".exr .tif, or --memory-mib 28672 and more",
            ),
            "65501x600": (
                ["-o", "a.jpg"],
                "allowed for .jpg: sides up to 65500; .exr and .tif hold more",
            ),
            "8192x8192": (
                ["--time", "9", "-o", "a.exr"],
                "quality.time_s is set; allowed: 0, or --memory-mib 3584 and more",
            ),
            "8200x8192": (
                ["--tile", "7", "-o", "a.tif"],
                (
                    "tiles of 7 pixels; allowed for .tif at this size: multiples of 16, "
                    "or --memory-mib"
                ),
            ),
            "3840x2160": (
                ["--layers", "all", "-o", "a.exr", "-o", "a.png"],
                "allowed at this size: .exr .tif, or --memory-mib 3101 and more",
            ),
        }
        for size, (flags, said) in cases.items():
            with self.subTest(size):
                out = temporary_folder()
                self.assertRefused(
                    render(square(), "--quiet", "--size", size, *flags, cwd=out), 2, said
                )
                self.assertEqual(entries(out), [])

    def test_layers_that_no_file_takes_cost_nothing(self):
        # In memory they would need 16 MB, and a PNG cannot be streamed.
        out = temporary_folder()
        self.assertDone(
            render(
                square(),
                "--size",
                "320x256",
                "--samples",
                "1",
                "--quiet",
                "--layers",
                "all",
                "--memory-mib",
                "8",
                "-o",
                out / "all.png",
            )
        )
        self.assertDone(
            render(
                square(),
                "--size",
                "320x256",
                "--samples",
                "1",
                "--quiet",
                "--memory-mib",
                "8",
                "-o",
                out / "beauty.png",
            )
        )
        self.assertAlike(out / "all.png", out / "beauty.png", exact=True)

    def test_denoising_without_its_library(self):
        out = temporary_folder()
        empty = temporary_folder()
        run = render(
            square(),
            *WIDE,
            "--denoise",
            "yes",
            "-o",
            out / "a.png",
            environment={"TERRAVOX_OIDN": str(empty)},
        )
        self.assertRefused(
            run, 2, "denoise the picture: TERRAVOX_OIDN", "no libOpenImageDenoise.so there"
        )
        self.assertEqual(entries(out), [])

    def test_files_of_materials(self):
        config = temporary_folder() / "config"
        shutil.copytree(ROOT / "config", config)
        materials = config / "materials.toml"
        whole = materials.read_text()
        grass = next(line for line in whole.splitlines() if line.startswith("grass = "))
        for name, (text, said) in {
            "one too many": (whole + 'marble = { colour = "#ffffff" }\n', "marble"),
            "an unknown texture": (whole.replace('texture = "grass"', 'texture = "moss"'), "moss"),
            "an unknown field": (whole.replace(grass, grass.replace("colour", "color")), "color"),
            "no TOML": ("grass = {", "line"),
            "nothing": (None, "materials.toml"),
        }.items():
            with self.subTest(name):
                materials.unlink(missing_ok=True)
                if text is not None:
                    materials.write_text(text)
                out = temporary_folder()
                run = render(
                    square(),
                    *WIDE,
                    "-o",
                    out / "a.png",
                    environment={"TERRAVOX_CONFIG": str(config)},
                )
                self.assertRefused(run, run.code, "materials.toml", said)
                self.assertIn(run.code, (1, 2))
                self.assertEqual(entries(out), [])
        materials.write_text(whole.replace(grass, ""))
        run = render(
            square(),
            "--size",
            "160x90",
            "--samples",
            "1",
            "-o",
            out / "a.png",
            environment={"TERRAVOX_CONFIG": str(config)},
        )
        self.assertDone(run)
        (warning,) = [line for line in run.err.splitlines() if line.startswith("[warning]")]
        self.assertIn("grass", warning)


if __name__ == "__main__":
    unittest.main()

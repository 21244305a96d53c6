#!/usr/bin/env python3
"""Projections, from the scene to the pixel, and invalid cameras, suns and sizes.

The invalid ones are refused in one line, with nothing left behind.
"""

import math
import shutil
import unittest

from pictures import Picture, camera_place, distance, transformed
from support import ROOT, Case, entries, render, square, temporary_folder

WIDE = ["--plane", "none", "--size", "160x90", "--samples", "1", "--quiet"]
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
        flags = ["--layers", "all", "--projection", projection, *PROJECTIONS[projection]]
        render(square(), *WIDE, *flags, "-o", file).done()
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


# Of each kind one: tests/raytracer/core/scene and sky have all.
REFUSED = (
    (["--fov", "175"], "camera.fov_deg = 175; allowed for a perspective: 1 to 170"),
    (
        ["--camera-target", "nan,1,2"],
        "--camera-target = (nan, 1, 2); allowed: three finite numbers",
    ),
    (["--look", "Bled iland"], "names no view; did you mean Bled island"),
    (["--look", "./nothing.toml"], "nothing.toml"),
    (["--sun-altitude-deg", "20"], "sun.azimuth_deg is missing"),
    (["--sky-colour=-1,1,1"], "--sky-colour = -1; allowed: 0 to"),
)


class Refused(Case):
    def test_cameras_suns_and_sizes(self):
        for flags, said in REFUSED:
            with self.subTest(said):
                out = temporary_folder()
                self.assertRefused(render(square(), *WIDE, *flags, "-o", out / "a.png"), 2, said)
                self.assertEqual(entries(out), [])

    def test_sizes(self):
        cases = {
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
        words = ["--size", "320x256", "--samples", "1", "--quiet", "--memory-mib", "8"]
        for name, layers in (("all", ["--layers", "all"]), ("beauty", [])):
            self.assertDone(render(square(), *words, *layers, "-o", out / f"{name}.png"))
        self.assertAlike(out / "all.png", out / "beauty.png", exact=True)

    def test_files_of_materials(self):
        config = temporary_folder() / "config"
        shutil.copytree(ROOT / "config", config)
        materials = config / "materials.toml"
        whole = materials.read_text()
        grass = next(line for line in whole.splitlines() if line.startswith("grass = "))
        there = {"environment": {"TERRAVOX_CONFIG": str(config)}}
        out = temporary_folder()
        materials.write_text(whole.replace(grass, grass.replace("colour", "color")))
        run = render(square(), *WIDE, "-o", out / "a.png", **there)
        self.assertRefused(run, 2, "materials.toml", "color")
        self.assertEqual(entries(out), [])
        materials.write_text(whole.replace(grass, ""))
        words = ["--size", "160x90", "--samples", "1", "-o", out / "a.png"]
        run = render(square(), *words, **there)
        self.assertDone(run)
        (warning,) = [line for line in run.err.splitlines() if line.startswith("[warning]")]
        self.assertIn("grass", warning)


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
"""EXR files with all layers: the documented channels, and metadata.

The channels agree with each other, with the camera and with the beauty.
"""

import math
import unittest

from pictures import Picture, camera_place, distance, scene_of, transformed
from support import Case, render, survey, temporary_folder

SIZE = ["--size", "160x90", "--look", "plain", "--quiet", "--layers", "all"]
HALF = [f"{layer}.{c}" for layer in ("albedo", "direct", "indirect") for c in "RGB"]
HALF += ["normal.X", "normal.Y", "normal.Z", "material.ID", "sun.V", "water.V"]
FLOAT = ["R", "G", "B", "A", "Z", "position.X", "position.Y", "position.Z"]
FLOAT += [
    f"{kind}{layer}.{c}"
    for kind in ("CryptoMaterial", "CryptoSquare")
    for layer in ("00", "01", "02")
    for c in "rgba"
]
AIR = 0
WATER = 13

_pictures = {}


def picture(integrator, samples):
    """Of the whole place, and the sky above it; rendered once."""
    key = (integrator, samples)
    if key not in _pictures:
        file = temporary_folder() / "a.exr"
        how = ["--integrator", integrator, "--samples", str(samples)]
        render(survey(), "--ortho", survey() / "ortho", *SIZE, *how, "-o", file).done()
        _pictures[key] = Picture(file)
    return _pictures[key]


def of_each_picture(test):
    """A test of both integrators, of one with several samples."""

    def run(self):
        for how in (("direct", 1), ("path", 5)):
            with self.subTest(str(how)):
                test(self, picture(*how))

    return run


class Layers(Case):
    @of_each_picture
    def test_the_channels_are_those_of_the_document(self, p):
        self.assertEqual(p.types, {**dict.fromkeys(HALF, "half"), **dict.fromkeys(FLOAT, "float")})

    @of_each_picture
    def test_every_number_is_finite_but_the_depth_of_the_sky(self, p):
        hits = p.channel("A")
        self.assertTrue(
            any(a == 0 for a in hits) and any(a == 1 for a in hits),
            "a picture of sky and land is wanted",
        )
        for name in p.names:
            values = p.channel(name)
            if name == "Z":
                self.assertTrue(
                    all(
                        math.isinf(z) and z > 0 if a == 0 else math.isfinite(z) and z > 0
                        for z, a in zip(values, hits)
                    )
                )
            else:
                self.assertTrue(all(map(math.isfinite, values)), name)
        for name in ("A", "albedo.R", "albedo.G", "albedo.B", "sun.V", "water.V"):
            self.assertTrue(all(0 <= v <= 1.0005 for v in p.channel(name)), name)
        for name in ("R", "G", "B", *HALF[3:9]):
            self.assertGreaterEqual(min(p.channel(name)), 0, name)

    @of_each_picture
    def test_direct_and_indirect_light_make_the_beauty(self, p):
        for c in "RGB":
            for i, (whole, direct, indirect) in enumerate(
                p.channels(c, f"direct.{c}", f"indirect.{c}")
            ):
                # Two halves, each rounded to 11 bits.
                self.assertAlmostEqual(
                    whole,
                    direct + indirect,
                    delta=1e-5 + 1e-3 * abs(whole),
                    msg=f"{c} of pixel {i}",
                )
        self.assertGreater(sum(p.channel("indirect.G")), 0)

    def test_of_one_sample_position_depth_camera_and_normal_agree(self):
        p = picture("direct", 1)
        eye = camera_place(p)
        ndc = p.metadata["worldToNDC"]
        checked = 0
        for i, (a, z, *place) in enumerate(
            p.channels("A", "Z", "position.X", "position.Y", "position.Z")
        ):
            if a == 0:
                continue
            checked += 1
            self.assertAlmostEqual(distance(place, eye), z, delta=1e-3, msg=f"depth of pixel {i}")
            u, v, _ = transformed(ndc, place)
            x, y = u * p.width, v * p.height
            # The sample is anywhere in its pixel: single precision of some 500 m, in pixels of
            # 0.2 m and more.
            is_inside = -1e-2 <= x - i % p.width <= 1.01 and -1e-2 <= y - i // p.width <= 1.01
            self.assertTrue(is_inside, f"pixel {i} shows what lies at {x}, {y}")
        self.assertGreater(checked, 1000)
        for i, (a, *normal) in enumerate(p.channels("A", "normal.X", "normal.Y", "normal.Z")):
            self.assertAlmostEqual(math.hypot(*normal), a, delta=2e-3, msg=f"normal of pixel {i}")
        x, y, z = transformed(p.metadata["worldToCamera"], eye)
        self.assertLess(math.hypot(x, y, z), 1e-4)

    @of_each_picture
    def test_of_many_samples_normals_are_means(self, p):
        self.assertLessEqual(
            max(math.hypot(*n) for n in p.channels("normal.X", "normal.Y", "normal.Z")), 1.002
        )

    @of_each_picture
    def test_mattes_cover_what_is_hit_and_identify_it(self, p):
        covered = p.channel("A")
        for kind in ("CryptoMaterial", "CryptoSquare"):
            for i, (named, a) in enumerate(zip(p.mattes(kind), covered)):
                self.assertAlmostEqual(
                    sum(named.values()), a, delta=1e-5, msg=f"{kind} of pixel {i}: {named}"
                )
                self.assertEqual(
                    sorted(named.values(), reverse=True),
                    list(named.values()),
                    f"{kind}: ranks of pixel {i}",
                )

    def test_of_one_sample_the_number_of_the_material_is_its_matte(self):
        p = picture("direct", 1)
        materials = p.mattes("CryptoMaterial")
        squares = p.mattes("CryptoSquare")
        for i, (number, water) in enumerate(p.channels("material.ID", "water.V")):
            self.assertEqual(number, math.floor(number))
            self.assertEqual(number == AIR, not materials[i], f"pixel {i}")
            self.assertEqual(number == WATER, "water" in materials[i], f"pixel {i}")
            self.assertEqual(number == WATER, water == 1, f"pixel {i}")
        self.assertIn({"water": 1.0}, materials)
        self.assertEqual({name for named in squares for name in named}, {"462_101"})

    def test_the_metadata_describe_the_picture(self):
        p = picture("path", 5)
        said = p.metadata
        self.assertTrue(said["Software"].startswith("terravox "))
        self.assertEqual(said["terravox:crs"], "EPSG:3794")
        self.assertIn("Slovene National Grid", said["terravox:crs_wkt"])
        self.assertEqual(said["terravox:projection"], "perspective")
        self.assertEqual(int(said["terravox:holes"]), 0)
        self.assertEqual(int(said["terravox:samples"]), 5)
        self.assertAlmostEqual(math.hypot(*p.numbers("terravox:to_sun")), 1, delta=1e-5)
        self.assertGreater(
            p.numbers("terravox:to_sun")[1], 0.3, "the sun of a June afternoon stands high"
        )
        self.assertTrue(
            all(
                -1 < c - o < 2
                for c, o in zip(p.numbers("terravox:camera"), p.numbers("terravox:origin"))
            )
        )
        scene = scene_of(p)
        self.assertEqual(
            (scene["quality.integrator"], scene["output.layers"], scene["quality.samples"]),
            ("'path'", "'all'", "5"),
        )

    def test_layers_and_streaming_change_nothing_in_the_beauty(self):
        out = temporary_folder()
        flags = [survey(), "--size", "320x256", "--quiet", "--samples", "1"]
        self.assertDone(render(*flags, "-o", out / "plain.exr"))
        self.assertDone(render(*flags, "--layers", "all", "-o", out / "layers.exr"))
        # A film with layers takes 16 MB here: at 1 MiB it goes straight into the file.
        self.assertDone(
            render(*flags, "--layers", "all", "--memory-mib", "1", "-o", out / "streamed.exr")
        )
        plain, layers, streamed = (
            Picture(out / f"{name}.exr") for name in ("plain", "layers", "streamed")
        )
        self.assertEqual(plain.names, ["R", "G", "B", "A", "Z"])
        self.assertGreater(streamed.tile[0], 0, "it was not streamed")
        self.assertEqual(layers.tile[0], 0)
        self.assertEqual(layers.types, streamed.types)
        for name in plain.names:
            self.assertTrue(plain.channel(name) == layers.channel(name), name)
        for name in layers.names:
            self.assertTrue(
                layers.channel(name).tobytes() == streamed.channel(name).tobytes(), name
            )


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
"""Worlds of Python that are made of arrays of points and of voxels."""

import unittest

import numpy as np
import terravox

GROUND, BUILDING = 2, 6  # classes of ASPRS
GRASS, MASONRY = 4, 30
SIDE_M = 64
CRS = "EPSG:3794"
ORIGIN = (462000, 101000)
SMALL = {"output.size": "48x32", "quality.samples": 1}


def scan():
    """@return points and classes of a level field with a house, every half metre"""
    steps = np.arange(0.25, SIDE_M, 0.5)
    east, north = (axis.ravel() for axis in np.meshgrid(steps, steps))
    house = (east >= 20) & (east < 32) & (north >= 40) & (north < 48)
    height = np.where(house, 307.5, 300.5)
    points = np.stack([ORIGIN[0] + east, ORIGIN[1] + north, height], axis=1)
    return points, np.where(house, BUILDING, GROUND).astype(np.uint8)


def seen(solid):
    """@return of each voxel whether a neighbour is air, or beyond the edge"""
    around = np.pad(solid, 1)
    out = np.zeros_like(solid)
    for axis in range(3):
        for step in (-1, 1):
            out |= ~np.roll(around, step, axis)[1:-1, 1:-1, 1:-1]
    return out & solid


def hill():
    """@return materials of a hill of grass with a wall on it"""
    materials = np.zeros((70, 90, 130), np.uint8)
    rows, columns = np.mgrid[:90, :130]
    heights = (30 + 20 * np.sin(rows / 15) * np.cos(columns / 20)).astype(int)
    materials[np.arange(70)[:, None, None] < heights] = GRASS
    materials[40:60, 45, 20:100] = MASONRY
    return materials


class Points(unittest.TestCase):
    def test_they_become_voxels(self):
        points, classes = scan()
        world = terravox.from_points(points, crs=CRS, classification=classes)
        self.assertEqual(world.crs, CRS)
        surface = world.surface()
        self.assertEqual(surface.shape, (SIDE_M, SIDE_M))
        # Rows from the north: the house is 40 to 48 m from the southern edge.
        self.assertEqual(float(surface[SIDE_M - 44, 26]), 308)
        self.assertEqual(float(surface[SIDE_M - 30, 26]), 301)
        house = world.voxels()[:, SIDE_M - 44, 26]
        names = {terravox.MATERIALS[number].name for number in house}
        self.assertIn("flat_roof", names)

    def test_their_order_makes_no_difference(self):
        points, classes = scan()
        shuffled = np.random.default_rng(1).permutation(len(points))
        one = terravox.from_points(points, crs=CRS, classification=classes)
        other = terravox.from_points(points[shuffled], crs=CRS, classification=classes[shuffled])
        np.testing.assert_array_equal(one.voxels(), other.voxels())

    def test_any_layout_of_arrays_is_taken(self):
        points, classes = scan()
        expected = terravox.from_points(points, crs=CRS, classification=classes).voxels()
        for xyz, numbers in (
            (np.asfortranarray(points), classes.astype(np.int64)),
            (points[::-1][::-1], classes.tolist()),
        ):
            world = terravox.from_points(xyz, crs=CRS, classification=numbers)
            np.testing.assert_array_equal(world.voxels(), expected)

    def test_colours_are_those_of_the_points(self):
        points, classes = scan()
        pictures = []
        for red in (np.uint8(255), np.uint16(65535)):
            rgb = np.zeros((len(points), 3), red.dtype)
            rgb[:, 0] = red
            world = terravox.from_points(points, crs=CRS, classification=classes, rgb=rgb)
            fields = {**SMALL, "quality.colour": "true", "quality.textures": False}
            pictures.append(world.render(fields=fields).rgb)
        np.testing.assert_array_equal(*pictures)
        red, green, _ = pictures[0].reshape(-1, 3)[pictures[0][..., 0].argmax()]
        self.assertGreater(int(red), 2 * int(green))

    def test_what_does_not_fit_is_refused(self):
        points, classes = scan()
        for wrong, words in (
            ({"points": points[:, :2]}, "n x 3"),
            ({"points": points * np.nan}, "finite"),
            ({"points": points[:0], "classification": None}, "allowed: at least 1"),
            ({"classification": classes[1:]}, "one for each of"),
            ({"classification": classes * 1.5}, "whole numbers"),
            ({"classification": classes.astype(int) - 3}, "0 to 255"),
            ({"return_number": classes * 0}, "1 to 15"),
            ({"intensity": classes.astype(int) * 70000}, "0 to 65535"),
            ({"rgb": np.zeros((len(points), 3))}, "uint8, uint16"),
            ({"rgb": np.zeros((len(points), 4), np.uint8)}, "x 3"),
            ({"points": points + 0j}, "complex128; allowed: real numbers"),
            ({"points": np.ma.masked_equal(points, points[0, 0])}, "points with .* masked values"),
            ({"points": [np.ma.array(row, mask=[0, 0, 1]) for row in points[:3]]}, "3 masked"),
            ({"classification": np.ma.array(classes, mask=classes == BUILDING)}, "masked"),
            ({"crs": "EPSG:1"}, "EPSG:1"),
            ({"voxel_m": -1}, "-1"),
        ):
            given = {"points": points, "crs": CRS, "classification": classes, **wrong}
            with self.subTest(words), self.assertRaisesRegex(ValueError, words):
                terravox.from_points(**given)


class Voxels(unittest.TestCase):
    def test_they_come_back_as_they_were(self):
        materials = hill()
        for voxel_m in (1.0, 0.1):
            with self.subTest(voxel_m):
                west, south, bottom = 462000.0, -20.0 * voxel_m, 3 * voxel_m
                world = terravox.from_voxels(
                    materials, west=west, south=south, bottom=bottom, voxel_m=voxel_m, crs=CRS
                )
                east, north = west + 130 * voxel_m, south + 90 * voxel_m
                np.testing.assert_allclose(world.bounds, (west, south, east, north), rtol=1e-9)
                voxels = world.voxels()
                np.testing.assert_array_equal(voxels > 0, materials > 0)
                outside = seen(materials > 0)
                np.testing.assert_array_equal(voxels[outside], materials[outside])
                self.assertEqual(world.voxel_m, voxel_m)
                highest = materials.shape[0] - np.argmax(materials[::-1] > 0, axis=0)
                heights = (bottom + voxel_m * highest).astype(np.float32)
                np.testing.assert_allclose(world.surface().values, heights, rtol=1e-6)

    def test_changes_of_the_array_do_not_reach_the_world(self):
        materials = hill()
        world = terravox.from_voxels(materials)
        materials[:] = 0
        self.assertTrue((world.voxels() > 0).any())

    def test_colours_are_their_own(self):
        materials = hill()
        rgb = np.zeros((*materials.shape, 3), np.uint8)
        rgb[..., 2] = 250
        fields = {**SMALL, "quality.colour": "true", "quality.textures": False}
        blue = terravox.from_voxels(materials, rgb=rgb).render(fields=fields).rgb
        plain = terravox.from_voxels(materials).render(fields=fields).rgb
        self.assertGreater(int(blue[16, 24, 2]), 2 * int(blue[16, 24, 0]))
        self.assertFalse(np.array_equal(blue, plain))

    def test_what_does_not_fit_is_refused(self):
        materials = hill()
        for wrong, words in (
            ({"materials": materials[0]}, "layers x rows x columns"),
            ({"materials": np.broadcast_to(np.uint8(4), (1, 1, 2**32 + 1))}, "sides to"),
            ({"materials": materials * 1.0}, "whole numbers"),
            ({"materials": materials.astype(int) * 300}, "0 to 255"),
            ({"materials": materials * 0 + 250}, "material 250"),
            ({"materials": np.ma.masked_equal(materials, GRASS)}, "materials with .* masked"),
            ({"west": 0.5}, "multiples of voxel_m"),
            ({"bottom": float("nan")}, "bottom"),
            ({"south": 1e12}, "south"),
            ({"voxel_m": 0}, "voxel_m = 0"),
            ({"rgb": np.zeros((1, 2, 3), np.uint8)}, "rgb of shape"),
            ({"crs": "EPSG:4326"}, "degrees"),
            ({"crs": "EPSG:2225"}, "metres"),
        ):
            given = {"materials": materials, **wrong}
            with self.subTest(words), self.assertRaisesRegex(ValueError, words):
                terravox.from_voxels(**given)


if __name__ == "__main__":
    unittest.main()

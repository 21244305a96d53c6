#!/usr/bin/env python3
"""Maps: GeoTIFF files have a correct georeference, and show what is there."""

import contextlib
import json
import os
import pty
import select
import subprocess
import unittest

import pmtiles_archive
from pictures import Picture, Tags
from support import (
    FARM_TOKEN,
    HANGS_S,
    Case,
    Program,
    Run,
    binary,
    entries,
    only_in_all,
    render,
    square,
    survey,
    temporary_folder,
    wait_until,
)

# Of the synthetic square.
WEST = 462368
SOUTH = 101360
EAST = 462624
NORTH = 101616
MIDDLE = f"{(WEST + EAST) // 2},{(SOUTH + NORTH) // 2},500"
QUIET = ["--quiet", "--samples", "1"]
MAP = ["--projection", "orthographic", "--camera-down-deg", "90", "--camera-target", MIDDLE]
PROJECTED_CRS = 3072  # GeoKey
# Materials.
WATER = 13
HIGH_VEGETATION = 7
# Kinds in the truth of the survey.
KIND_WATER = 5
KIND_TREE = 6


def draw_map(*arguments):
    return Run([binary("RAYTRACER"), "map", *arguments, "--samples", "1"])


def at(transform, px, py):
    """Easting and northing of picture coordinates."""
    g = transform
    return g[0] + px * g[1] + py * g[2], g[3] + px * g[4] + py * g[5]


class Maps(Case):
    def positions_lie_where_the_tags_say(self, tif, exr):
        """Checks that the first hit of each pixel is in the pixel's square of the map."""
        transform = Tags(tif).transform()
        p = Picture(exr)
        origin = p.numbers("terravox:origin")
        area = abs(transform[1] * transform[5] - transform[2] * transform[4])
        hits = 0
        for i, (a, x, z) in enumerate(p.channels("A", "position.X", "position.Z")):
            if a == 0:
                continue
            hits += 1
            easting = origin[0] + x - transform[0]
            northing = -(origin[2] + z) - transform[3]
            px = (easting * transform[5] - northing * transform[2]) / (
                transform[1] * transform[5] - transform[2] * transform[4]
            )
            py = (northing * transform[1] - easting * transform[4]) / (
                transform[1] * transform[5] - transform[2] * transform[4]
            )
            self.assertTrue(
                -0.01 <= px - i % p.width <= 1.01 and -0.01 <= py - i // p.width <= 1.01,
                f"pixel {i} shows what lies at {px}, {py}",
            )
        self.assertGreater(hits, 5000)
        return transform, area

    def test_a_geotiff_is_georeferenced(self):
        out = temporary_folder()
        for name, more in {"north up": [], "turned": ["--camera-roll-deg", "30"]}.items():
            with self.subTest(name):
                tif = out / f"{name}.tif"
                exr = out / f"{name}.exr"
                # 256 m in 128 pixels: two metres each.
                view = ["--size", "192x128", "--camera-height-m", "256", *more]
                flags = [square(), *QUIET, *MAP, *view]
                self.assertDone(render(*flags, "-o", tif))
                self.assertDone(render(*flags, "--layers", "all", "-o", exr))
                self.assertEqual(Tags(tif).geo_keys()[PROJECTED_CRS], 3794)
                self.assertEqual(Tags(tif).big, False)
                transform, area = self.positions_lie_where_the_tags_say(tif, exr)
                self.assertAlmostEqual(area, 4, delta=1e-6)
                if name != "turned":
                    self.assertEqual(transform, [WEST - 64, 2, 0, NORTH, 0, -2])
                p = Picture(tif)
                self.assertEqual(p.names, ["R", "G", "B", "A"])
                self.assertEqual(set(p.types.values()), {"uint8"})
                # Outside the square there is nothing; in its middle the survey.
                alpha = p.channel("A")
                self.assertEqual(alpha[64 * 192 + 96], 1)
                if name != "turned":
                    self.assertEqual((alpha[64 * 192 + 20], alpha[64 * 192 + 180]), (0, 0))

    def test_the_map_shows_the_truth(self):
        out = temporary_folder()
        view = ["--size", "256x256", "--camera-height-m", "256", "--detail", "0"]
        flags = [*QUIET, *MAP, *view, "--layers", "all"]
        self.assertDone(render(survey(), *flags, "-o", out / "a.exr"))
        seen = Picture(out / "a.exr").channel("material.ID")
        truth = Picture(next((survey() / "truth").glob("kind_*.tif")))
        self.assertEqual((truth.width, truth.height), (256, 256))
        kinds = [round(v * 255) for v in truth.values]

        def agreement(material, kind, shift):
            """The pixels that both pictures call so, as a share of those that either does."""
            a = {i for i, m in enumerate(seen) if m == material}
            b = {i + shift for i, k in enumerate(kinds) if k == kind}
            self.assertGreater(len(a), 300)
            return len(a & b) / len(a | b)

        for material, kind, least in ((WATER, KIND_WATER, 0.9), (HIGH_VEGETATION, KIND_TREE, 0.3)):
            here = agreement(material, kind, 0)
            self.assertGreater(here, least, f"material {material}")
            for name, shift in {"east": 3, "west": -3, "south": 3 * 256, "north": -3 * 256}.items():
                self.assertLess(
                    agreement(material, kind, shift), here, f"material {material}, moved 3 m {name}"
                )


class WholeMaps(Case):
    def test_a_map_covers_the_data_cell_by_cell(self):
        out = temporary_folder()
        tif = out / "map.tif"
        self.assertDone(draw_map(square(), "--resolution", "2", "-o", tif, "--quiet"))
        self.assertEqual(entries(out), ["map.tif"])
        transform = Tags(tif).transform()
        # Cells begin at whole multiples of their edge.
        self.assertEqual(transform[1:3] + transform[4:], [2, 0, 0, -2])
        self.assertEqual((transform[0] % 2, transform[3] % 2), (0, 0))
        self.assertTrue(WEST - 8 <= transform[0] <= WEST)
        self.assertTrue(NORTH <= transform[3] <= NORTH + 8)
        self.assertEqual(Tags(tif).geo_keys()[PROJECTED_CRS], 3794)
        map_of_all = Picture(tif)
        self.assertEqual(map_of_all.names, ["R", "G", "B", "A"])
        column = int((WEST + 128 - transform[0]) / 2)
        row = int((transform[3] - NORTH + 128) / 2)
        self.assertEqual(map_of_all.channel("A")[row * map_of_all.width + column], 1)
        # A part of it has the same cells. Noise and dither depend on the place in the picture.
        west, south = WEST + 64, SOUTH + 64
        part = out / "part.tif"
        area = f"{west},{south},{west + 64},{south + 32}"
        flags = ["--area", area, "--resolution", "2", "--quiet"]
        self.assertDone(draw_map(square(), *flags, "-o", part))
        piece = Picture(part)
        self.assertEqual((piece.width, piece.height), (32, 16))
        left = round((west - transform[0]) / 2)
        top = round((transform[3] - south - 32) / 2)
        green = map_of_all.channel("G")
        same = 0
        for y, x in ((y, x) for y in range(16) for x in range(32)):
            here = green[(top + y) * map_of_all.width + left + x]
            same += abs(here - piece.channel("G")[y * 32 + x]) < 0.1
        self.assertGreater(same, 0.9 * 16 * 32)

    @only_in_all
    def test_an_interrupted_map_goes_on(self):
        out = temporary_folder()
        words = [binary("RAYTRACER"), "map", square(), "--samples", "64", "--resume"]
        words += ["--tile", "32", "--quiet", "-o"]
        file, kept = out / "map.pmtiles", out / "map.pmtiles.tiles"
        run = subprocess.Popen([*words, file], stderr=subprocess.PIPE, text=True)
        wait_until(lambda: kept.exists() and kept.stat().st_size > 20_000, "finished tiles")
        run.terminate()
        said = run.communicate(timeout=HANGS_S)[1]
        self.assertEqual(run.returncode, 1, said)
        self.assertIn("interrupted", said)
        self.assertEqual(entries(out), ["map.pmtiles.tiles"])
        self.assertDone(Run([*words, file]))
        self.assertEqual(entries(out), ["map.pmtiles"])
        self.assertDone(Run([*words, out / "whole.pmtiles"]))
        self.assertEqual(file.read_bytes(), (out / "whole.pmtiles").read_bytes())
        self.assertEqual(pmtiles_archive.Archive(file).kind, 4)

    @only_in_all
    def test_a_terminal_shows_how_many_tiles_are_cut(self):
        out = temporary_folder()
        ours, theirs = pty.openpty()
        words = ["--resolution", "0.125", "--threads", "1", "--samples", "1"]
        words += ["--tiles", "png", "-o", out / "map.pmtiles"]
        with subprocess.Popen(
            [binary("RAYTRACER"), "map", square(), *map(str, words)],
            stdout=subprocess.DEVNULL,
            stderr=theirs,
        ) as run:
            os.close(theirs)
            said = b""
            with contextlib.suppress(OSError):  # EIO at the end
                while select.select([ours], [], [], HANGS_S)[0] and (more := os.read(ours, 4096)):
                    said += more
            try:
                run.wait(HANGS_S)
            finally:
                run.kill()
            os.close(ours)
        self.assertEqual(run.returncode, 0, said)
        # Of pictures it says how many rays a second are traced, too.
        self.assertRegex(said, rb"tile \d+ of \d+  [0-9.]+ Mray/s")
        self.assertRegex(said, rb"100 %  tile (\d+) of \1  0 s left")

    @only_in_all
    def test_workers_draw_the_same_map(self):
        out = temporary_folder()
        secret = {"TERRAVOX_FARM_TOKEN": FARM_TOKEN}
        flags = ["--listen", "127.0.0.1:0", "--threads", "1"]
        address = Program("worker", *flags, environment=secret, test=self).address()
        words = [square(), "--resolution", "1", "--tiles", "png", "--tile", "32"]
        self.assertDone(draw_map(*words, "--quiet", "-o", out / "alone.pmtiles"))
        report = out / "report.json"
        words += ["--worker", address, "--threads", "0", "--report", report]
        far = [binary("RAYTRACER"), "map", *words, "--samples", "1", "-o", out / "far.pmtiles"]
        self.assertDone(Run(far, environment=secret))
        self.assertEqual((out / "alone.pmtiles").read_bytes(), (out / "far.pmtiles").read_bytes())
        self.assertEqual(entries(out), ["alone.pmtiles", "far.pmtiles", "report.json"])
        drawn = json.loads(report.read_text(encoding="utf-8"))["farm"]["processors"][0]
        self.assertEqual(drawn["kind"], "socket")
        self.assertGreater(drawn["pixels"], 60_000)

    @only_in_all
    def test_a_map_with_holes_is_made_and_counted(self):
        """Of an archive that is damaged: what can be drawn is, and the exit code is 3."""
        out = temporary_folder()
        archive = out / "place.tvx"
        words = [binary("CONVERT"), square(), archive, "--quiet", "--cache", "none"]
        self.assertDone(Run(words))
        data = bytearray(archive.read_bytes())
        middle = len(data) // 2
        data[middle : middle + 20_000] = bytes(20_000)
        archive.write_bytes(data)
        file = out / "map.pmtiles"
        flags = ["--resolution", "1", "--detail", "0", "--tiles", "png", "--quiet", "-o", file]
        run = draw_map(archive, *flags)
        self.assertEqual(run.code, 3, str(run))
        tiles = pmtiles_archive.Archive(file)
        self.assertGreater(tiles.metadata["holes"], 0)
        self.assertGreater(len(tiles.tiles), 3)
        self.assertEqual(entries(out), ["map.pmtiles", "place.tvx"])

    def test_what_cannot_be_a_map_is_refused(self):
        out = temporary_folder()
        analysis = temporary_folder() / "sky.toml"
        analysis.write_text('[analysis]\nkind = "sky"\n')
        for flags, said in (
            (["-o", out / "map.png"], ["'.png'", ".tif .tiff .pmtiles"]),
            (["-o", out / "map.tif", "--time", "3"], ["--time", "allowed: 0"]),
            (["-o", out / "map.tif", "--tile", "10"], ["--tile 10", "multiples of 16"]),
            (["-o", out / "map.tif", "--resolution", "0.01"], ["0.01 m", "allowed: 0.0625"]),
            (["-o", out / "map.pmtiles", "--tiles", "gif"], ["--tiles", "gif"]),
            (["-o", out / "map.tif", "--tiles", "png"], ["--tiles png", "-o FILE.pmtiles"]),
            (["-o", out / "map.tif", "--zooms", "3-4"], ["--zooms 3-4", "-o FILE.pmtiles"]),
            (["-o", out / "map.pmtiles", "--zooms", "9-8"], ["--zooms 9-8", "allowed"]),
            (["-o", out / "map.pmtiles", "--tiles-px", "300"], ["--tiles-px", "300"]),
            (["-o", out / "map.tif", "--tile", "4096"], ["--tile 4096", "up to 512"]),
            (["-o", out / "map.tif", "--scene", analysis], ["analysis"]),
        ):
            with self.subTest(flags[1:]):
                run = draw_map(square(), "--quiet", *flags)
                self.assertRefused(run, 2, *said)
        run = draw_map("generated:1", "--area", "0,0,64,64", "--quiet", "-o", out / "map.pmtiles")
        self.assertRefused(run, 2, "no place on Earth", ".tif")
        self.assertEqual(entries(out), [])


if __name__ == "__main__":
    unittest.main()

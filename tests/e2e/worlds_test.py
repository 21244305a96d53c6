#!/usr/bin/env python3
"""Worlds of every kind: described, rendered, converted, and read back."""

import json
import pathlib
import re
import shutil
import signal
import struct
import subprocess
import time
import unittest
import zipfile

from static_host import StaticHost
from support import (
    Case,
    Run,
    binary,
    compare,
    entries,
    only_in_all,
    render,
    square,
    survey,
    temporary_folder,
)

SMALL = ["--size", "160x90", "--samples", "1", "--quiet"]
PLAIN = [*SMALL, "--colour", "material"]


def convert(*arguments, **options):
    return Run([binary("RAYTRACER"), "convert", *arguments, "--quiet"], **options)


def info(*arguments, **options):
    return Run([binary("RAYTRACER"), "world", "info", *arguments], **options)


def changing_host(data, after):
    """A host of an archive that another entity tag replaces after so many requests."""

    def change(host):
        host.etag = '"two"' if host.requests >= host.after else '"one"'

    host = StaticHost({"place.tvx": data}, is_bare=True, before=change)
    host.after = after
    return host


class Worlds(Case):
    @classmethod
    def setUpClass(cls):
        cls.whole = temporary_folder() / "place.tvx"
        run = convert(survey(), "--ortho", survey() / "ortho", cls.whole)
        assert run.code == 0, run

    def setUp(self):
        self.out = temporary_folder()

    def done(self, run, code=0):
        self.assertEqual(run.code, code, str(run))
        return run

    def picture(self, name, *arguments, code=0):
        file = self.out / name
        self.done(render(*arguments, "-o", file), code)
        return file

    def same(self, a, b):
        run = compare(a, b, exact=True)
        self.assertEqual(run.code, 0, f"{a.name} and {b.name}: {run}")

    def archive(self):
        """A copy of the archive of survey() that one conversion has made for all tests."""
        return pathlib.Path(shutil.copy(self.whole, self.out))

    def test_an_archive_gives_the_picture_of_its_world(self):
        self.assertEqual(entries(self.whole.parent), ["place.tvx"])
        archive = self.archive()
        flags = [*SMALL, "--detail", "4"]
        self.same(
            self.picture("files.png", survey(), "--ortho", survey() / "ortho", *flags),
            self.picture("archive.png", archive, *flags),
        )
        facts = json.loads(self.done(info(archive, "--json")).out)
        self.assertEqual(facts["crs"], "EPSG:3794")
        self.assertGreater(facts["levels"], 2)

    def test_a_web_server_serves_an_archive_by_parts(self):
        data = self.archive().read_bytes()
        server = StaticHost({"place.tvx": data}, is_bare=True)
        there = server.url + "place.tvx"
        flags = [*SMALL, "--detail", "8"]
        self.same(
            self.picture("here.png", self.out / "place.tvx", *flags),
            self.picture("there.png", there, *flags),
        )
        self.assertLess(server.sent, 1.2 * len(data) + 20000)

    @only_in_all
    def test_an_archive_that_changes_while_it_is_read_ends_what_is_made_of_it(self):
        data = self.archive().read_bytes()
        reading = changing_host(data, after=1 << 30)
        self.picture("whole.png", reading.url + "place.tvx", *SMALL, "--detail", "8")
        self.assertGreater(reading.requests, 3)
        (self.out / "whole.png").unlink()
        for after in (1, 3):
            for name in ("place.png", "copy.tvx", "copy.vox", "town"):
                with self.subTest(f"{name} after {after}"):
                    server = changing_host(data, after)
                    there = server.url + "place.tvx"
                    if name.endswith(".png"):
                        run = render(there, *SMALL, "--detail", "8", "-o", self.out / name)
                    else:
                        run = convert(there, self.out / name)
                    self.assertRefused(
                        run, 1, f"{there} has changed while it was read; start again"
                    )
                    self.assertEqual(run.err.count("changed"), 1, str(run))
                    self.assertNotIn("hole", run.err)
                    self.assertFalse((self.out / name).is_file())

    @only_in_all
    def test_a_conversion_does_not_go_on_with_another_state_of_an_archive(self):
        area = ["--area", "-256,-256,256,256"]
        self.done(convert("generated:3", self.out / "noise.tvx", *area))
        data = (self.out / "noise.tvx").read_bytes()
        server = changing_host(data, after=1 << 30)
        there = server.url + "place.tvx"
        never = 1 << 30
        self.done(convert(there, self.out / "whole.tvx", "--threads", "1"))
        most = server.requests
        for goes_on in (True, False):
            with self.subTest(goes_on=goes_on):
                copy = self.out / f"copy-{goes_on}.tvx"
                server.requests = 0
                server.after = most - 2
                self.assertRefused(convert(there, copy, "--threads", "1"), 1, "has changed")
                self.assertIn(";", (self.out / f"{copy.name}.journal").read_text())
                server.requests = 0
                server.after = never if goes_on else 0
                run = self.done(
                    Run([binary("RAYTRACER"), "convert", there, copy, "--threads", "1"])
                )
                self.assertEqual("going on" in run.out + run.err, goes_on, str(run))
                self.assertTrue(
                    copy.read_bytes() == (self.out / "whole.tvx").read_bytes(), "not the same bytes"
                )

    def test_a_minecraft_world_of_a_place_is_that_place(self):
        world = self.out / "my town"
        self.done(convert(survey(), "--ortho", survey() / "ortho", world))
        for part in ("level.dat", "terravox.json", "region"):
            self.assertTrue((world / part).exists(), part)
        facts = self.done(info(world)).out
        self.assertIn("Anvil", facts)
        flags = [
            *PLAIN,
            "--detail",
            "0",
            "--camera-position",
            "462340,101330,640",
            "--camera-target",
            "462500,101490,480",
        ]  # each frames its own bounds
        place = self.picture("place.png", survey(), "--ortho", survey() / "ortho", *flags)
        self.same(place, self.picture("blocks.png", world, *flags))
        # The same from a ZIP, some folders deep.
        zipped = self.out / "zipped.zip"
        with zipfile.ZipFile(zipped, "w", zipfile.ZIP_DEFLATED) as z:
            for file in world.rglob("*"):
                z.write(file, pathlib.Path("saves/mine") / file.relative_to(world))
        self.same(place, self.picture("zipped.png", zipped, *flags))

    def test_other_formats_are_written_with_their_side_cars(self):
        for name in ("place.vox", "place.vdb", "place.glb", "place.ply"):
            with self.subTest(name):
                self.done(convert(survey(), self.out / name, "--level", "1"))
                self.assertGreater((self.out / name).stat().st_size, 10_000)
                cars = [f for f in entries(self.out) if f.endswith(".georef.json")]
                self.assertTrue(cars)
                car = json.loads((self.out / cars[0]).read_text())
                self.assertEqual(car["crs"], "EPSG:3794")
                self.assertEqual(car["voxel_m"], 2)
                self.assertFalse(
                    [f for f in entries(self.out) if f.endswith((".journal", ".part"))]
                )
                if name.endswith(".vdb") and shutil.which("vdb_print"):  # another maker's reader
                    printed = Run(["vdb_print", "-l", self.out / name])
                    self.assertEqual(printed.code, 0, str(printed))
                    for grid in ("density", "material", "Cd"):
                        self.assertIn(grid, printed.out)
                for f in entries(self.out):
                    (self.out / f).unlink()

    def test_some_commands_are_programs_beside_the_tracer(self):
        listed = Run([binary("RAYTRACER"), "--help"])
        alone = temporary_folder() / "terravox-raytracer"
        shutil.copy(binary("RAYTRACER"), alone)
        for name, begins in (
            ("convert", "Convert a world"),
            ("publish", "Make a web site"),
            ("view", "Show a site"),
        ):
            with self.subTest(name):
                itself = Run([binary(name.upper()), "--help"])
                self.assertEqual(itself.code, 0, str(itself))
                self.assertEqual(Run([binary("RAYTRACER"), name, "--help"]).out, itself.out)
                self.assertRegex(listed.out, rf"\n +{name} +{begins}")
                self.assertRefused(
                    Run([alone, name, "generated:1", self.out / "alone"]),
                    1,
                    str(alone.with_name(f"terravox-{name}")),
                )

    def test_a_generated_world_needs_nothing(self):
        flags = ["--size", "80x45", "--samples", "1", "--quiet"]
        a = self.picture("a.png", "generated:7", *flags)
        b = self.out / "b.png"
        scarce = [*flags[:-1], "--verbose", "--threads", "1", "--memory-mib", "2"]
        run = self.done(render("generated:7", *scarce, "-o", b))
        again = re.findall(r"(\d+) of them loaded again", run.out)
        self.assertGreater(sum(int(boxes) for boxes in again), 0, str(run))
        self.same(a, b)
        self.assertNotEqual(compare(a, self.picture("c.png", "generated:8", *flags)).code, 0)
        self.done(convert("generated:7", self.out / "noise.tvx", "--area", "-128,-128,128,128"))
        self.assertIn("a box archive", self.done(info(self.out / "noise.tvx")).out)

    @only_in_all
    def test_a_conversion_that_was_killed_goes_on(self):
        arguments = [
            binary("RAYTRACER"),
            "convert",
            "generated:3",
            "--area",
            "-512,-512,512,512",
            "--quiet",
            "--threads",
            "1",
        ]
        whole = self.out / "whole.tvx"
        killed = self.out / "killed.tvx"
        self.done(Run([*arguments, whole]))
        process = subprocess.Popen([*arguments, killed])
        journal = self.out / "killed.tvx.journal"
        while not (journal.exists() and journal.read_text().count(";") >= 2):
            self.assertIsNone(process.poll(), "it ended before it could be killed")
            time.sleep(0.01)
        process.send_signal(signal.SIGKILL)
        process.wait()
        done = journal.read_text().count(";")
        self.assertFalse(killed.exists())
        run = self.done(
            Run(
                [
                    binary("RAYTRACER"),
                    "convert",
                    "generated:3",
                    "--area",
                    "-512,-512,512,512",
                    "--threads",
                    "1",
                    killed,
                ]
            )
        )
        self.assertIn("going on", run.out + run.err)
        self.assertGreaterEqual(done, 2)
        self.assertTrue(whole.read_bytes() == killed.read_bytes(), "not the same bytes")
        self.assertEqual(entries(self.out), ["killed.tvx", "whole.tvx"])

    @only_in_all
    def test_a_minecraft_world_that_was_killed_goes_on(self):
        arguments = [
            binary("RAYTRACER"),
            "convert",
            "generated:3",
            "--area",
            "-600,-600,600,600",
            "--quiet",
            "--threads",
            "1",
        ]
        world = self.out / "town"
        empty = self.out / "empty"
        process = subprocess.Popen([*arguments, world])
        journal = world / "conversion.journal"
        while not (journal.exists() and journal.read_text().count(";") >= 2):
            self.assertIsNone(process.poll(), "it ended before it could be killed")
            time.sleep(0.01)
        process.send_signal(signal.SIGKILL)
        process.wait()
        self.assertFalse((world / "level.dat").exists())
        first = (world / "region" / journal.read_text().split()[-2]).stat().st_mtime_ns
        self.done(
            Run([*arguments[:-2], f"{world}/"])
        )  # another number of threads is the same conversion
        self.assertTrue((world / "level.dat").exists())
        self.assertFalse(journal.exists())
        self.assertIn(
            first,
            [f.stat().st_mtime_ns for f in (world / "region").iterdir()],
            "what was whole was written again",
        )
        self.assertRefused(
            convert("generated:3", world, "--area", "-64,-64,64,64"), 2, "holds a world"
        )
        empty.mkdir()
        self.done(convert("generated:3", empty, "--area", "-64,-64,64,64"))

    @only_in_all
    def test_a_divided_volume_is_not_overwritten_by_default_nor_mixed(self):
        volume = self.out / "place.vdb"
        self.done(convert(survey(), volume, "--write-memory-mib", "64"))
        parts = [f for f in entries(self.out) if f.endswith(".vdb")]
        self.assertGreater(len(parts), 1)
        self.assertRefused(convert(survey(), volume), 2, "_0.vdb", "--overwrite")
        self.assertRefused(convert(self.out / "none", volume, "--overwrite"), 2, "does not exist")
        self.assertEqual([f for f in entries(self.out) if f.endswith(".vdb")], parts)
        self.done(convert(survey(), volume, "--overwrite"))
        self.assertEqual(entries(self.out), ["place.vdb", "place.vdb.georef.json"])

    @only_in_all
    def test_a_full_disk_leaves_nothing(self):
        for name in ("full.tvx", "full.vox", "full.vdb", "full.glb", "full.ply", "full"):
            with self.subTest(name):
                run = convert(survey(), self.out / name, file_bytes=60_000)
                self.assertEqual(run.code, 1, str(run))
                self.assertIn("full", run.err)
                self.assertFalse((self.out / name).is_file())
                self.assertFalse((self.out / name / "level.dat").exists())

    def test_a_part_is_that_part_in_every_format(self):
        # A flag before the output, signed numbers, and a cut through rock: the same voxels in every
        # format.
        part = ["--area", "462400,101400,462500,101500", "--heights", "0,480"]
        archive = self.out / "part.tvx"
        world = self.out / "part"
        again = self.out / "again.tvx"
        counts = []
        for out in (archive, world):
            run = self.done(Run([binary("RAYTRACER"), "convert", survey(), *part, out]))
            counts.append(re.search(r"^(\d+) voxels", run.out, re.M).group(1))
        self.done(convert(world, again))
        self.assertEqual(counts[0], counts[1])
        run = self.done(Run([binary("RAYTRACER"), "convert", again, self.out / "third.tvx"]))
        self.assertEqual(re.search(r"^(\d+) voxels", run.out, re.M).group(1), counts[0])
        bounds = json.loads(self.done(info(archive, "--json")).out)["bounds"]
        self.assertEqual(
            [bounds["min"][0], bounds["max"][0], bounds["max"][1]], [462400, 462500, 480]
        )

    def test_a_damaged_archive_is_reported(self):
        data = bytearray(self.archive().read_bytes())
        at = struct.unpack_from("<QQ", data, 16)  # of the facts: the records begin behind them
        at = sum(at)
        while struct.unpack_from("<i", data, at)[0] != 0:  # coarse boxes come first
            at += 32 + struct.unpack_from("<I", data, at + 16)[0]
        data[at + 32 + 40] ^= 255  # in the frame of a box of level 0
        (self.out / "bad.tvx").write_bytes(data)
        run = render(self.out / "bad.tvx", *SMALL, "--detail", "0", "-o", self.out / "bad.png")
        self.assertEqual(run.code, 3, str(run))
        self.assertIn("bad.tvx", run.err)
        self.assertTrue((self.out / "bad.png").exists())

    def wrong_conversions(self):
        """@return {name: (exit code, arguments, parts of the message)}"""
        return {
            "a file that is nothing": (2, ["text.txt", "a.tvx"], ["text.txt", "box archive"]),
            "an empty folder": (2, ["empty", "a.tvx"], ["empty", "allowed:"]),
            "a missing path": (2, ["none", "a.tvx"], ["none", "does not exist"]),
            "a seed of letters": (2, ["generated:abc", "a.tvx"], ["'abc'", "allowed: 0 to"]),
            "two worlds": (2, ["generated:1", "generated:2", "a.tvx"], ["2 inputs"]),
            "two kinds": (2, ["generated:1", square(), "a.tvx"], ["inputs of one kind"]),
            "an unknown ending": (2, ["generated:1", "a.obj"], [".obj", "allowed:"]),
            "an unknown format": (2, ["generated:1", "a.tvx", "--to", "fbx"], ["fbx", "allowed:"]),
            "no output": (2, ["generated:1"], ["what to write"]),
            "what is there already": (2, ["generated:1", "there.tvx"], ["--overwrite"]),
            "a level beyond": (
                2,
                [square(), "a.tvx", "--level", "20"],
                ["level 20", "allowed: 0 to"],
            ),
            "an area of letters": (
                2,
                [square(), "a.tvx", "--area", "a,b,c,d"],
                ["--area a,b,c,d", "allowed:"],
            ),
            "an area that is no number": (
                2,
                [square(), "a.tvx", "--area", "nan,0,10,10"],
                ["--area nan", "allowed:"],
            ),
            "an area of three": (
                2,
                [square(), "a.tvx", "--area", "0,0,10"],
                ["--area 0,0,10", "allowed:"],
            ),
            "heights upside down": (
                2,
                [square(), "a.tvx", "--heights", "500,400"],
                ["--heights 500", "allowed:"],
            ),
            "an area elsewhere": (
                2,
                [square(), "a.tvx", "--area", "0,0,10,10"],
                ["nothing of the world"],
            ),
            "photos of noise": (
                2,
                ["generated:1", "a.tvx", "--ortho", survey() / "ortho"],
                ["--ortho"],
            ),
            "a setting out of range": (
                2,
                ["generated:1", "a.tvx", "--generated-world-height", "1"],
                ["--generated-world-height = 1; allowed: 8 to"],
            ),
        }

    def test_impossible_arguments_are_refused(self):
        (self.out / "text.txt").write_text("nothing to see here\n")
        (self.out / "empty").mkdir()
        (self.out / "there.tvx").write_text("mine")
        for name, (code, arguments, said) in self.wrong_conversions().items():
            with self.subTest(name):
                run = convert(*arguments, cwd=self.out)
                self.assertRefused(run, code, *said)
                self.assertEqual(entries(self.out), ["empty", "text.txt", "there.tvx"])
        self.assertEqual((self.out / "there.tvx").read_text(), "mine")


if __name__ == "__main__":
    unittest.main()

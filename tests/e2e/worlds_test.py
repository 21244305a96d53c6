#!/usr/bin/env python3
"""Worlds of every kind: described, rendered, converted, and read back."""

import json
import pathlib
import re
import shutil
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
        convert(survey(), "--ortho", survey() / "ortho", cls.whole).done()

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
        whole, copy = self.out / "whole.tvx", self.out / "copy.tvx"
        self.done(convert("generated:3", whole, "--area", "-256,-256,256,256"))
        server = changing_host(whole.read_bytes(), after=1 << 30)
        words = [server.url + "place.tvx", copy, "--threads", "1"]
        self.done(convert(*words))
        most = server.requests
        copy.unlink()
        for goes_on in (True, False):
            with self.subTest(goes_on=goes_on):
                server.requests, server.after = 0, most - 2
                self.assertRefused(convert(*words), 1, "has changed")
                self.assertIn(";", (self.out / "copy.tvx.journal").read_text())
                server.requests, server.after = 0, 1 << 30 if goes_on else 0
                run = self.done(Run([binary("RAYTRACER"), "convert", *words]))
                self.assertEqual("going on" in run.out + run.err, goes_on, str(run))
                self.assertTrue(copy.read_bytes() == whole.read_bytes(), "not the same bytes")
                copy.unlink()

    def test_a_minecraft_world_of_a_place_is_that_place(self):
        world = self.out / "my town"
        self.done(convert(survey(), "--ortho", survey() / "ortho", world))
        for part in ("level.dat", "terravox.json", "region"):
            self.assertTrue((world / part).exists(), part)
        facts = self.done(info(world)).out
        self.assertIn("Anvil", facts)
        # Each frames its own bounds.
        flags = [*PLAIN, "--detail", "0", "--camera-position", "462340,101330,640"]
        flags += ["--camera-target", "462500,101490,480"]
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
        whole, killed = self.out / "whole.tvx", self.out / "killed.tvx"
        area = ["--area", "-512,-512,512,512", "--threads", "1"]
        words = [binary("RAYTRACER"), "convert", "generated:3", *area]
        self.done(Run([*words, whole, "--quiet"]))
        journal = self.out / "killed.tvx.journal"
        with subprocess.Popen([*words, killed, "--quiet"]) as process:
            while not (journal.exists() and journal.read_text().count(";") >= 2):
                self.assertIsNone(process.poll(), "it ended before it could be killed")
                time.sleep(0.01)
            process.kill()
        self.assertFalse(killed.exists())
        run = self.done(Run([*words, killed]))
        self.assertIn("going on", run.out + run.err)
        self.assertTrue(whole.read_bytes() == killed.read_bytes(), "not the same bytes")
        self.assertEqual(entries(self.out), ["killed.tvx", "whole.tvx"])

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

    def test_impossible_arguments_are_refused(self):
        (self.out / "text.txt").write_text("nothing to see here\n")
        (self.out / "there.tvx").write_text("mine")
        noise = ("generated:1", "a.tvx")
        for arguments, *said in (
            (("text.txt", "a.tvx"), "text.txt", "box archive"),
            (("generated:1", "a.obj"), ".obj", "allowed:"),
            ((*noise, "--to", "fbx"), "fbx", "allowed:"),
            (("generated:1", "there.tvx"), "--overwrite"),
            ((square(), "a.tvx", "--level", "20"), "level 20", "allowed: 0 to"),
            ((square(), "a.tvx", "--area", "nan,0,10,10"), "--area nan", "allowed:"),
            ((square(), "a.tvx", "--heights", "500,400"), "--heights 500", "allowed:"),
            ((square(), "a.tvx", "--area", "0,0,10,10"), "nothing of the world"),
            ((*noise, "--ortho", survey() / "ortho"), "--ortho"),
        ):
            with self.subTest(said):
                self.assertRefused(convert(*arguments, cwd=self.out), 2, *said)
                self.assertEqual(entries(self.out), ["text.txt", "there.tvx"])
        self.assertEqual((self.out / "there.tvx").read_text(), "mine")


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
"""Squares of an archive that changed, as a user replaces them: terravox convert --squares, and
terravox-archive patch."""

import contextlib
import os
import pathlib
import random
import shutil
import signal
import subprocess
import time
import unittest

from support import (
    Case,
    Run,
    binary,
    entries,
    make,
    make_survey,
    only_in_all,
    prints_of,
    temporary_folder,
)

OPTIONS = ["--voxel", "1", "--cache", "none", "--quiet"]
# Where materials are guessed from intensities, squares up to 500 m away change, too.
PLAIN = [*OPTIONS, "--steps=-material_guesses"]


def archive(*arguments, **options):
    return Run([binary("ARCHIVE"), *arguments], **options)


_converted = {}


def convert(data, out, *options):
    """Converts data, unless squares of the same bytes have been converted so before: tests begin
    with the same flights, and change the same squares.

    @return the archive, which no test changes
    """
    options = options or PLAIN
    key = (data.name, *options, *prints_of(data))
    if key not in _converted:
        make("CONVERT", data, out, *options)
        _converted[key] = out
    return _converted[key]


class Patch(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.data = {density: cls.fly(density) for density in (2, 3)}
        cls.names = sorted(file.stem for file in cls.data[2].glob("*.laz"))
        cls.old = convert(cls.data[2], temporary_folder() / "old.tvx")
        cls.changed = cls.flown_again(cls.names[11])
        cls.new = convert(cls.changed, temporary_folder() / "new.tvx")
        cls.change = cls.change_of(cls.changed, cls.names[11])

    @staticmethod
    def fly(density, *options, square_m=64):
        folder = temporary_folder() / f"flight{density}"
        return make_survey(folder, "5x5", square_m, density, *options)

    @classmethod
    def flown_again(cls, *names):
        """The first flight, with some squares of the second."""
        folder = temporary_folder() / "data"
        shutil.copytree(cls.data[2], folder)
        for name in names:
            shutil.copy(cls.data[3] / f"{name}.laz", folder)
        return folder

    @staticmethod
    def change_of(data, name, *options):
        out = temporary_folder() / "change.tvx"
        return convert(data, out, *(options or PLAIN), "--squares", name)

    def assertSameBytes(self, a, b):
        self.assertEqual(pathlib.Path(a).read_bytes(), pathlib.Path(b).read_bytes())

    def test_a_patched_archive_has_the_bytes_of_a_conversion_anew(self):
        """At the corner, and at the shore of a lake that spans squares."""
        for index in (2, 24):
            with self.subTest(self.names[index]):
                data = self.flown_again(self.names[index])
                change = self.change_of(data, self.names[index])
                out = temporary_folder() / "patched.tvx"
                run = archive("patch", self.old, change, "-o", out)
                self.assertDone(run)
                self.assertRegex(run.out, r" columns of boxes replaced, \d+ records new, [1-9]")
                self.assertSameBytes(out, convert(data, temporary_folder() / "new.tvx"))
        self.assertDone(archive("verify", out))

    @only_in_all
    def test_materials_that_are_guessed_change_with_squares_that_are_near(self):
        old = convert(self.data[2], temporary_folder() / "old.tvx", *OPTIONS)
        data = self.flown_again(self.names[24])
        change = self.change_of(data, self.names[24], *OPTIONS)
        out = temporary_folder() / "patched.tvx"
        self.assertDone(archive("patch", old, change, "-o", out))
        self.assertSameBytes(out, convert(data, temporary_folder() / "new.tvx", *OPTIONS))

    @only_in_all
    def test_islands_are_compared_with_what_lies_far_from_them(self):
        flights = {density: self.fly(density, square_m=128) for density in (2, 3)}
        names = sorted(file.stem for file in flights[2].glob("*.laz"))

        def islands(density):
            folder = temporary_folder() / "data"
            folder.mkdir()
            for name, flight in ((names[0], 2), (names[24], density)):
                shutil.copy(flights[flight] / f"{name}.laz", folder)
            return folder

        # Small voxels: the boxes that are compared hold little more than a shore.
        fine = [*OPTIONS[2:], "--voxel", "0.5"]
        plain = [*fine, "--steps=-material_guesses"]
        old = convert(islands(2), temporary_folder() / "old.tvx", *plain)
        data = islands(3)
        out = temporary_folder() / "patched.tvx"
        change = self.change_of(data, names[24], *plain)
        self.assertDone(archive("patch", old, change, "-o", out))
        self.assertSameBytes(out, convert(data, temporary_folder() / "new.tvx", *plain))
        other = [*fine, "--steps=-material_guesses,-vegetation"]
        change = self.change_of(data, names[24], *other)
        run = archive("patch", old, change, "-o", out, "--overwrite")
        self.assertRefused(run, 2, "are not alike")

    @only_in_all
    def test_photographs_whose_light_is_taken_out_change_with_their_squares(self):
        photographs = [*PLAIN, "--ortho", self.fly(2, "--photo-sun", "130,35") / "ortho"]
        old = convert(self.data[2], temporary_folder() / "old.tvx", *photographs)
        data = self.flown_again(self.names[11])
        change = self.change_of(data, self.names[11], *photographs)
        out = temporary_folder() / "patched.tvx"
        self.assertDone(archive("patch", old, change, "-o", out))
        self.assertSameBytes(out, convert(data, temporary_folder() / "new.tvx", *photographs))

    @only_in_all
    def test_the_archive_itself_is_replaced_and_killed_patches_leave_it_whole(self):
        place = pathlib.Path(shutil.copy(self.old, temporary_folder() / "place.tvx"))
        states = (self.old.read_bytes(), self.new.read_bytes())
        chance = random.Random(7)
        begun = time.monotonic()
        self.assertDone(archive("patch", self.old, self.change, "-o", place.with_name("a.tvx")))
        whole_s = time.monotonic() - begun
        place.with_name("a.tvx").unlink()
        for _ in range(12):
            words = [binary("ARCHIVE"), "patch", place, self.change, "--quiet"]
            with subprocess.Popen(words, stdout=subprocess.DEVNULL) as patching:
                time.sleep(chance.uniform(0, 1.1 * whole_s))
                with contextlib.suppress(ProcessLookupError):
                    os.kill(patching.pid, signal.SIGKILL)
            self.assertIn(place.read_bytes(), states)
        self.assertDone(archive("patch", place, self.change))
        self.assertSameBytes(place, self.new)
        self.assertEqual(entries(place.parent), ["place.tvx"])
        # Again it changes nothing.
        self.assertDone(archive("patch", place, self.change))
        self.assertSameBytes(place, self.new)

    @only_in_all
    def test_what_a_symbolic_link_leads_to_is_written(self):
        folder = temporary_folder()
        place = pathlib.Path(shutil.copy(self.old, folder / "place.tvx"))
        link = folder / "link.tvx"
        link.symlink_to("place.tvx")
        self.assertDone(archive("patch", link, self.change))
        self.assertSameBytes(place, self.new)
        self.assertTrue(link.is_symlink())
        self.assertEqual(entries(folder), ["link.tvx", "place.tvx"])

    @only_in_all
    def test_a_change_says_what_it_is(self):
        run = archive("info", self.change)
        self.assertDone(run)
        self.assertRegex(run.out, r"replaces \d+ columns of boxes")
        self.assertDone(archive("verify", self.change))
        run = archive("split", self.change, "--max-mib", "1")
        self.assertRefused(run, 1, "it is a change of one", "archive patch")
        picture = temporary_folder() / "picture.png"
        run = Run([binary("RAYTRACER"), "render", self.change, "-o", picture])
        self.assertRefused(run, 1, "it is a change of one", "archive patch")
        self.assertRefused(
            archive("merge", self.change, "-o", picture), 2, "not a shard", "convert --shard"
        )

    def test_what_does_not_belong_together_is_refused(self):
        """By the boxes around those that changed, which must be alike."""
        out = temporary_folder() / "patched.tvx"
        coarse = [*PLAIN[2:], "--voxel", "2"]
        filled = [*OPTIONS, "--steps=-material_guesses,-building_fill,-vegetation"]
        for change, code, said in (
            (self.change_of(self.changed, self.names[11], *coarse), 2, "size of voxels"),
            (self.change_of(self.changed, self.names[11], *filled), 2, "are not alike"),
            (self.old, 2, "not a change"),
            (self.data[2] / f"{self.names[0]}.laz", 1, "not a box archive"),
        ):
            with self.subTest(said):
                run = archive("patch", self.old, change, "-o", out)
                self.assertRefused(run, code, said)
        self.assertEqual(entries(out.parent), [])
        run = archive("patch", self.old, self.change, "-o", self.new)
        self.assertRefused(run, 2, "--overwrite")
        run = archive("patch", self.old, self.change, "-o", self.change, "--overwrite")
        self.assertRefused(run, 2, "it is the change")

    def test_squares_that_cannot_be_are_refused(self):
        out = temporary_folder() / "change.tvx"
        for options, said in (
            (["--squares", "TM_1_1"], "there is none"),
            (["--squares", ",,"], "names none"),
            (["--squares", self.names[0], "--shard", "1/2"], "allowed: one of them"),
            (["--squares", self.names[0], "--area", "0,0,1,1"], "--area"),
        ):
            with self.subTest(said):
                run = Run([binary("CONVERT"), self.data[2], out, *PLAIN, *options])
                self.assertRefused(run, 2, said)
        run = Run([binary("CONVERT"), self.data[2], out.with_suffix(".glb"), "--squares", "a"])
        self.assertRefused(run, 2, "allowed: to a box archive")
        run = Run([binary("CONVERT"), "generated:1", out, "--squares", "a"])
        self.assertRefused(run, 2, "allowed: LiDAR data and stores")
        self.assertEqual(entries(out.parent), [])


if __name__ == "__main__":
    unittest.main()

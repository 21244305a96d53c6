#!/usr/bin/env python3
"""The archive of a country kept up to date with its squares: terravox country patch."""

import contextlib
import json
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import time
import unittest

from support import ROOT, Case, Run, binary, entries, make_survey, prints_of, temporary_folder

OPTIONS = ["--voxel", "1", "--quiet"]


def country(*arguments, **options):
    return Run([binary("RAYTRACER"), "country", *arguments], **options)


class CountryPatch(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.flights = {
            density: make_survey(temporary_folder() / f"flight{density}", "5x5", 64, density)
            for density in (2, 3)
        }
        cls.names = sorted(file.stem for file in cls.flights[2].glob("*.laz"))
        cls.sharded = {}
        cls.anew = {}

    def with_shards(self, without, options):
        """A folder with data, a plan and its shards, made once: plans can be copied with data."""
        key = (*without, *options)
        if key not in self.sharded:
            folder = temporary_folder() / "place"
            shutil.copytree(self.flights[2], folder / "data")
            for name in without:
                (folder / "data" / f"{name}.laz").unlink()
            words = ["data", "-o", "plan", "--shards", "2", *OPTIONS, *options]
            self.assertDone(country("plan", *words, cwd=folder))
            for task in (1, 2):
                self.assertDone(country("run", "plan", "--task", task, "--quiet", cwd=folder))
            self.sharded[key] = folder
        return self.sharded[key]

    def planned(self, *without, options=()):
        """A folder with data, a plan and its archive; some squares are not there."""
        folder = temporary_folder() / "place"
        shutil.copytree(self.with_shards(without, options), folder)
        self.assertDone(country("run", folder / "plan", "-o", folder / "place.tvx", "--quiet"))
        return folder

    def fly_again(self, folder, name):
        shutil.copy(self.flights[3] / f"{name}.laz", folder / "data")

    def assertIsAnew(self, folder, *options):
        """The bytes of a conversion, made once of the same bytes: many tests change one square."""
        key = (*options, *prints_of(folder / "data"))
        if key not in self.anew:
            out = temporary_folder() / "anew.tvx"
            words = [folder / "data", out, *OPTIONS, "--cache", "none", *options]
            self.assertDone(Run([binary("CONVERT"), *words]))
            self.anew[key] = out.read_bytes()
        self.assertEqual((folder / "place.tvx").read_bytes(), self.anew[key])

    def assertPatched(self, folder, *said):
        run = country("patch", folder / "plan", "--quiet")
        self.assertDone(run)
        for text in said:
            self.assertIn(text, run.out)

    def assertAllIsDone(self, folder):
        """Of the shards none is of these data any more, of the archive all is."""
        status = country("status", folder / "plan", "--json")
        self.assertDone(status)
        said = json.loads(status.out)
        self.assertEqual((said["done"], said["share"], said["holes"]), (said["shards"], 1, 0))
        self.assertEqual(said["patched"], str(folder / "place.tvx"))
        self.assertIn("patched since", country("status", folder / "plan").out)

    def test_what_changed_is_found_and_put_in(self):
        """A new flight, at the shore of a lake, too; a square that is new; one that is gone."""
        folder = self.planned(self.names[24])
        self.assertPatched(folder, "no square has changed")
        self.fly_again(folder, self.names[11])
        self.fly_again(folder, self.names[2])
        said = (f"{self.names[11]}.laz has changed", "2 squares; ", " columns of boxes replaced")
        self.assertPatched(folder, *said)
        self.assertIsAnew(folder)
        self.fly_again(folder, self.names[24])
        self.assertPatched(folder, f"{self.names[24]}.laz is new")
        self.assertIsAnew(folder)
        (folder / "data" / f"{self.names[12]}.laz").unlink()
        self.assertPatched(folder, f"{self.names[12]}.laz is gone")
        self.assertIsAnew(folder)
        self.assertPatched(folder, "no square has changed")
        run = country("run", folder / "plan", "-o", folder / "place.tvx")
        self.assertDone(run)
        self.assertIn("there already", run.out)
        self.assertAllIsDone(folder)
        self.assertEqual(entries(folder / "plan" / "scratch"), [])

    def columns_replaced(self, folder):
        run = country("patch", folder / "plan", "--quiet")
        self.assertDone(run)
        return int(re.search(r"(\d+) columns of boxes replaced", run.out)[1])

    def test_what_intensities_mean_is_compared(self):
        """The neighbours of a square change with it only where their scale does."""
        folder = self.planned()
        square = folder / "data" / f"{self.names[11]}.laz"
        os.utime(square)
        same_points = self.columns_replaced(folder)
        self.assertIsAnew(folder)
        self.fly_again(folder, self.names[11])
        self.assertLess(same_points, self.columns_replaced(folder))
        self.assertIsAnew(folder)

    def test_facts_of_another_plan_tell_no_scales(self):
        """They say what intensities meant in an archive that is no longer there."""
        folder = self.planned()
        known = folder / "plan" / "squares.known"
        facts = known.read_bytes()
        square = folder / "data" / f"{self.names[12]}.laz"
        shutil.move(square, folder / "away.laz")
        words = [folder / "data", "-o", folder / "plan", "--shards", "2", *OPTIONS, "--overwrite"]
        self.assertDone(country("plan", *words))
        known.write_bytes(facts)
        run = country("run", folder / "plan", "-o", folder / "place.tvx", "--overwrite", "-q")
        self.assertDone(run)
        shutil.move(folder / "away.laz", square)
        self.assertPatched(folder, "is new")
        self.assertIsAnew(folder)

    def test_nothing_is_believed_without_its_file(self):
        folder = self.planned(options=["--steps=-material_guesses"])
        known = folder / "plan" / "squares.known"
        whole = known.read_bytes()
        before = (folder / "place.tvx").read_bytes()
        self.fly_again(folder, self.names[11])
        known.write_bytes(whole[:-9])
        run = country("patch", folder / "plan", "--quiet")
        self.assertRefused(run, 1, "does not know where", "plan again")
        self.assertEqual((folder / "place.tvx").read_bytes(), before)
        known.write_bytes(whole)
        self.assertPatched(folder, "has changed")
        self.assertIsAnew(folder, "--steps=-material_guesses")

    def test_killed_at_any_time_it_goes_on(self):
        folder = self.planned()
        chance = random.Random(7)
        self.fly_again(folder, self.names[11])
        for _ in range(6):
            words = [binary("RAYTRACER"), "country", "patch", folder / "plan", "--quiet"]
            with subprocess.Popen(words, stdout=subprocess.DEVNULL) as patching:
                time.sleep(chance.uniform(0, 0.7))
                with contextlib.suppress(ProcessLookupError):
                    os.kill(patching.pid, signal.SIGKILL)
        self.assertPatched(folder)
        self.assertIsAnew(folder)

    def interrupted(self, folder, facts_are_new=False):
        """A patch that was killed between its archive and its facts, or these and its plan."""
        files = [folder / "plan" / name for name in ("plan.json", "run.json")]
        plan, note = (file.read_text() for file in files)
        known = (folder / "plan" / "squares.known").read_bytes()
        self.fly_again(folder, self.names[11])
        self.assertPatched(folder, "has changed")
        before, after = json.loads(note), json.loads(files[1].read_text())
        files[0].write_text(plan)
        note = {**after, "before": before["after"], "after": "", "patched": before["plan"]}
        files[1].write_text(json.dumps(note))
        if not facts_are_new:
            (folder / "plan" / "squares.known").write_bytes(known)

    def test_killed_between_archive_and_plan_it_goes_on(self):
        for facts_are_new in (False, True):
            with self.subTest(facts_are_new=facts_are_new):
                folder = self.planned()
                self.interrupted(folder, facts_are_new)
                self.assertPatched(folder, "has changed")
                self.assertIsAnew(folder)
                self.assertPatched(folder, "no square has changed")
                self.assertAllIsDone(folder)

    def test_interrupted_it_goes_on_with_the_same_data_only(self):
        folder = self.planned()
        shutil.copy2(folder / "data" / f"{self.names[11]}.laz", folder / "old.laz")
        self.interrupted(folder)
        self.fly_again(folder, self.names[12])
        refused = (1, "was interrupted, and the data have changed again", "plan again")
        self.assertRefused(country("patch", folder / "plan", "--quiet"), *refused)
        shutil.copy2(self.flights[2] / f"{self.names[12]}.laz", folder / "data")
        shutil.copy2(folder / "old.laz", folder / "data" / f"{self.names[11]}.laz")
        self.assertRefused(country("patch", folder / "plan", "--quiet"), *refused)

    def test_other_settings_are_refused(self):
        folder = temporary_folder()
        shutil.copytree(self.flights[2], folder / "data")
        settings = folder / "settings.toml"
        standard = (ROOT / "config" / "voxelize.toml").read_text()
        settings.write_text(standard)
        words = [folder / "data", "-o", folder / "plan", "--shards", "1", *OPTIONS]
        self.assertDone(country("plan", *words, "--settings", settings))
        self.assertDone(country("run", folder / "plan", "-o", folder / "place.tvx", "--quiet"))
        before = (folder / "place.tvx").read_bytes()
        self.fly_again(folder, self.names[11])
        self.assertIn("depth_m = ", standard)
        settings.write_text(re.sub(r"(?m)^(depth_m = )[\d.]+", r"\g<1>3.5", standard))
        run = country("patch", folder / "plan", "--quiet")
        self.assertRefused(run, 1, "all of the archive has to be made anew", "settings")
        self.assertEqual((folder / "place.tvx").read_bytes(), before)
        settings.write_text(standard)
        self.assertPatched(folder, "has changed")

    def test_what_cannot_be_patched_is_refused(self):
        folder = temporary_folder()
        shutil.copytree(self.flights[2], folder / "data")
        words = [folder / "data", "-o", folder / "plan", "--shards", "1", *OPTIONS]
        self.assertDone(country("plan", *words))
        run = country("patch", folder / "plan")
        self.assertRefused(run, 2, "its archive is not finished", "country run")
        self.assertRefused(country("patch", folder / "none"), 2, "there is no such folder")
        self.assertDone(country("run", folder / "plan", "-o", folder / "place.tvx", "--quiet"))
        before = (folder / "place.tvx").read_bytes()
        square = folder / "data" / f"{self.names[3]}.laz"
        square.write_bytes(square.read_bytes()[:200])
        run = country("patch", folder / "plan")
        self.assertRefused(run, 1, square.name, "the archive stays as it is")
        self.assertEqual((folder / "place.tvx").read_bytes(), before)
        pathlib.Path(folder / "place.tvx").write_bytes(before + b"x")
        run = country("patch", folder / "plan")
        self.assertRefused(run, 2, "is another one than its run has written")


if __name__ == "__main__":
    unittest.main()

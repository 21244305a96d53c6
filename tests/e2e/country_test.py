#!/usr/bin/env python3
"""terravox country as a user runs it: a plan, its shards made here or by tasks, one archive."""

import contextlib
import functools
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

from small_disk import SmallDisk, why_not
from support import (
    ROOT,
    Case,
    Run,
    binary,
    make,
    make_survey,
    only_in_all,
    temporary_folder,
    wait_until,
)

NO_SMALL_DISK = why_not()
KILLED_RUNS = 10
# Of the archive. Voxels of a metre suffice: 36 columns of boxes to be divided into shards.
VOXEL = ["--voxel", "1"]
_plans = {}


@functools.cache
def survey():
    """A folder with 3 x 3 squares of 128 m; made once."""
    return make_survey(temporary_folder() / "survey", "3x3", 128, 2)


@functools.cache
def whole():
    """The archive that a single run writes."""
    out = temporary_folder() / "whole.tvx"
    make("CONVERT", survey(), out, *VOXEL, "--cache", "none")
    return out.read_bytes()


def country(*arguments, **options):
    return Run([binary("RAYTRACER"), "country", *arguments], **options)


def start(*arguments):
    """A process in a group of its own, so that it can be killed with its children."""
    return subprocess.Popen(
        [binary("RAYTRACER"), "country", *map(str, arguments)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )


def kill(pid):
    with contextlib.suppress(ProcessLookupError):
        os.kill(pid, signal.SIGKILL)


def kill_group(pid):
    with contextlib.suppress(ProcessLookupError):
        os.killpg(pid, signal.SIGKILL)


def children_of(pid):
    try:
        text = pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="ascii")
    except OSError:
        return []
    return [int(word) for word in text.split()]


class Country(Case):
    def setUp(self):
        self.folder = temporary_folder()
        self.plan = self.folder / "plan"
        self.out = self.folder / "country.tvx"

    def make_plan(self, shards, *options, data=None):
        """A plan of the survey, if nothing else is said: then it is made once, and copied."""
        if options or data:
            self.write_plan(self.plan, data or survey(), shards, *options)
            return
        if shards not in _plans:
            _plans[shards] = temporary_folder() / "plan"
            self.write_plan(_plans[shards], survey(), shards)
        shutil.copytree(_plans[shards], self.plan)

    def write_plan(self, plan, data, shards, *options):
        words = [data, "-o", plan, "--shards", shards, "--sample", "2", *VOXEL, "--quiet"]
        self.assertDone(country("plan", *words, *options))

    def assertRefused(self, run, code, *said):
        self.assertEqual(run.code, code, str(run))
        self.assertTrue(run.err.startswith("terravox: ") or "terravox: " in run.err, str(run))
        for text in said:
            self.assertIn(text, run.err)

    def shards(self):
        return {p.name: p.stat().st_mtime_ns for p in (self.plan / "shards").glob("*.tvx")}

    def status(self):
        return json.loads(country("status", self.plan, "--json").out)

    def assertSame(self):
        self.assertEqual(self.out.read_bytes(), whole())

    def test_shards_give_the_bytes_of_a_single_run(self):
        for shards in (1, 9):
            with self.subTest(shards):
                self.setUp()
                self.make_plan(shards)
                run = country("run", self.plan, "-o", self.out, "--quiet")
                self.assertDone(run)
                self.assertSame()
                status = self.status()
                self.assertEqual((status["done"], status["shards"]), (shards, shards))
                self.assertEqual(status["share"], 1)
                self.assertFalse((self.plan / "scratch").exists(), "scratch stays behind")
        self.assertDone(Run([binary("ARCHIVE"), "verify", self.out]))

    def test_a_plan_is_of_a_part(self):
        words = ("--heights", "480,500", "--area", "462400,101400,462700,101700")
        self.make_plan(3, *words)
        self.assertDone(country("run", self.plan, "-o", self.out, "--quiet"))
        single = self.folder / "single.tvx"
        options = [*VOXEL, "--cache", "none", "--quiet"]
        self.assertDone(Run([binary("CONVERT"), survey(), single, *options, *words]))
        self.assertEqual(self.out.read_bytes(), single.read_bytes())
        self.setUp()
        plan = [survey(), "-o", self.plan, "--heights", "500"]
        self.assertRefused(country("plan", *plan), 2, "--heights")

    @only_in_all
    def test_killed_at_any_time_it_goes_on_and_makes_nothing_again(self):
        """The whole run, and single tasks, are killed at random times until it is done."""
        for seed in range(KILLED_RUNS):
            with self.subTest(seed=seed):
                self.setUp()
                chance = random.Random(seed)
                self.make_plan(9)
                finished = {}
                for _ in range(4):
                    self.kill_some(chance)
                    now = self.shards()
                    for name, time_ns in finished.items():
                        self.assertEqual(now[name], time_ns, f"{name} was made again")
                    finished = now
                again = ("run", self.plan, "-o", self.out) if seed % 2 else ("resume", self.plan)
                if not (self.plan / "run.json").exists():
                    again = ("run", self.plan, "-o", self.out)
                self.assertDone(country(*again, "--quiet"))
                self.assertSame()
                now = self.shards()
                self.assertEqual({n: now[n] for n in finished}, finished)
                self.assertDone(country("resume", self.plan, "--quiet"))
                self.assertEqual(self.shards(), now)

    def kill_some(self, chance):
        run = start("run", self.plan, "-o", self.out, "--jobs", "2", "--quiet")
        try:
            end = time.monotonic() + chance.uniform(0.05, 2.5)
            while time.monotonic() < end and run.poll() is None:
                if chance.random() < 0.2:
                    for pid in children_of(run.pid):
                        if chance.random() < 0.5:
                            kill(pid)
                time.sleep(chance.uniform(0.02, 0.2))
        finally:
            if chance.random() < 0.5:
                kill(run.pid)  # alone: its tasks end with it
            else:
                kill_group(run.pid)
            run.wait()

    def test_what_has_changed_is_refused_by_name(self):
        data = pathlib.Path(shutil.copytree(survey(), self.folder / "data"))
        self.make_plan(2, data=data)
        square = sorted(data.glob("*.laz"))[2]
        kept = square.read_bytes()
        square.write_bytes(kept)  # with another time
        for command in (("-o", self.out), ("--task", "2")):
            run = country("run", self.plan, *command, "--quiet")
            self.assertRefused(run, 1, square.name, "has changed", "plan again")
        square.unlink()
        run = country("run", self.plan, "-o", self.out)
        self.assertRefused(run, 1, square.name, "is gone")
        self.assertFalse(self.out.exists())
        self.make_plan(2, "--overwrite", data=data)
        square.write_bytes(kept)
        run = country("run", self.plan, "-o", self.out)
        self.assertRefused(run, 1, square.name, "is new")

    @only_in_all
    def test_other_settings_than_planned_are_refused(self):
        settings = self.folder / "voxelize.toml"
        shutil.copy(ROOT / "config" / "voxelize.toml", settings)
        self.make_plan(2, "--settings", settings)
        text = settings.read_text(encoding="utf-8")
        changed, count = re.subn(r"(?m)^depth_m = .*$", "depth_m = 7", text, count=1)
        self.assertEqual(count, 1)
        settings.write_text(changed, encoding="utf-8")
        run = country("run", self.plan, "--task", "1")
        self.assertRefused(run, 1, "settings, class table or palette have changed")
        self.assertEqual(self.status()["failed"], 1)
        self.assertIn("shard 1: failed: ", country("status", self.plan).out)
        settings.write_text(text, encoding="utf-8")
        self.assertDone(country("run", self.plan, "-o", self.out, "--quiet"))
        self.assertSame()

    def edit_plan(self, **values):
        file = self.plan / "plan.json"
        plan = json.loads(file.read_text(encoding="utf-8"))
        file.write_text(json.dumps({**plan, **values}), encoding="utf-8")

    @only_in_all
    def test_another_version_is_refused(self):
        self.make_plan(2)
        self.edit_plan(program="0.0.1")
        for command in (("-o", self.out), ("--task", "1")):
            run = country("run", self.plan, *command)
            self.assertRefused(run, 1, "made by version 0.0.1", "allowed: the same")
        self.edit_plan(format=2)
        self.assertRefused(country("run", self.plan, "-o", self.out), 1, "format 2; allowed: 1")
        (self.plan / "plan.json").write_text("{", encoding="utf-8")
        self.assertRefused(country("status", self.plan), 1, "no JSON object")

    @only_in_all
    def test_two_runs_at_once_never_spoil_anything(self):
        self.make_plan(9)
        first = start("run", self.plan, "-o", self.out, "--jobs", "1", "--quiet")
        try:
            wait_until((self.plan / "run.json").exists, "the first run has begun")
            second = country("run", self.plan, "-o", self.folder / "other.tvx")
            if second.code == 1:  # else the first was done by then
                self.assertRegex(second.err, f"process {first.pid} of .* runs it already")
        finally:
            self.assertEqual(first.wait(), 0)
        self.assertSame()

    @only_in_all
    def test_a_task_that_runs_is_not_made_twice(self):
        self.make_plan(2)
        task = start("run", self.plan, "--task", "1", "--threads", "1", "--quiet")
        try:
            wait_until(lambda: (self.plan / "tasks" / "00001.json").exists(), "the task runs")
            os.kill(task.pid, signal.SIGSTOP)
            if task.poll() is None and not self.shards():
                run = country("run", self.plan, "--task", "1")
                self.assertRefused(run, 1, f"process {task.pid} of ", "makes it")
                status = self.status()
                self.assertEqual(status["running"], 1, status)
        finally:
            os.kill(task.pid, signal.SIGCONT)
            self.assertEqual(task.wait(), 0)
        self.assertEqual(self.status()["done"], 1)

    def test_a_damaged_square_is_a_hole_with_a_name(self):
        data = pathlib.Path(shutil.copytree(survey(), self.folder / "data"))
        unreadable, broken = sorted(data.glob("*.laz"))[3:5]
        unreadable.write_bytes(b"LASF, but nothing else")
        whole_file = broken.read_bytes()
        # A later layer of its chunk fails at its end: only decoding all points finds it.
        at = len(whole_file) * 7 // 10
        broken.write_bytes(whole_file[:at] + bytes(2000) + whole_file[at + 2000 :])
        words = [data, "-o", self.plan, "--shards", "4", "--sample", "9"]
        run = country("plan", *words, "--quiet", "--json")
        self.assertEqual(run.code, 3, str(run))
        names = {square["name"] for square in json.loads(run.out)["missing"]}
        self.assertIn(unreadable.stem, names)
        self.assertIn(f"missing: {unreadable.stem}", run.err)
        run = country("run", self.plan, "-o", self.out, "--quiet")
        self.assertEqual(run.code, 3, str(run))
        self.assertIn(unreadable.stem, run.err)
        self.assertIn(broken.name, run.err)
        self.assertEqual(Run([binary("ARCHIVE"), "verify", self.out]).code, 3)
        facts = json.loads(Run([binary("ARCHIVE"), "info", "--json", self.out]).out)
        self.assertGreater(facts["damage"], 0)
        self.assertEqual(country("run", self.plan, "-o", self.out).code, 3)
        status = country("status", self.plan)
        self.assertEqual(status.code, 3, str(status))
        self.assertIn(unreadable.stem, status.out)

    @only_in_all
    def test_an_archive_that_is_there_is_left_alone(self):
        self.make_plan(2)
        self.out.write_text("mine", encoding="utf-8")
        run = country("run", self.plan, "-o", self.out)
        self.assertRefused(run, 2, "it is there already", "--overwrite")
        self.assertEqual(self.out.read_text(encoding="utf-8"), "mine")
        self.assertDone(country("run", self.plan, "-o", self.out, "--overwrite", "--quiet"))
        self.assertSame()
        run = country("run", self.plan, "-o", self.out)
        self.assertDone(run)
        self.assertIn("there already, of 2 shards", run.out)

    @only_in_all
    def test_a_shard_that_is_damaged_is_made_again(self):
        self.make_plan(2)
        self.assertDone(country("run", self.plan, "-o", self.out, "--quiet"))
        shard = self.plan / "shards" / "00002.tvx"
        kept = shard.read_bytes()
        shard.write_bytes(kept[:-9])
        self.out.unlink()
        self.assertDone(country("run", self.plan, "-o", self.out, "--quiet"))
        self.assertSame()
        self.assertEqual(shard.read_bytes(), kept)

    @only_in_all
    def test_a_plan_and_its_data_can_be_moved(self):
        place = self.folder / "place"
        place.mkdir()
        shutil.copytree(survey(), place / "survey")
        words = ["survey", "-o", "plan", "--shards", "2", "--sample", "1", *VOXEL]
        self.assertDone(country("plan", *words, "--quiet", cwd=place))
        moved = self.folder / "elsewhere"
        place.rename(moved)
        self.assertDone(country("run", moved / "plan", "-o", self.out, "--quiet"))
        self.assertSame()

    def test_wrong_usage_ends_with_2(self):
        here = survey()
        for arguments, said in (
            ((), ""),
            (("plan", here), "--output"),
            (
                ("plan", here, "-o", self.plan, "--shards", "0"),
                "--shards = '0'; allowed: 1 to 65536",
            ),
            (("plan", self.folder / "none", "-o", self.plan), "none"),
            (("plan", "noise:1", "-o", self.plan), "allowed: LAS"),
            (("plan", here, "-o", self.plan, "--add", "1,2,3,4,5"), "--add"),
            (("run", self.plan, "-o", self.out), "no such folder"),
            (("status", self.folder), "no plan.json"),
        ):
            with self.subTest(arguments):
                self.assertRefused(country(*arguments), 2, said)
        self.make_plan(2)
        for arguments, said in (
            (("run", self.plan), "allowed: -o"),
            (("run", self.plan, "--task", "3"), "allowed: 1 to 2"),
            (("run", self.plan, "--task", "1", "-o", self.out), "--task with -o"),
            (("run", self.plan, "-o", self.out, "--wait"), "--wait without --join"),
            (("resume", self.plan), "no run has begun"),
            (("plan", here, "-o", self.plan), "--overwrite"),
        ):
            with self.subTest(arguments):
                self.assertRefused(country(*arguments), 2, said)
        run = country("run", self.plan, "-o", self.out, "--join")
        self.assertRefused(run, 1, "shard 1 of 2 is missing")

    @only_in_all
    @unittest.skipIf(NO_SMALL_DISK, NO_SMALL_DISK)
    def test_a_full_disk_in_a_task_is_a_line_and_loses_nothing(self):
        with SmallDisk(40_000) as disk:
            words = ["-o", disk.folder / "plan", "--shards", "4", "--sample", "1", *VOXEL]
            program = [*disk.within, binary("RAYTRACER"), "country"]
            self.assertDone(Run([*program, "plan", survey(), *words, "--quiet"]))
            run = [*program, "run", disk.folder / "plan", "-o", disk.folder / "country.tvx"]
            self.assertDone(Run([*run[:-2], "--task", "1", "--quiet"]))
            first = (disk.seen / "plan" / "shards" / "00001.tvx").read_bytes()
            disk.leave(20)
            full = Run([*run, "--quiet"])
            self.assertEqual(full.code, 1, str(full))
            self.assertIn("failed: ", full.err)
            self.assertIn("the disk of the plan is full", full.err)
            self.assertIn(str(disk.folder), full.err)
            self.assertFalse((disk.seen / "country.tvx").exists())
            disk.leave(40_000)
            self.assertDone(Run([*run, "--quiet"]))
            self.assertEqual((disk.seen / "country.tvx").read_bytes(), whole())
            self.assertEqual((disk.seen / "plan" / "shards" / "00001.tvx").read_bytes(), first)

    @only_in_all
    def test_ctrl_c_ends_it_with_a_line(self):
        self.make_plan(9)
        run = subprocess.Popen(
            [binary("RAYTRACER"), "country", "run", self.plan, "-o", self.out],
            stderr=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            text=True,
        )
        wait_until((self.plan / "tasks" / "00001.json").exists, "a task runs")
        run.send_signal(signal.SIGINT)
        _, err = run.communicate()
        if run.returncode != 0:
            self.assertEqual(run.returncode, 1, err)
            self.assertIn("interrupted", err)
            self.assertEqual(self.status()["failed"], 0, "an interrupted task has not failed")
        self.assertDone(country("resume", self.plan, "--quiet"))
        self.assertSame()


class Scripts(Case):
    """Files for schedulers, run by stand-ins for them."""

    def setUp(self):
        self.folder = temporary_folder() / "a country, by 'n\"x' $(false)"
        self.folder.mkdir()
        words = [survey(), "-o", "plan", "--shards", "3", "--sample", "1", *VOXEL]
        self.write = lambda *options: Run(
            [binary("RAYTRACER"), "country", "plan", *words, "--overwrite", "--quiet", *options],
            cwd=self.folder,
        )

    @only_in_all
    def test_the_template_for_openjd_makes_the_archive(self):
        self.assertDone(self.write("--openjd", "job.json"))
        job = json.loads((self.folder / "job.json").read_text(encoding="utf-8"))
        shards, join = job["steps"]
        space = shards["parameterSpace"]["taskParameterDefinitions"]
        self.assertEqual(space, [{"name": "Task", "type": "INT", "range": "0-2"}])
        self.assertEqual(join["dependencies"], [{"dependsOn": shards["name"]}])
        path = f"{pathlib.Path(binary('RAYTRACER')).parent}:{os.environ['PATH']}"
        for step, arguments in ((shards, ["0"]), (shards, ["1"]), (shards, ["2"]), (join, [])):
            script = step["script"]["embeddedFiles"][0]["data"]
            words = ["bash", "-c", script, "terravox", *arguments]
            self.assertDone(Run(words, environment={"PATH": path}))
        self.assertEqual((self.folder / "plan.tvx").read_bytes(), whole())

    @only_in_all
    def test_the_jobs_for_kubernetes_make_the_archive(self):
        pods = ("--image", "terravox:0", "--claim", "data", "--nodes", "2")
        self.assertDone(self.write("--kubernetes", "jobs.json", *pods))
        text = (self.folder / "jobs.json").read_text(encoding="utf-8")
        shards, join = json.loads(text)["items"]
        self.assertEqual(shards["spec"]["completions"], 3)
        self.assertEqual(shards["spec"]["completionMode"], "Indexed")
        path = f"{pathlib.Path(binary('RAYTRACER')).parent}:{os.environ['PATH']}"
        for job, index in ((shards, "0"), (shards, "1"), (shards, "2"), (join, "")):
            command = job["spec"]["template"]["spec"]["containers"][0]["command"]
            command = [word.replace("$$", "$") for word in command]
            environment = {"PATH": path, "JOB_COMPLETION_INDEX": index}
            self.assertDone(Run(command, cwd=self.folder, environment=environment))
        self.assertEqual((self.folder / "plan.tvx").read_bytes(), whole())


if __name__ == "__main__":
    unittest.main()

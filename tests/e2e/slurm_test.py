#!/usr/bin/env python3
"""Rendering on a real Slurm cluster of four nodes on this machine.

Nodes and workers are killed; the pictures must be the same.
"""

import os
import pathlib
import re
import signal
import subprocess
import time
import unittest

from slurm import Cluster, why_not
from support import Case, Run, binary, only_in_all, render, survey, temporary_folder

REASON = why_not()
TURN = "fps = 6\n[turntable]\nseconds = 2\n"
FRAMES = ["--size", "256x144", "--samples", "4"]


# Replaces the program, for situations that the cluster's side must handle: a coordinator that ends
# with a given exit code once so many workers have arrived, and workers that do nothing, or die.
STAND_IN = """#!/bin/bash
cd -- "$(dirname "$0")"
printf '%s\\n' "$*" >> "said-$1"
case $1 in
render)
    trap 'echo stopped > stopped; exit 1' TERM
    [[ $(stat -c %a "$TOKEN") == 600 ]] || exit 9
    until compgen -G "came-$COME" > /dev/null; do sleep 0.1; done
    exit "$CODE"
    ;;
worker)
    : > "came-$SLURM_ARRAY_TASK_ID"
    [[ $DIE == 1 ]] || exec sleep 600
    ;;
esac
"""


@unittest.skipIf(REASON, REASON)
class OnSlurm(Case):
    @classmethod
    def setUpClass(cls):
        cls.cluster = Cluster(temporary_folder())
        cls.cluster.__enter__()
        cls.addClassCleanup(cls.cluster.stop)

    def setUp(self):
        self.folder = temporary_folder() / "a film, by 'n\"x' $(false) ü"
        self.folder.mkdir()
        self.frames = self.folder / "the frames"
        self.film = self.folder / "turn.toml"
        self.film.write_text(TURN)
        self.children = []
        self.addCleanup(self.end_children)

    def end_children(self):
        for child in self.children:
            if child.poll() is None:
                child.kill()
                child.wait()
        self.cluster.run("scancel", "--quiet", "--user=root")
        self.until(lambda: not self.cluster.tasks(), "an empty queue", 30)

    def until(self, done, what, timeout_s=60, child=None):
        deadline = time.monotonic() + timeout_s
        while not done():
            if child is not None and child.poll() is not None:
                self.fail(f"it ended before {what}: {self.said(child)}")
            self.assertLess(
                time.monotonic(),
                deadline,
                f"waited for {what}; queue: {self.cluster.tasks()}; said: {self.said(child)}; "
                f"logs: {self.logs()}",
            )
            time.sleep(0.05)

    def said(self, child):
        return (self.folder / "said.txt").read_text(errors="replace") if child is not None else ""

    def logs(self):
        return {p.name: p.read_text(errors="replace")[-1500:] for p in self.folder.rglob("logs/*")}

    def command(self, *arguments):
        limits = ["--nodes", "4", "--cpus-per-node", "1", "--memory-mib", "400"]
        words = ["cluster", "slurm", "--poll", "1", *limits]
        return [binary("RAYTRACER"), *words, *map(str, arguments)]

    def run_here(self, *arguments, timeout_s=100):
        return Run(
            self.command(*arguments),
            cwd=self.folder,
            timeout_s=timeout_s,
            environment=self.cluster.environment,
        )

    def start(self, *arguments):
        with (self.folder / "said.txt").open("wb") as said:
            child = subprocess.Popen(
                self.command(*arguments),
                cwd=self.folder,
                stdout=said,
                stderr=said,
                env={**os.environ, **self.cluster.environment},
            )
        self.children.append(child)
        return child

    def film_arguments(self):
        return [
            "--batch",
            "--folder",
            "the job",
            self.film.name,
            survey(),
            *FRAMES,
            "-o",
            "the frames/%03d.png",
        ]

    def contents(self, folder):
        return {p.name: p.read_bytes() for p in pathlib.Path(folder).glob("[0-9]*.png")}

    def running(self, name):
        """Nodes that run tasks of this name."""
        return [
            task[4] for task in self.cluster.tasks() if task[2] == name and task[3] == "RUNNING"
        ]

    def test_frames_are_the_same_though_a_node_dies_and_none_is_made_twice(self):
        whole = self.folder / "whole"
        words = ["animate", self.film, survey(), *FRAMES, "--quiet", "-o", whole / "%03d.png"]
        self.assertDone(Run([binary("RAYTRACER"), *words]))
        child = self.start(*self.film_arguments())
        self.until(lambda: len(self.running("terravox-frames")) > 1, "frames at work", child=child)
        victim = self.stop_a_render(child)
        self.cluster.kill_node(victim)
        self.addCleanup(self.bring_back, victim)
        code = child.wait(timeout=100)
        self.assertEqual(code, 0, f"{self.said(child)} {self.logs()}")
        self.assertIn("0 frames made, 12 were done before", self.said(child))
        job = re.search("job ([0-9]+): .*frames.sbatch", self.said(child))[1]
        self.assertIn(
            " Restarts=1 ",
            self.cluster.run("scontrol", "--oneliner", "show", "job", job),
            "no task was put back into the queue",
        )
        self.assertEqual(self.contents(self.frames), self.contents(whole))
        self.assertTrue(
            any("12 were done before" in text for text in self.logs().values()), self.logs()
        )
        self.assertTrue(
            any("1 squares prepared" in text for text in self.logs().values()), self.logs()
        )

        before = {p.name: p.stat().st_mtime_ns for p in self.frames.glob("*.png")}
        self.assertEqual(len(before), 12)
        again = self.run_here(*self.film_arguments())
        self.assertDone(again)
        self.assertIn("0 of 12 frames are to be made", again.err)
        self.assertNotIn("slurm: job", again.err, "something was submitted though all is done")

        (self.frames / "007.png").unlink()
        once = self.run_here(*self.film_arguments())
        self.assertDone(once)
        self.assertIn("1 of 12 frames are to be made", once.err)
        self.assertRegex(once.err, "slurm: job [0-9]+: --array=[0-9]+%4 .*frames.sbatch")
        self.assertEqual(self.contents(self.frames), self.contents(whole))
        after = {p.name: p.stat().st_mtime_ns for p in self.frames.glob("*.png")}
        self.assertEqual({n for n in after if after[n] != before[n]}, {"007.png"})

    def stop_a_render(self, child):
        """Stops (SIGSTOP) a render of frames: it cannot end before its node does.

        @return its node
        """
        stopped = []

        def look():
            for node in self.running("terravox-frames"):
                for pid in self.cluster.children_of_node(node):
                    try:
                        if b"\0animate\0" in pathlib.Path(f"/proc/{pid}/cmdline").read_bytes():
                            os.kill(pid, signal.SIGSTOP)
                            stopped.append(node)
                            return True
                    except OSError:
                        continue
            return False

        self.until(look, "a render", child=child)
        return stopped[0]

    def bring_back(self, node):
        self.cluster.start_node(node)
        self.until(
            lambda: self.cluster.run("sinfo", "-h", "-n", node, "-o", "%T").split() == ["idle"],
            f"node {node}",
            40,
        )

    @only_in_all
    def test_a_signal_cancels_all_and_failed_frames_are_reported(self):
        child = self.start(*self.film_arguments())
        self.until(lambda: self.running("terravox-frames"), "frames at work", child=child)
        child.send_signal(signal.SIGINT)
        self.assertEqual(child.wait(timeout=30), 1)
        self.assertIn("interrupted by a signal; all tasks are cancelled", self.said(child))
        self.until(lambda: not self.cluster.tasks(), "an empty queue", 30)

        # Frames that fail: a folder stands where one is to be written.
        (self.frames / "005.png" / "x").mkdir(parents=True)
        failed = self.run_here(*self.film_arguments())
        self.assertEqual(failed.code, 1, str(failed))
        self.assertIn(
            "missing: the frames/005.png\nterravox: join the frames: 1 are missing\n", failed.err
        )
        self.assertIn("; the same command continues", failed.err)
        self.assertEqual(sum("005.png" in text for text in self.logs().values()), 2, self.logs())

    @only_in_all
    def test_no_wait_returns_and_a_later_call_waits(self):
        done = self.run_here("--no-wait", "--frames", "2-4", *self.film_arguments())
        self.assertDone(done)
        self.assertTrue(self.cluster.tasks(), "nothing was submitted")
        later = self.run_here("--frames", "2-4", *self.film_arguments())
        self.assertDone(later)
        self.assertIn("tasks of an earlier call are at work", later.err)
        self.assertIn("0 of 3 frames are to be made", later.err)
        self.assertEqual(sorted(self.contents(self.frames)), ["002.png", "003.png", "004.png"])

    def test_a_picture_by_workers_of_which_some_die(self):
        look = ["--size", "960x540", "--samples", "16"]
        whole = self.folder / "whole.exr"
        self.assertDone(render(survey(), *look, "--quiet", "-o", whole))
        child = self.start(
            "--folder", "the pool", "--address", "127.0.0.1", survey(), *look, "-o", "picture.exr"
        )
        self.until(lambda: len(self.running("terravox-worker")) == 4, "four workers", child=child)
        self.until(lambda: self.worker_logs(), "the log of a worker", child=child)
        nodes = self.running("terravox-worker")
        workers = [
            pid
            for pid in self.cluster.children_of_node(nodes[0])
            if b"worker" in pathlib.Path(f"/proc/{pid}/cmdline").read_bytes()
        ]
        self.assertTrue(workers)
        for pid in workers:
            os.kill(pid, signal.SIGKILL)
        self.cluster.kill_node(nodes[1])
        self.addCleanup(self.bring_back, nodes[1])
        self.assertIsNone(child.poll(), "the picture was done before a worker was killed")
        self.assertEqual(child.wait(timeout=100), 0, f"{self.said(child)} {self.logs()}")
        self.assertAlike(self.folder / "picture.exr", whole, exact=True)
        self.until(lambda: not self.cluster.tasks(), "cancelled workers", 30)
        self.assertFalse((self.folder / "the pool" / "token").exists(), "the token stays behind")

    def worker_logs(self):
        return [p for p in self.folder.rglob("logs/worker-*") if p.stat().st_size > 0]

    def stand_in(self, come="3", code=0, die=0):
        """Starts a pool whose program is the stand-in.

        @param come the worker whose arrival ends the render
        """
        program = self.folder / "stand in"
        program.write_text(STAND_IN)
        program.chmod(0o755)
        self.cluster.environment.update(
            COME=come, CODE=str(code), DIE=str(die), TOKEN=str(self.folder / "the pool" / "token")
        )
        return ["--program", program, "--folder", "the pool", survey(), "-o", "a.png"]

    def assertNothingLeft(self):
        self.until(lambda: not self.cluster.tasks(), "cancelled workers", 30)
        self.assertFalse((self.folder / "the pool" / "token").exists(), "the token stays behind")

    @only_in_all
    def test_a_pool_ends_with_its_coordinator(self):
        run = self.run_here(*self.stand_in(code=3))
        self.assertEqual(run.code, 3, str(run))
        self.assertRegex(
            run.err, r"slurm: job \d+"
        )  # progress comes every few seconds: this may have been too short for any
        self.assertNothingLeft()
        said = (self.folder / "said-render").read_text()
        self.assertRegex(
            said,
            r"^render .* -o a.png --threads 0 --token-file .*/the pool/token --listen :[0-9]+\n$",
        )
        port = said.rsplit(":", 1)[1].strip()
        self.assertIn(f":{port}", (self.folder / "said-worker").read_text())
        self.assertIn("worker --once --idle-s 600 ", (self.folder / "said-worker").read_text())

    @only_in_all
    def test_a_pool_whose_workers_all_end_is_no_use(self):
        run = self.run_here(*self.stand_in(come="never", die=1))
        self.assertEqual(run.code, 1, str(run))
        self.assertIn(
            (
                "terravox: render with workers of Slurm: all workers ended "
                "before the picture was finished"
            ),
            run.err,
        )
        self.assertTrue((self.folder / "stopped").exists(), "the coordinator was not stopped")
        self.assertNothingLeft()

    @only_in_all
    def test_a_signal_ends_a_pool(self):
        child = self.start(*self.stand_in(come="never"))
        self.until(lambda: self.running("terravox-worker"), "workers", child=child)
        child.send_signal(signal.SIGTERM)
        self.assertEqual(child.wait(timeout=30), 1)
        self.assertIn(
            "interrupted by a signal; the picture is not finished, the workers are cancelled",
            self.said(child),
        )
        self.assertTrue((self.folder / "stopped").exists(), "the coordinator was not stopped")
        self.assertNothingLeft()

    @only_in_all
    def test_a_picture_whose_coordinator_is_a_job(self):
        whole = self.folder / "whole.exr"
        self.assertDone(render(survey(), *FRAMES, "--quiet", "-o", whole))
        # Without threads of its own: what is there, workers have rendered.
        words = ["--coordinator", "job", "--address", "127.0.0.1", "--folder", "the pool"]
        run = self.run_here(*words, survey(), *FRAMES, "--threads", "0", "-o", "picture.exr")
        self.assertEqual(run.code, 0, f"{run} {self.logs()}")
        self.assertAlike(self.folder / "picture.exr", whole, exact=True)
        self.until(lambda: not self.cluster.tasks(), "cancelled workers", 30)

    @only_in_all
    def test_a_picture_in_parts(self):
        whole = self.folder / "whole.exr"
        self.assertDone(render(survey(), *FRAMES, "--quiet", "-o", whole))
        words = ["--batch", "--parts", "5", "--folder", "the parts", survey(), *FRAMES]
        run = self.run_here(*words, "-o", "picture.exr")
        self.assertEqual(run.code, 0, f"{run} {self.logs()}")
        self.assertAlike(self.folder / "picture.exr", whole, exact=True)


class WithoutSlurm(Case):
    def test_a_missing_slurm_is_reported_and_a_dry_run_works(self):
        folder = temporary_folder()
        words = ["--nodes", "2", "--folder", folder / "job", survey(), "-o", folder / "a.png"]
        without = {"PATH": str(folder)}
        self.assertRefused(
            Run([binary("RAYTRACER"), "cluster", "slurm", *words], environment=without),
            1,
            "sbatch is not installed on this machine",
        )
        dry = Run(
            [binary("RAYTRACER"), "cluster", "slurm", "--dry-run", *words], environment=without
        )
        self.assertDone(dry)
        submit = folder / "job" / "submit.sh"
        self.assertEqual(dry.out, f"bash {submit}\n")
        self.assertIn("submit --array=0-1 worker.sbatch", submit.read_text())
        for script in ("submit.sh", "coordinator.sbatch", "worker.sbatch"):
            self.assertEqual(Run(["bash", "-n", folder / "job" / script]).code, 0)

    def test_errors_are_reported_before_anything_is_submitted(self):
        folder = temporary_folder()
        film, target, picture = folder / "a.toml", folder / "%d.png", ("-o", folder / "a.png")
        film.write_text(TURN)
        batch = ("--batch", film, survey(), "-o", target)
        for said, words in {
            "--nodes": [survey(), "--nodes", "2", *picture],  # behind the world
            "no world; allowed": [],
            "unknown option --nodez": ["--nodez", "2", survey()],
            "--frames 3-12; allowed": ["--frames", "3-12", *batch],
            "--first among the arguments": [*batch, "--first", "2"],
            "without --batch": ["--frames", "1", survey(), *picture],
            "without % and \\": ["--folder", folder / "50%", survey(), *picture],
            "options of sbatch on one line": ["--sbatch", "--qos=a\nrm x", survey(), *picture],
            "--parts": ["--batch", "--parts", "1", survey(), *picture],
            "--part": ["--batch", "--parts", "2", survey(), *picture, "--part", "1/2"],
            "none": ["--batch", film, folder / "none", "-o", target],
        }.items():
            with self.subTest(said):
                command = [binary("RAYTRACER"), "cluster", "slurm", "--dry-run", *words]
                self.assertRefused(Run(command, cwd=folder), 2, said)


if __name__ == "__main__":
    unittest.main()

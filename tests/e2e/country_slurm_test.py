#!/usr/bin/env python3
"""A country's array on a real Slurm cluster of four nodes on this machine, of which some fail."""

import os
import pathlib
import re
import signal
import subprocess
import time
import unittest

from slurm import Cluster, why_not
from support import HANGS_S, Case, Run, binary, only_in_all, temporary_folder

REASON = why_not()
SHARDS = 12
OPTIONS = ["--voxel", "0.5"]


@unittest.skipIf(REASON, REASON)
class CountryOnSlurm(Case):
    @classmethod
    def setUpClass(cls):
        cls.survey = temporary_folder() / "survey"
        words = ["--seed", "7", "--squares", "3x3", "--square-m", "256", "--density", "2"]
        run = Run([binary("SURVEY"), *words, "-o", cls.survey])
        assert run.code == 0, run
        whole = temporary_folder() / "whole.tvx"
        run = Run([binary("CONVERT"), cls.survey, whole, *OPTIONS, "--cache", "none"])
        assert run.code == 0, run
        cls.whole = whole.read_bytes()
        cls.cluster = Cluster(temporary_folder())
        cls.cluster.__enter__()
        cls.addClassCleanup(cls.cluster.stop)

    def setUp(self):
        self.folder = temporary_folder()
        self.plan = self.folder / "plan"
        self.out = self.folder / "country.tvx"

    def until(self, done, what):
        deadline = time.monotonic() + HANGS_S
        while not done():
            self.assertLess(
                time.monotonic(),
                deadline,
                f"waited for {what}; queue: {self.cluster.tasks()}; logs: {self.logs()}",
            )
            time.sleep(0.02)

    def logs(self):
        return {p.name: p.read_text(errors="replace")[-1500:] for p in self.plan.rglob("logs/*")}

    def submit(self):
        words = [self.survey, "-o", self.plan, "--shards", SHARDS, "--sample", "2", *OPTIONS]
        words += ["--slurm", self.folder / "go.sh", "--nodes", "4", "--memory-per-task", "600"]
        command = [binary("RAYTRACER"), "country", "plan", *words, "--archive", self.out, "--quiet"]
        self.assertDone(Run(command))
        run = Run(["bash", self.folder / "go.sh"], environment=self.cluster.environment)
        self.assertDone(run)
        return re.search("tasks ([0-9]+), join", run.out)[1]

    def stop_a_task(self):
        """Stops (SIGSTOP) a task: it cannot end before its node does. @return its node"""
        stopped = []

        def look():
            for name in self.cluster.names:
                for pid in self.cluster.children_of_node(name):
                    try:
                        command = pathlib.Path(f"/proc/{pid}/cmdline").read_bytes()
                        if b"\0--task\0" in command:
                            os.kill(pid, signal.SIGSTOP)
                            stopped.append(name)
                            return True
                    except OSError:
                        continue
            return False

        self.until(look, "a task")
        return stopped[0]

    def drain(self, node):
        words = ["scontrol", "update", f"NodeName={node}", "State=DRAIN", "Reason=tried"]
        self.cluster.run(*words)
        self.addCleanup(self.cluster.run, "scontrol", "update", f"NodeName={node}", "State=RESUME")

    def bring_back(self, node):
        self.cluster.start_node(node)
        self.until(
            lambda: self.cluster.run("sinfo", "-h", "-n", node, "-o", "%T").split() == ["idle"],
            f"node {node}",
        )

    def shards(self):
        return {p.name: p.stat().st_mtime_ns for p in (self.plan / "shards").glob("*.tvx")}

    def assertFinished(self, finished):
        """@param finished shards that were done when something happened: they stay as they are"""
        self.until(lambda: not self.cluster.tasks(), "an empty queue")
        self.assertTrue(self.out.exists(), self.logs())
        self.assertEqual(self.out.read_bytes(), self.whole)
        now = self.shards()
        self.assertEqual({name: now.get(name) for name in finished}, finished)

    def test_an_array_finishes_though_a_node_is_drained(self):
        self.submit()
        self.until(lambda: len(self.shards()) > 1, "finished shards")
        finished = self.shards()
        self.drain("n2")
        self.assertFinished(finished)

    # Slurm waits two minutes.
    @only_in_all
    def test_an_array_finishes_though_a_node_dies_and_another_is_drained(self):
        job = self.submit()
        self.until(lambda: len(self.shards()) > 1, "finished shards")
        victim = self.stop_a_task()
        finished = self.shards()
        self.cluster.kill_node(victim)
        self.addCleanup(self.bring_back, victim)
        self.drain(next(name for name in self.cluster.names if name != victim))
        self.assertFinished(finished)
        shown = self.cluster.run("scontrol", "--oneliner", "show", "job", job)
        self.assertIn(" Restarts=1 ", shown, "no task was put back into the queue")
        status = subprocess.run(
            [binary("RAYTRACER"), "country", "status", self.plan],
            capture_output=True,
            text=True,
            check=True,
        )
        self.assertIn(f"{SHARDS} of {SHARDS}", status.stdout)


if __name__ == "__main__":
    unittest.main()

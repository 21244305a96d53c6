#!/usr/bin/env python3
"""The same picture by green threads, threads and socket workers.

Cold and warm, and by workers with a fixed share of a core each, compared with one of those. Prints
one line of JSON.
"""

import argparse
import atexit
import json
import os
import pathlib
import signal
import statistics
import sys
import time

TESTS = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(TESTS / "e2e"), str(TESTS / "bench")]

from support import Program, temporary_folder  # noqa: E402
from surveys import synthetic_survey  # noqa: E402

LIMIT_S = 1800
FOLDER = temporary_folder()
ENVIRONMENT = {
    "TERRAVOX_FARM_TOKEN": "n6cq9wx3tz7kf4vm2rjbh8dy5sg1pk3e",
    "TERRAVOX_FARM_TEST": "1",
    "XDG_CACHE_HOME": str(FOLDER / "cache"),
}
# The kernel ends the programs of a bench that is killed.
WITH_PARENT = ("setpriv", "--pdeathsig", "KILL")
# Begins a program in a control group: $1 is the group's file.
IN_GROUP = ("sh", "-c", 'echo $$ >"$1" && shift && exec "$@"', "sh")
ONE_THREAD = ("--threads", "1", "--quality-coarse-step", "1")

# A bench that is cut off cleans up, too.
signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))


class Group:
    """A control group, version 1 or 2, whose processes have a share of one core. Needs root."""

    _next = 0
    _PERIOD_US = 100_000  # as is usual: a shorter one loses much time to context switches

    def __init__(self, share):
        v1 = pathlib.Path("/sys/fs/cgroup/cpu")
        is_v1 = (v1 / "tasks").exists()
        root = v1 if is_v1 else v1.parent
        if not is_v1:
            (root / "cgroup.subtree_control").write_text("+cpu")
        Group._next += 1
        self.folder = root / f"terravox-bench-{os.getpid()}-{Group._next}"
        self.folder.mkdir()
        quota_us = int(self._PERIOD_US * share)
        if is_v1:
            (self.folder / "cpu.cfs_period_us").write_text(str(self._PERIOD_US))
            (self.folder / "cpu.cfs_quota_us").write_text(str(quota_us))
        else:
            (self.folder / "cpu.max").write_text(f"{quota_us} {self._PERIOD_US}")

    @property
    def prefix(self):
        return (*IN_GROUP, self.folder / "cgroup.procs")


class Worker:
    """A daemon of one thread. @param share of a core; None: no limit"""

    def __init__(self, share=None):
        self._group = Group(share) if share else None
        within = (*WITH_PARENT, *(self._group.prefix if share else ()))
        self._program = Program(
            *("worker", "--listen", "127.0.0.1:0", "--threads", 1),
            environment=ENVIRONMENT,
            within=within,
        )
        atexit.register(self.kill)
        port = self._program.saw(r"on port (\d+)", 60).group(1)
        self.flags = ("--worker", f"127.0.0.1:{port}")

    def kill(self):
        atexit.unregister(self.kill)
        self._program.kill()
        if self._group:
            self._group.folder.rmdir()


def by_workers(workers):
    """@return flags of a render by these workers alone"""
    return ["--threads", "0", *(flag for worker in workers for flag in worker.flags)]


class Scale:
    """The measurements: `figures` by name, and the `pictures`, which must all be the same."""

    def __init__(self, runs):
        self.runs = runs
        self.survey = synthetic_survey(512, 4)
        self.figures = {}
        self.pictures = set()

    def render(self, samples, *flags):
        """A picture whose work is in proportion to `samples`. @return seconds of tracing"""
        picture = FOLDER / f"picture-{time.monotonic_ns()}.png"
        report = picture.with_suffix(".json")
        coordinator = Program(
            *("render", self.survey, "--size", "640x360", "--tile", "32"),
            *("--integrator", "path", "--samples", samples, "--bounces", "4"),
            *("--processing-memory-mib", "512", *flags),
            *("--quiet", "--report", report, "-o", picture),
            environment=ENVIRONMENT,
            within=WITH_PARENT,
        )
        code = coordinator.end(LIMIT_S)
        if code != 0:
            raise RuntimeError(f"render: exit code {code}: {coordinator.log()[-600:]}")
        if samples == 64:
            self.pictures.add(picture.read_bytes())
        stages = json.loads(report.read_text())["stages"]
        return next(s["seconds"] for s in stages if s["name"].startswith("ray tracing"))

    def times(self, name, *flags):
        self.figures[name] = statistics.median(self.render(64, *flags) for _ in range(self.runs))

    def loopback(self):
        """Two workers on this machine compared with two threads."""
        workers = [Worker(), Worker()]
        there = by_workers(workers)
        self.figures["workers_2_cold_s"] = self.render(64, *there)
        local = []
        far = []
        # In turns, so that other load of the machine affects both alike.
        for _ in range(max(self.runs, 3)):
            local.append(self.render(64, "--threads", "2", "--quality-coarse-step", "1"))
            far.append(self.render(64, *there))
        self.figures["threads_2_s"] = statistics.median(local)
        self.figures["workers_2_s"] = statistics.median(far)
        efficiency = statistics.median(a / b for a, b in zip(local, far))
        self.figures["loopback_efficiency"] = efficiency
        for worker in workers:
            worker.kill()

    def shared(self, count, share):
        """Workers with a fixed share of a core each.

        @return work per worker and second, in units of the machine's speed at that time
        """
        workers = [Worker(share) for _ in range(count)]
        took = []
        speeds = []
        for run in range(1 + (self.runs if count > 1 else min(self.runs, 3))):
            # The speed of the machine varies: before each picture a small one on one thread
            # measures it.
            now = self.render(8, *ONE_THREAD)
            far = self.render(64, *by_workers(workers))
            if run > 0:  # boxes have been sent
                took.append(far)
                speeds.append(now / (count * far))
        self.figures[f"shared_{count}_s"] = statistics.median(took)
        for worker in workers:
            worker.kill()
        return statistics.median(speeds)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--share", type=float, default=0.14)
    parser.add_argument("--counts", default="1,2,4,6,12")
    args = parser.parse_args()
    scale = Scale(args.runs)
    scale.times("green_s", "--green")
    scale.times("threads_1_s", *ONE_THREAD)
    scale.loopback()
    base = None
    for count in (int(c) for c in args.counts.split(",")):
        speed = scale.shared(count, args.share)
        base = base or speed
        scale.figures[f"shared_{count}_efficiency"] = speed / base
    scale.figures["pictures"] = len(scale.pictures)
    print(json.dumps(scale.figures), flush=True)


if __name__ == "__main__":
    main()

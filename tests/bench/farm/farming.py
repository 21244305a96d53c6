"""What the farm's benchmarks share: workers with a share of a core each, coordinators, and what they tell."""

import atexit
import json
import os
import pathlib
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "e2e"))

from support import binary, temporary_folder  # noqa: E402

TOKEN = "a-token-of-the-benches-12"
RAYTRACER = binary("RAYTRACER")
ENVIRONMENT = {**os.environ, "TERRAVOX_TOKEN": TOKEN, "TERRAVOX_FARM_TEST": "1"}


FOLDER = temporary_folder()
ENVIRONMENT["XDG_CACHE_HOME"] = str(FOLDER / "cache")


def invented_survey():
    folder = FOLDER / "survey"
    subprocess.run([binary("SURVEY"), "--seed", "7", "--squares", "1x1", "--square-m", "512", "--density", "4", "-o", folder], check=True, capture_output=True)
    return folder


class Share:
    """A share of one core for a process and its children, by control groups (version 1 or 2); as root only."""

    _next = 0

    def __init__(self, share):
        v1 = pathlib.Path("/sys/fs/cgroup/cpu")
        v2 = pathlib.Path("/sys/fs/cgroup")
        Share._next += 1
        name = f"terravox-bench-{os.getpid()}-{Share._next}"
        period_us = 20_000  # short, so that a share is one within a tile, too
        if (v1 / "cpu.cfs_quota_us").exists() or (v1 / "tasks").exists():
            self.folder = v1 / name
            self.folder.mkdir()
            (self.folder / "cpu.cfs_period_us").write_text(str(period_us))
            (self.folder / "cpu.cfs_quota_us").write_text(str(int(period_us * share)))
        elif (v2 / "cgroup.controllers").exists():
            (v2 / "cgroup.subtree_control").write_text("+cpu")
            self.folder = v2 / name
            self.folder.mkdir()
            (self.folder / "cpu.max").write_text(f"{int(period_us * share)} {period_us}")
        else:
            raise OSError("no control groups for CPU time on this machine")
        atexit.register(self.remove)

    def take(self, pid):
        (self.folder / "cgroup.procs").write_text(str(pid))

    def remove(self):
        try:
            self.folder.rmdir()
        except OSError:
            pass


class Worker:
    """A daemon that listens on a port of its own. @param share of a core; None: no limit"""

    def __init__(self, share=None, threads=1):
        self.log = open(FOLDER / f"worker-{time.monotonic_ns()}.log", "w+", encoding="utf-8")
        group = Share(share) if share else None
        self.process = subprocess.Popen([RAYTRACER, "worker", "--listen", "127.0.0.1:0", "--threads", str(threads)], stdout=self.log, stderr=subprocess.STDOUT, env=ENVIRONMENT,
                                        preexec_fn=(lambda: group.take(os.getpid())) if group else None)
        atexit.register(self.kill)
        end = time.monotonic() + 60
        while time.monotonic() < end:
            self.log.seek(0)
            for line in self.log.read().splitlines():
                if " on port " in line:
                    self.address = "127.0.0.1:" + line.rsplit(" ", 1)[1]
                    return
            time.sleep(0.02)
        raise RuntimeError("a worker did not start")

    def kill(self):
        self.process.kill()
        self.process.wait()


class Render:
    """A coordinator. Its report is read when it has ended."""

    def __init__(self, *arguments, share=None):
        self.picture = FOLDER / f"picture-{time.monotonic_ns()}.png"
        self.report = self.picture.with_suffix(".json")
        group = Share(share) if share else None
        self.start = time.monotonic()
        self.process = subprocess.Popen([RAYTRACER, "render", *(str(a) for a in arguments), "--quiet", "--report", self.report, "-o", self.picture], stdout=subprocess.DEVNULL,
                                        stderr=subprocess.PIPE, text=True, env=ENVIRONMENT, preexec_fn=(lambda: group.take(os.getpid())) if group else None)

    def end(self):
        _, err = self.process.communicate(timeout=1800)
        self.wall_s = time.monotonic() - self.start
        if self.process.returncode != 0:
            raise RuntimeError(f"render: exit code {self.process.returncode}: {err.strip()[-300:]}")
        self.told = json.loads(self.report.read_text())
        return self

    @property
    def tracing_s(self):
        return next(s["seconds"] for s in self.told["stages"] if s["name"].startswith("ray tracing"))

    @property
    def bytes(self):
        return self.picture.read_bytes()


def tell(figures):
    print(json.dumps(figures), flush=True)

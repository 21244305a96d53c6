"""Shared parts of the farm benchmarks.

Workers and coordinators, shares of a core, events in their logs with times, and the expected
pictures.
"""

import atexit
import contextlib
import ctypes
import json
import os
import pathlib
import signal
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "e2e"))

from observe import Watch  # noqa: E402
from support import binary, hold_port, temporary_folder  # noqa: E402

TOKEN = "n6cq9wx3tz7kf4vm2rjbh8dy5sg1pk3e"
RAYTRACER = binary("RAYTRACER")
FOLDER = temporary_folder()
ENVIRONMENT = {
    **os.environ,
    "TERRAVOX_FARM_TOKEN": TOKEN,
    "TERRAVOX_FARM_TEST": "1",
    "XDG_CACHE_HOME": str(FOLDER / "cache"),
}
# The defaults of users: longer waits for peers that are silent, late or gone.
DEFAULTS = {**ENVIRONMENT, "TERRAVOX_FARM_TEST": "0"}
_LIBC = ctypes.CDLL(None, use_errno=True)
_PR_SET_PDEATHSIG = 1

# A bench that is cut off cleans up, too. Its children die with it in any case.
signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))

_survey = None


def synthetic_survey():
    global _survey
    if _survey is None:
        _survey = FOLDER / "survey"
        subprocess.run(
            [
                binary("SURVEY"),
                "--seed",
                "7",
                "--squares",
                "1x1",
                "--square-m",
                "512",
                "--density",
                "4",
                "-o",
                _survey,
            ],
            check=True,
            capture_output=True,
        )
    return _survey


def path_scene(samples, size="320x180", tile=16):
    """Work that is in proportion to `samples`: the inputs and flags of a render."""
    return [
        synthetic_survey(),
        "--size",
        size,
        "--tile",
        str(tile),
        "--integrator",
        "path",
        "--samples",
        str(samples),
        "--bounces",
        "4",
    ]


def die_with_parent(*others):
    """For preexec_fn of Popen. Call it on the main thread only.

    The kernel ends a child with the thread that made it.

    @param others called after that, in the child
    """

    def prepare():
        _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
        for other in others:
            other()

    return prepare


class Share:
    """A share of one core for a process and its children.

    Uses control groups, version 1 or 2, and so needs root.
    """

    _next = 0
    _swept = False

    def __init__(self, share):
        v1 = pathlib.Path("/sys/fs/cgroup/cpu")
        v2 = pathlib.Path("/sys/fs/cgroup")
        is_v1 = (v1 / "cpu.cfs_quota_us").exists() or (v1 / "tasks").exists()
        if not is_v1 and not (v2 / "cgroup.controllers").exists():
            raise OSError("no control groups for CPU time on this machine")
        root = v1 if is_v1 else v2
        self._sweep(root)
        Share._next += 1
        self.folder = root / f"terravox-bench-{os.getpid()}-{Share._next}"
        period_us = 100_000  # as is usual: a shorter one loses much time to context switches
        if not is_v1:
            (v2 / "cgroup.subtree_control").write_text("+cpu")
        self.folder.mkdir()
        atexit.register(self.remove)
        if is_v1:
            (self.folder / "cpu.cfs_period_us").write_text(str(period_us))
            (self.folder / "cpu.cfs_quota_us").write_text(str(int(period_us * share)))
        else:
            (self.folder / "cpu.max").write_text(f"{int(period_us * share)} {period_us}")

    @classmethod
    def _sweep(cls, root):
        """Processes that a killed bench left behind."""
        if cls._swept:
            return
        cls._swept = True
        for folder in root.glob("terravox-bench-*-*"):
            if not pathlib.Path("/proc", folder.name.split("-")[2]).exists():
                with contextlib.suppress(OSError):
                    folder.rmdir()

    def take(self, pid):
        (self.folder / "cgroup.procs").write_text(str(pid))

    def remove(self):
        with contextlib.suppress(OSError):
            self.folder.rmdir()


def shares_missing():
    """@return why shares of a core are not available here, or an empty string"""
    if os.geteuid() != 0:
        return "control groups need root"
    try:
        Share(1).remove()
    except OSError as e:
        return f"control groups: {e}"
    return ""


_living = set()


@atexit.register
def kill_all():
    """Ends all programs of the farm that still run."""
    for process in list(_living):
        process.kill()


class Process:
    """A program of the farm.

    @param share  share of a core; None: no limit
    @param within a networks.Namespace
    @param limits called in the child
    """

    def __init__(
        self,
        arguments,
        *,
        share=None,
        environment=ENVIRONMENT,
        within=None,
        program=RAYTRACER,
        limits=(),
    ):
        self.group = Share(share) if share else None
        before = [lambda: self.group.take(os.getpid())] if self.group else []
        self.start = time.monotonic()
        self.process = subprocess.Popen(
            [*(within.prefix if within else ()), program, *(str(a) for a in arguments)],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
            env=environment,
            preexec_fn=die_with_parent(*before, *limits),
        )
        self.watch = Watch(self.process.stderr)
        _living.add(self)

    @property
    def pid(self):
        return self.process.pid

    def kill(self):
        self.process.kill()
        self.process.wait()
        _living.discard(self)
        if self.group:
            self.group.remove()

    def has_ended(self, timeout_s):
        """@return its exit code, or None: it has not"""
        try:
            code = self.process.wait(timeout_s)
        except subprocess.TimeoutExpired:
            return None
        self.watch.join()
        return code

    def status(self):
        """(resident KiB, open descriptors)"""
        text = pathlib.Path(f"/proc/{self.pid}/status").read_text()
        rss_kib = next(
            int(line.split()[1]) for line in text.splitlines() if line.startswith("VmRSS:")
        )
        return rss_kib, len(list(pathlib.Path(f"/proc/{self.pid}/fd").iterdir()))


class Worker(Process):
    """A daemon.

    Without `join` it listens: at a port of its own, or at `port`, which an ended worker had.
    """

    _next = 0

    def __init__(
        self, share=None, threads=1, arguments=(), join=None, host="127.0.0.1", port=0, **options
    ):
        Worker._next += 1
        self.name = f"bench-{Worker._next}"
        if not port and host == "127.0.0.1":
            port = hold_port()  # a killed worker is started again at the same port
        place = ["--join", join] if join else ["--listen", f"{host}:{port}"]
        super().__init__(
            ["worker", *place, "--threads", threads, "--name", self.name, *arguments],
            share=share,
            **options,
        )
        if not join:
            self.port = int(self.watch.saw(r"on port (\d+)", 60)[1].group(1))
            self.address = f"{host}:{self.port}"


class Render(Process):
    """A coordinator. Its report is read when it has ended.

    @param log log level; debug: with leases and answers
    """

    def __init__(self, *arguments, log="error", picture=None, **options):
        self.picture = picture or FOLDER / f"picture-{time.monotonic_ns()}.png"
        self.report = self.picture.with_suffix(".json")
        said = ["--quiet"] if log == "error" else ["--log", log]  # quiet: no progress either
        super().__init__(
            ["render", *arguments, *said, "--report", self.report, "-o", self.picture], **options
        )

    def end(self, timeout_s=1800):
        code = self.has_ended(timeout_s)
        self.wall_s = time.monotonic() - self.start
        if code != 0:
            raise RuntimeError(f"render: exit code {code}: {self.watch.text()[-600:]}")
        self.results = json.loads(self.report.read_text())
        return self

    @property
    def farm(self):
        return self.results["farm"]

    @property
    def tracing_s(self):
        return next(
            s["seconds"] for s in self.results["stages"] if s["name"].startswith("ray tracing")
        )

    @property
    def bytes(self):
        return self.picture.read_bytes()


_wanted = {}


def wanted(scene):
    """The picture of a scene as threads of one process make it; made once."""
    key = " ".join(str(a) for a in scene)
    if key not in _wanted:
        _wanted[key] = Render(*scene, "--threads", "2").end().bytes
    return _wanted[key]


def of(workers):
    """Flags of a coordinator that has these workers alone."""
    return ["--threads", "0", *(a for w in workers for a in ("--worker", w.address))]


def print_figures(figures):
    """Prints one line of JSON, which has no infinity: an event that never came is a billion."""
    finite = {
        name: min(value, 1e9) if isinstance(value, float) else value
        for name, value in figures.items()
    }
    print(json.dumps(finite, allow_nan=False), flush=True)

"""Shared parts of the end-to-end tests: binaries, a small synthetic survey, results of runs."""

import atexit
import functools
import hashlib
import http.client
import json
import os
import pathlib
import re
import resource
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SHARED = ROOT.parent / "shared" / "data"
GOLDEN = ROOT / "tests" / "fixtures" / "golden"
# Whether a test that sweeps over many values takes all of them, as `./terravox test --all` does.
THOROUGH = os.environ.get("TERRAVOX_TIER") == "all"
# Timeout that ends a test that hangs. No test measures time: a busy machine may need minutes for
# what takes a moment elsewhere.
HANGS_S = 600


def binary(name):
    path = os.environ.get("TERRAVOX_" + name)
    if not path:
        sys.exit(f"TERRAVOX_{name} is not set; run these tests with ctest")
    return path


def only_in_all(test):
    """Marks a test, or a class of them, that `./terravox test` leaves to `--all`."""
    test.only_in_all = True
    return test


def has_sanitizers():
    """Whether ctest runs programs that a sanitizer gives more memory than they ask for."""
    return "ASAN_OPTIONS" in os.environ or "TSAN_OPTIONS" in os.environ


def temporary_folder():
    folder = pathlib.Path(tempfile.mkdtemp(prefix="terravox-e2e-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


# Squares that these tests prepare must not be found by later runs, nor by the user of this machine.
os.environ["XDG_CACHE_HOME"] = str(temporary_folder())


def wait_until(condition, what, pause_s=0.005):
    """Waits until a condition holds.

    @param what    names the condition in the error
    @param pause_s between two checks
    @throws AssertionError after HANGS_S
    """
    end = time.monotonic() + HANGS_S
    while not condition():
        if time.monotonic() > end:
            raise AssertionError(f"waited in vain: {what}")
        time.sleep(pause_s)


_held_ports = []


def hold_port():
    """@return a port of 127.0.0.1 for a program that cannot choose a free one itself and report it

    Until this process ends no other program gets the port by chance. A socket is bound to it that
    never listens: connections are refused, and the kernel does not choose the port for others. A
    program that names the port can still listen there, since servers set SO_REUSEADDR, as this
    socket does.
    """
    holder = socket.socket()
    holder.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    holder.bind(("127.0.0.1", 0))
    _held_ports.append(holder)
    return holder.getsockname()[1]


class Run:
    """A program that has ended."""

    def __init__(
        self, arguments, cwd=None, limits=(), timeout_s=HANGS_S, environment=None, within=()
    ):
        """@param limits (resource of setrlimit, value) @param within a command that runs others"""

        def limit():
            for which, value in limits:
                resource.setrlimit(which, (value, value))

        # restore_signals=False: Python ignores SIGXFSZ, and so does the child then: its writes fail
        # with EFBIG, as on a full disk.
        done = subprocess.run(
            [str(a) for a in [*within, *arguments]],
            cwd=cwd,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=timeout_s,
            preexec_fn=limit,
            restore_signals=False,
            check=False,
            env={**os.environ, **(environment or {})},
        )
        self.code = done.returncode
        self.out = done.stdout
        self.err = done.stderr
        self.last = (self.err.strip().splitlines() or [""])[-1]

    def __str__(self):
        return f"exit code {self.code}\n--- stdout\n{self.out}\n--- stderr\n{self.err}"

    def done(self):
        """@return itself @throws AssertionError unless it has succeeded"""
        if self.code != 0:
            raise AssertionError(str(self))
        return self


def make(program, *words, **options):
    """Runs a program that must succeed, as tests prepare what they need. @return the Run"""
    return Run([binary(program), *words], **options).done()


def run_page_tests(**environment):
    """Runs the tests of the web page that these variables choose (tests/page/run.mjs)."""
    words = [os.environ["TERRAVOX_NODE"], ROOT / "tests" / "page" / "run.mjs"]
    return Run(words, environment=environment, timeout_s=4 * HANGS_S)


def make_survey(folder, squares, square_m, density, *options):
    """@return the folder"""
    words = ["--seed", "7", "--squares", squares, "--square-m", square_m, "--density", density]
    make("SURVEY", *words, *options, "-o", folder)
    return folder


def secret_file(text):
    """@return a file of a secret that its user alone may read"""
    file = temporary_folder() / "secret"
    file.touch(mode=0o600)
    file.write_text(text + "\n")
    return file


def render(*arguments, **options):
    return Run([binary("RAYTRACER"), "render", *arguments], **options)


def compare(a, b, exact=False):
    return Run([binary("COMPARE"), *(["--exact"] if exact else []), a, b])


@functools.cache
def survey():
    """A folder with one square of 256 m; made once."""
    return make_survey(temporary_folder() / "survey", "1x1", 256, 4)


def prints_of(folder):
    """@return the names of a folder's squares and checksums of their bytes, which tell whether what
    was made of them before can be taken again"""
    squares = sorted(folder.glob("*.laz"))
    return [(file.name, hashlib.sha256(file.read_bytes()).digest()) for file in squares]


def square():
    return next(survey().glob("*.laz"))


class Server:
    """terravox-voxelserver on a port of its own, or on one of hold_port().

    @param program a command that runs the server, for tests that wrap it
    """

    def __init__(self, *arguments, program=(), port=0):
        # A file, since a full pipe would block the server; end() closes it.
        self._log = tempfile.TemporaryFile("w+", errors="replace")  # noqa: SIM115
        self.process = subprocess.Popen(
            [*program, binary("VOXELSERVER"), *map(str, arguments), "--port", str(port)],
            stdout=subprocess.PIPE,
            stderr=self._log,
            text=True,
        )
        line = self.process.stdout.readline()
        if not line.startswith(("listening on http://", "listening on https://")):
            self.process.kill()
            raise AssertionError(f"the server said '{line}', then {self.end()}: {self.err}")
        self.url = line.split()[-1]
        self.port = int(self.url.rsplit(":", 1)[1])

    def end(self, timeout_s=HANGS_S):
        """Waits for its end. @return the exit code"""
        self.process.wait(timeout=timeout_s)
        # Not communicate(): it forgets what readline() has read beyond the first line.
        self.out = self.process.stdout.read()
        self.process.stdout.close()
        self._log.seek(0)
        self.err = self._log.read()
        self._log.close()
        return self.process.returncode

    def __enter__(self):
        return self

    def __exit__(self, *_):
        """Where it does not end well, neither does the block."""
        if self.stop() != 0:
            raise AssertionError(f"the server has ended with {self.process.returncode}: {self.err}")

    def stop(self, timeout_s=HANGS_S):
        """Ends it by SIGTERM. @return the exit code"""
        self.process.send_signal(signal.SIGTERM)
        return self.end(timeout_s)

    def kill(self):
        self.process.kill()
        return self.end()

    def get(self, path, headers=None, timeout_s=HANGS_S):
        """One request on a connection of its own. @return status, headers, body"""
        return self._ask("GET", path, None, headers, timeout_s)

    def post(self, path, body, headers=None, timeout_s=HANGS_S):
        return self._ask("POST", path, body, headers, timeout_s)

    def _ask(self, method, path, body, headers, timeout_s):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=timeout_s)
        try:
            connection.request(method, path, body=body, headers=headers or {})
            reply = connection.getresponse()
            return reply.status, reply.headers, reply.read()
        finally:
            connection.close()

    def json(self, path):
        status, _, body = self.get(path)
        if status != 200:
            raise AssertionError(f"{path}: {status} {body[:200]}")
        return json.loads(body)

    def memory_kib(self, what="VmRSS"):
        """Resident memory now, or its peak: VmHWM."""
        for line in pathlib.Path(f"/proc/{self.process.pid}/status").read_text().splitlines():
            if line.startswith(what + ":"):
                return int(line.split()[1])
        raise AssertionError(f"no {what} of process {self.process.pid}")

    def box_paths(self, level=0, bounds=None):
        """The addresses of all boxes of a level that may hold anything."""
        bounds = bounds or self.json("/v2/world")["bounds"]
        side = 64 << level
        out = []
        for bz in range(bounds["min"][2] // side, (bounds["max"][2] - 1) // side + 1):
            for bx in range(bounds["min"][0] // side, (bounds["max"][0] - 1) // side + 1):
                column = self.json(f"/v2/columns/{level}/{bx}/{bz}")
                out += [
                    f"/v2/boxes/{level}/{bx}/{by}/{bz}"
                    for by in range(column["by_begin"], column["by_end"])
                ]
        return out


FARM_TOKEN = "kv7r2mx9q4tz8wpd5hcnb3fj6gy1ks7a"


class Program:
    """A program that runs on; its log is read as it comes."""

    def __init__(
        self, *arguments, environment=None, within=(), program="RAYTRACER", cwd=None, test=None
    ):
        """@param within a command that runs others somewhere @param program as binary() has it
        @param test that ends it, unless it has ended before
        """
        self.process = subprocess.Popen(
            [*within, binary(program), *(str(a) for a in arguments)],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            env={**os.environ, **(environment or {})},
            cwd=cwd,
        )
        self.lines = []
        self.changed = threading.Condition()
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()
        if test is not None:
            test.addCleanup(self.process.stdout.close)
            test.addCleanup(self.kill)

    def port(self):
        """@return of this machine, once it listens there"""
        return int(self.saw(r"on port (\d+)")[1])

    def address(self):
        return f"127.0.0.1:{self.port()}"

    def _read(self):
        for line in self.process.stdout:
            with self.changed:
                self.lines.append(line.rstrip("\n"))
                self.changed.notify_all()
        with self.changed:
            self.lines.append(None)
            self.changed.notify_all()

    def saw(self, pattern, timeout_s=HANGS_S, times=1, after=0):
        """Waits for a line, or for so many of them. Returns the last match.

        @param after how many lines of the log do not count
        """
        end = time.monotonic() + timeout_s
        found = []
        with self.changed:
            while True:
                # Each line is searched once: the logs of some tests have ten thousands.
                new = self.lines[after:]
                after += len(new)
                found += filter(None, (re.search(pattern, line or "") for line in new))
                if len(found) >= times:
                    return found[times - 1]
                left = end - time.monotonic()
                if left <= 0 or (self.lines and self.lines[-1] is None):
                    raise AssertionError(f"no line with {pattern!r} in\n{self.log()}")
                self.changed.wait(left)

    def log(self):
        return "\n".join(line for line in self.lines if line is not None)

    def end(self, timeout_s=HANGS_S):
        code = self.process.wait(timeout_s)
        self.reader.join(HANGS_S)
        return code

    def kill(self):
        self.process.kill()
        self.process.wait()


def entries(folder):
    """Passes over folders that go while they are listed."""
    found = []
    for path, folders, files in os.walk(folder):
        place = pathlib.Path(path).relative_to(folder)
        found += [str(place / name) for name in folders + files]
    return sorted(found)


class Case(unittest.TestCase):
    longMessage = True

    def assertDone(self, run):
        self.assertEqual(run.code, 0, str(run))

    def assertRefused(self, run, code, *said):
        """One line on standard error that begins with the program's name."""
        self.assertEqual(run.code, code, str(run))
        lines = run.err.splitlines()
        self.assertEqual(len(lines), 1, str(run))
        self.assertTrue(lines[0].startswith("terravox: "), str(run))
        for part in said:
            self.assertIn(part, lines[0])

    def assertAlike(self, a, b, exact=False):
        run = compare(a, b, exact)
        self.assertEqual(run.code, 0, f"{a} and {b}: {run.out}")

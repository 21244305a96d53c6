"""What the end-to-end tests share: the binaries, a small invented survey, and how a run went."""

import atexit
import os
import pathlib
import resource
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SHARED = ROOT.parent / "shared" / "data"
GOLDEN = ROOT / "tests" / "fixtures" / "golden"


def binary(name):
    path = os.environ.get("TERRAVOX_" + name)
    if not path:
        sys.exit(f"TERRAVOX_{name} is not set; run these tests with ctest")
    return path


def temporary_folder():
    folder = pathlib.Path(tempfile.mkdtemp(prefix="terravox-e2e-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


# Prepared squares of these tests must not be found by the next ones, nor by the person at this machine.
os.environ["XDG_CACHE_HOME"] = str(temporary_folder())


class Run:
    """A program that has ended."""

    def __init__(self, arguments, cwd=None, file_bytes=None, timeout_s=100):
        def limit():
            if file_bytes is not None:
                resource.setrlimit(resource.RLIMIT_FSIZE, (file_bytes, file_bytes))

        # restore_signals=False: Python ignores SIGXFSZ, and so does the child then: its writes fail with EFBIG, as on a full disk.
        done = subprocess.run([str(a) for a in arguments], cwd=cwd, capture_output=True, text=True, errors="replace", timeout=timeout_s,
                              preexec_fn=limit, restore_signals=False, check=False)
        self.code, self.out, self.err = done.returncode, done.stdout, done.stderr

    def __str__(self):
        return f"exit code {self.code}\n--- stdout\n{self.out}\n--- stderr\n{self.err}"


def render(*arguments, **options):
    return Run([binary("RAYTRACER"), "render", *arguments], **options)


def compare(a, b, exact=False):
    return Run([binary("COMPARE"), *(["--exact"] if exact else []), a, b])


_survey = None


def survey():
    """A folder with one square of 256 m; made once."""
    global _survey
    if _survey is None:
        folder = temporary_folder() / "survey"
        run = Run([binary("SURVEY"), "--seed", "7", "--squares", "1x1", "--square-m", "256", "--density", "4", "-o", folder])
        if run.code != 0:
            raise AssertionError(f"terravox-survey: {run}")
        _survey = folder
    return _survey


def square():
    return next(survey().glob("*.laz"))


def entries(folder):
    return sorted(str(p.relative_to(folder)) for p in pathlib.Path(folder).rglob("*"))


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

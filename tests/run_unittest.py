#!/usr/bin/env python3
"""Runs a file of Python tests as CTest does: what it leaves out is not taken for passed.

    python3 tests/run_unittest.py [--tier default|all] tests/e2e/front_test.py [-k pattern...]

With --tier all the tests run that only_in_all of tests/e2e/support.py marks, or that are in a class
that it marks; with --tier default the others; without it all of them.

Each skipped test is written to the file that TERRAVOX_SKIPS names, where it names one, for
config/setup/test_tools.sh. The exit code is 77 where tests were skipped and none ran.
"""

import os
import pathlib
import runpy
import sys
import unittest

SKIPPED = 77  # SKIP_RETURN_CODE of CTest


class Result(unittest.TextTestResult):
    ran = 0
    skips = 0

    def addSuccess(self, test):
        super().addSuccess(test)
        Result.ran += 1

    def addExpectedFailure(self, test, err):
        super().addExpectedFailure(test, err)
        Result.ran += 1

    def addSkip(self, test, reason):
        super().addSkip(test, reason)
        Result.skips += 1
        write_down(pathlib.Path(sys.argv[0]).stem, test.id().removeprefix("__main__."), reason)


def write_down(*columns):
    name = os.environ.get("TERRAVOX_SKIPS")
    if not name:
        return
    line = "\t".join(" ".join(column.split()) for column in columns)
    # One write, so that lines of tests that run at the same time do not mix.
    file = os.open(name, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o666)
    os.write(file, f"{line}\n".encode(errors="replace"))
    os.close(file)


class Loader(unittest.TestLoader):
    """Of one tier."""

    tier = None

    def getTestCaseNames(self, testCaseClass):
        names = super().getTestCaseNames(testCaseClass)
        if Loader.tier is None:
            return names
        wanted = Loader.tier == "all"
        return [name for name in names if is_only_in_all(testCaseClass, name) == wanted]


def is_only_in_all(case, name):
    return getattr(case, "only_in_all", False) or getattr(getattr(case, name), "only_in_all", False)


def main():
    sys.argv = sys.argv[1:]
    if sys.argv[0] == "--tier":
        Loader.tier = sys.argv[1]
        sys.argv = sys.argv[2:]
    file = pathlib.Path(sys.argv[0]).resolve()
    # As where the file itself is called.
    sys.path[0] = str(file.parent)
    unittest.TextTestRunner.resultclass = Result
    # The default of unittest.main().
    unittest.defaultTestLoader.__class__ = Loader
    try:
        runpy.run_path(str(file), run_name="__main__")
    except SystemExit as end:
        if end.code or Result.ran or not Result.skips:
            raise
        sys.exit(SKIPPED)


if __name__ == "__main__":
    main()

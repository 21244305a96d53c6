#!/usr/bin/env python3
"""Faults of the machine: full disk, no descriptors, no memory, EINTR, a clock that jumps.

Whatever happens, a program ends with an exit code of its own and a line with the reason, never by a
signal; no partial file appears under the requested name; and complete files have the same bytes as
without faults. With ./terravox test --all the sweeps have more steps. docs/reliability.md lists
what is covered where.
"""

import contextlib
import itertools
import pathlib
import signal
import subprocess
import threading
import time
import unittest

from support import FARM_TOKEN, THOROUGH, Program, Server, binary, has_sanitizers, temporary_folder
from writers import WRITERS, Writers, ended

FAKETIME = next(pathlib.Path("/usr/lib").glob("*/faketime/libfaketimeMT.so.1"), None)


def least_address_space(program, among):
    """@return the smallest tried limit with which the program's libraries load

    Failures before main() are outside this project.
    """
    for value in among:
        if all(ended([program, "--version"], "address space", value).code == 0 for _ in range(3)):
            return value
    raise AssertionError(f"{program} does not start with {among[-1]} bytes")


class Faults(Writers):
    def test_a_file_that_may_not_grow_is_reported_and_left_half_written_nowhere(self):
        """As on a full disk, which full_disk_test.py has where a machine allows it."""
        for name in WRITERS:
            with self.subTest(name):
                limit = self.whole(name).stat().st_size // 2
                arguments, out = self.writer(name)
                run = ended(arguments, "file size", limit)
                self.assertEqual(run.code, 1, str(run))
                self.assert_told(run, name)
                self.assertIn(str(out), run.last)
                self.assert_nothing_half_written(name, run, out)

    @unittest.skipIf(has_sanitizers(), "a sanitizer asks through a pipe what memory may be read")
    def test_too_few_descriptors_are_reported(self):
        for name in (
            WRITERS if THOROUGH else ("render to EXR", "archive", "glTF", "synthetic survey")
        ):
            for value in range(3, 40) if THOROUGH else (3, 5, 6, 8, 11, 16, 24):
                with self.subTest(name, descriptors=value):
                    arguments, out = self.writer(name)
                    run = ended(arguments, "descriptors", value)
                    if run.code == 127:
                        continue  # the loader found no descriptor for a library
                    self.assert_told(run, name)
                    self.assert_nothing_half_written(name, run, out)

    @unittest.skipIf(has_sanitizers(), "the address sanitizer reserves terabytes of addresses")
    def test_too_little_memory_is_reported(self):
        mib = 1 << 20
        least = {}
        for name in (
            WRITERS if THOROUGH else ("render to EXR", "archive", "OpenVDB", "synthetic survey")
        ):
            program = binary(WRITERS[name].program)
            if program not in least:
                least[program] = least_address_space(program, range(100 * mib, 3000 * mib, 8 * mib))
            for more in range(0, 400, 4) if THOROUGH else (0, 12, 16, 40, 80, 140):
                with self.subTest(name, more_mib=more):
                    arguments, out = self.writer(name)
                    run = ended(arguments, "address space", least[program] + more * mib)
                    if run.code == 127:
                        # It went on as another program (exec), whose libraries did not fit.
                        self.assertLess(more, 300, str(run))
                        continue
                    self.assert_told(run, name)
                    # Where no code can catch an error, nothing clears up.
                    self.assert_nothing_half_written(name, run, out, hidden=["*.part-*"])

    def test_calls_that_are_interrupted_go_on(self):
        # A process that is stopped and continued gets EINTR from most waiting calls, although it
        # has no handler.
        for name in ("render to PNG", "archive"):
            with self.subTest(name):
                self.whole(name)
                arguments, out = self.writer(name)
                process = subprocess.Popen(
                    [str(a) for a in arguments],
                    stdout=subprocess.DEVNULL,
                    stderr=subprocess.PIPE,
                    text=True,
                )
                while process.poll() is None:
                    process.send_signal(signal.SIGSTOP)
                    process.send_signal(signal.SIGCONT)
                    time.sleep(0.002)
                self.assertEqual(process.returncode, 0, process.stderr.read())
                process.stderr.close()
                self.assert_as_on_a_good_day(name, out)

    def test_a_server_with_a_full_cache_disk_still_serves(self):
        # Its cache is a database, limited with the whole process to what the start takes.
        program = ("prlimit", f"--fsize={64 << 10}")
        server = Server(self.data, "--cache", temporary_folder(), program=program)
        with contextlib.ExitStack() as stack:
            stack.callback(server.kill)
            paths = server.box_paths()
            statuses = {server.get(path)[0] for path in paths}
            stack.pop_all()
            code = server.stop()
        self.assertLessEqual(statuses, {200, 204})
        self.assertIn(200, statuses)
        self.assertEqual(code, 0, server.err)

    @unittest.skipIf(has_sanitizers(), "a sanitizer has to be the first library that is loaded")
    @unittest.skipUnless(FAKETIME, "libfaketime (Debian package faketime) is missing")
    def test_a_clock_that_jumps_changes_no_picture(self):
        name = "render to PNG"
        self.whole(name)
        stamp = self.folder / "clock"
        stamp.write_text("+0")
        clock = {
            "LD_PRELOAD": str(FAKETIME),
            "FAKETIME_TIMESTAMP_FILE": str(stamp),
            "FAKETIME_NO_CACHE": "1",
            "DONT_FAKE_MONOTONIC": "1",
            "NO_FAKE_STAT": "1",
        }
        over = threading.Event()

        def jump():
            for offset in itertools.cycle(("+1d", "-1d", "+400d", "+0", "-1h")):
                part = stamp.with_suffix(".new")
                part.write_text(offset)
                part.rename(stamp)
                if over.wait(0.05):
                    return

        jumping = threading.Thread(target=jump)
        with contextlib.ExitStack() as stack:
            jumping.start()
            stack.callback(jumping.join)
            stack.callback(over.set)
            environment = {**clock, "TERRAVOX_FARM_TOKEN": FARM_TOKEN}
            words = ["worker", "--listen", "127.0.0.1:0"]
            worker = Program(*words, environment=environment, test=self)
            arguments, out = self.writer(name)
            arguments[arguments.index("--threads") + 1] = "0"
            run = ended([*arguments, "--worker", worker.address()], environment=environment)
        self.assertEqual(run.code, 0, f"{run}\nworker:\n{worker.log()}")
        self.assert_as_on_a_good_day(name, out)


if __name__ == "__main__":
    unittest.main()

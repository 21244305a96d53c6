#!/usr/bin/env python3
"""The shared parts of the end-to-end tests."""

import os
import select
import signal
import socket
import subprocess
import sys
import unittest

from support import HANGS_S, ROOT, Case, Run, Server, hold_port, survey, temporary_folder

ALL_SKIPPED = 77
TESTS = """
import os, sys, unittest

class Some(unittest.TestCase):
    @unittest.skipIf("nginx" in sys.argv, "no  nginx\\nhere")
    def test_front(self):
        for name in ("a", "b"):
            with self.subTest(name):
                if name == "b" and "b" in sys.argv:
                    self.skipTest("no b")
                self.assertNotIn("fails", sys.argv)

    def test_imports_what_lies_beside_it(self):
        if "other" in sys.argv:
            self.skipTest("no other")
        import beside

unittest.main(argv=sys.argv[:1])
"""


class HeldPort(Case):
    def test_a_program_that_names_it_listens_there_again_and_again(self):
        port = hold_port()
        with self.assertRaises(ConnectionRefusedError):
            socket.create_connection(("127.0.0.1", port))
        for _ in range(2):
            server = Server(survey(), port=port)
            self.assertEqual(server.port, port)
            self.assertEqual(server.get("/healthz")[0], 200)
            server.kill()


class Skips(Case):
    """What is skipped is neither taken for passed nor forgotten (tests/run_unittest.py)."""

    def setUp(self):
        super().setUp()
        self.folder = temporary_folder()
        (self.folder / "some_test.py").write_text(TESTS)
        (self.folder / "beside.py").write_text("")
        self.list = self.folder / "skipped.txt"

    def run_tests(self, *words):
        runner = ROOT / "tests" / "run_unittest.py"
        return Run(
            [sys.executable, "-B", runner, self.folder / "some_test.py", *words],
            environment={"TERRAVOX_SKIPS": str(self.list)},
        )

    def test_the_exit_code_tells_whether_anything_ran(self):
        for words, code, lines in (
            ((), 0, 0),
            (("b",), 0, 1),
            (("nginx", "other"), ALL_SKIPPED, 2),
            (("fails", "other"), 1, 1),
        ):
            with self.subTest(words):
                self.list.unlink(missing_ok=True)
                run = self.run_tests(*words)
                self.assertEqual(run.code, code, run)
                found = self.list.read_text().splitlines() if self.list.exists() else []
                self.assertEqual(len(found), lines, found)

    def test_each_is_written_down_with_its_reason(self):
        self.run_tests("nginx", "b")
        self.run_tests("b")
        self.assertEqual(
            self.list.read_text(),
            "some_test\tSome.test_front\tno nginx here\nsome_test\tSome.test_front [b]\tno b\n",
        )

    def report(self):
        script = (
            'ROOT=$1 LOGS=$2; . "$1/config/setup/say.sh"; . "$1/config/setup/test_tools.sh"; '
            'count_skips; cat "$3" >"$TERRAVOX_SKIPS"; exit 3'
        )
        return Run(["bash", "-c", script, "report", ROOT, self.folder / "logs", self.list])

    def test_they_are_listed_by_reason_at_the_end_however_it_comes(self):
        self.list.write_text(
            "front_test\tFront.test_b\tno nginx\n"
            "slurm_test\tSlurm.test_a\tno Slurm\n"
            "front_test\tFront.test_a\tno nginx\n"
            "front_test\tFront.test_a\tno nginx\n"
        )
        run = self.report()
        self.assertEqual(run.code, 3)
        self.assertEqual(
            run.err,
            "Skipped tests: 3\n"
            "  no Slurm\n"
            "    slurm_test: Slurm.test_a\n"
            "  no nginx\n"
            "    front_test: Front.test_a\n"
            "    front_test: Front.test_b\n",
        )
        self.list.write_text("")
        self.assertEqual(self.report().err, "")


SETUP = "set -euo pipefail; shopt -s inherit_errexit; ROOT=$1 LOGS=$1/logs; "
SETUP += f'for part in say build; do . "{ROOT}/config/setup/$part.sh"; done; PROGRESS_S=0.05; '
# Stand for CMake: everything has been built, or 5 of 12 steps until the file `go` is there.
LOCKED = "2 s: Waiting for the lock... 2s"
NOTHING_TO_DO = "compile() { echo ninja: no work to do.; }; "
SOME_STEPS = """
compile() {
    [[ $* != *-n* ]] || return 0
    printf '[%d/12] Building CXX object\\n' 1 2 3 4 5
    until [[ -e $ROOT/go ]]; do sleep 0.02; done
}
"""


class Script:
    """Functions of ./terravox at work, in a folder that stands for the checkout."""

    def __init__(self, folder, script, terminal=False):
        self.read, write = os.openpty() if terminal else os.pipe()
        self.process = subprocess.Popen(
            ["bash", "-c", SETUP + script, "script", folder], stderr=write, start_new_session=True
        )
        os.close(write)
        self.said = ""

    def saw(self, words):
        """Waits until it has said them."""
        while words not in self.said:
            if not select.select([self.read], [], [], HANGS_S)[0] or not self._more():
                raise AssertionError(f"no {words!r} in {self.said!r}")

    def _more(self):
        try:
            data = os.read(self.read, 4096)
        except OSError:  # a terminal that nobody holds any more
            return False
        self.said += data.decode()
        return bool(data)

    def end(self):
        """@return its exit code, once it has closed its output"""
        while self._more():
            pass
        os.close(self.read)
        return self.process.wait(HANGS_S)


class Builds(Case):
    """What ./terravox says while it builds, and when it waits (config/setup/build.sh)."""

    def setUp(self):
        super().setUp()
        self.folder = temporary_folder()
        (self.folder / "build" / "release").mkdir(parents=True)
        (self.folder / "build" / "release" / "build.ninja").touch()
        (self.folder / "common").mkdir()
        self.source = self.folder / "common" / "a.cpp"
        self.source.touch()

    def run_script(self, script):
        started = Script(self.folder, script)
        code = started.end()
        return code, started.said

    def test_progress_is_steps_or_the_last_line(self):
        for log, seconds, said in (
            ("Get:1 package\n\n", 130, "2 min: Get:1 package"),
            ("one\ntwo \x1b\tand more\r\n", 5, "5 s: two \tand more"),
            ("[1/9] A\n[3/12] B\nwarning: C\n", 30, "3 of 12 steps, 30 s, about 90 s left"),
            ("[0009/1200] A\n", 60, "9 of 1200 steps, 60 s, about 132 min left"),
            ("see [3/12]\n", 1, "1 s: see [3/12]"),
            ("\rWaiting for the lock... 1s\rWaiting for the lock... 2s", 2, LOCKED),
        ):
            with self.subTest(log):
                (self.folder / "log").write_text(log)
                code, out = self.run_script(f'progress "$1/log" {seconds} >&2')
                self.assertEqual((code, out), (0, said + "\n"))

    def test_a_build_tells_how_far_it_is(self):
        for terminal in (False, True):
            with self.subTest(terminal=terminal):
                started = Script(self.folder, SOME_STEPS + "build release", terminal)
                started.saw("5 of 12 steps, ")
                self.assertIn("Building (release)", started.said)
                (self.folder / "go").touch()
                self.assertEqual(started.end(), 0)
                (self.folder / "go").unlink()
                lines = started.said.split("\n")
                # A terminal has one line, which is empty at the end.
                self.assertEqual(len(lines) == 2, terminal, lines)
                self.assertTrue(not terminal or lines[1].endswith("\r\x1b[K"), lines)

    def test_a_command_that_fails_shows_its_output(self):
        script = "work() { echo word; return 3; }; quietly $1/log work"
        code, said = self.run_script(script)
        self.assertEqual(code, 3)
        self.assertIn("word\nterravox: failed with exit code 3: work\n", said)

    def test_a_second_one_says_whom_it_waits_for(self):
        holder = Script(self.folder, SOME_STEPS + "build release")
        holder.saw("5 of 12")
        other = Script(self.folder, SOME_STEPS + "build release; echo built >&2")
        other.saw(f"Waiting for another ./terravox (process {holder.process.pid})\n")
        (self.folder / "go").touch()
        self.assertEqual(holder.end(), 0)
        other.saw("built")
        self.assertEqual(other.end(), 0)

    def test_what_is_up_to_date_does_not_wait(self):
        self.assertEqual(self.run_script(NOTHING_TO_DO + "build release terravox-laz"), (0, ""))
        holder = Script(self.folder, SOME_STEPS + "build release")
        holder.saw("5 of 12")
        again = "build release terravox-laz; echo runs >&2"
        self.assertEqual(self.run_script(again), (0, "runs\n"))
        for words in ("build release terravox-view", "build release", "build asan terravox-laz"):
            with self.subTest(words):
                self.assert_waits(words)
        newer = (self.folder / "build" / "release" / ".built-terravox-laz").stat().st_mtime + 1
        os.utime(self.source, (newer, newer))
        self.assert_waits(again)
        (self.folder / "go").touch()
        self.assertEqual(holder.end(), 0)

    def assert_waits(self, script):
        started = Script(self.folder, script)
        started.saw("Waiting for another")
        os.killpg(started.process.pid, signal.SIGKILL)
        started.end()

    def test_a_failed_build_is_not_up_to_date(self):
        script = "compile() { [[ $* == *-n* ]]; }; "
        for words in ("build release", "build release || exit 4"):
            code, said = self.run_script(script + words)
            self.assertNotEqual(code, 0, said)
            self.assertIn("failed with exit code 1: compile", said)
        self.assertFalse((self.folder / "build" / "release" / ".built-all").exists())


if __name__ == "__main__":
    unittest.main()

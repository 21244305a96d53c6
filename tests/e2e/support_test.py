#!/usr/bin/env python3
"""The shared parts of the end-to-end tests."""

import contextlib
import errno
import socket
import struct
import sys
import unittest

from support import ROOT, Case, Run, Server, hold_port, survey, temporary_folder

IP_LOCAL_PORT_RANGE = 51  # linux/in.h
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
    def test_no_program_listens_there(self):
        with self.assertRaises(ConnectionRefusedError):
            socket.create_connection(("127.0.0.1", hold_port()))

    def test_the_kernel_gives_it_to_no_program_that_requests_a_free_one(self):
        def ask(port):
            """For any free port of a range that is one port long."""
            with socket.socket() as other:
                other.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                try:
                    other.setsockopt(
                        socket.IPPROTO_IP, IP_LOCAL_PORT_RANGE, struct.pack("I", port | port << 16)
                    )
                except OSError:
                    self.skipTest("this kernel has no IP_LOCAL_PORT_RANGE (Linux 6.3)")
                other.bind(("127.0.0.1", 0))
                return other.getsockname()[1]

        with self.assertRaises(OSError) as refused:
            ask(hold_port())
        self.assertEqual(refused.exception.errno, errno.EADDRINUSE)
        with socket.create_server(("127.0.0.1", 0)) as closed:
            port = closed.getsockname()[1]
        with contextlib.suppress(OSError):  # another process was faster: this is why ports are held
            self.assertEqual(ask(port), port)

    def test_a_program_that_names_it_listens_there_again_and_again(self):
        port = hold_port()
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
            (("nginx",), 0, 1),
            (("b",), 0, 1),
            (("nginx", "other"), ALL_SKIPPED, 2),
            (("fails",), 1, 0),
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


if __name__ == "__main__":
    unittest.main()

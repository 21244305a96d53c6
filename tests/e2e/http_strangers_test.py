#!/usr/bin/env python3
"""What the voxel server protects: its replies from web pages of other origins, and its threads from
clients that do not finish their requests."""

import contextlib
import select
import ssl
import time
import unittest
import urllib.request

from certificate import self_signed
from support import Case, Run, Server, binary, square, survey
from wire import connect

HALF_OPEN = 300
GOOD_REQUESTS = 20
MOST_WAIT_S = 60
HALF_HELLO = bytes.fromhex("16030100c8010000c403033f")


class Pages(Case):
    """A web page of another origin cannot read a server of this machine, by any host name."""

    @classmethod
    def setUpClass(cls):
        names = ("--public-name", "voxels.example.org", "--public-name", "other.example.org")
        cls.server = Server(square(), "--cache", "none", *names)

    @classmethod
    def tearDownClass(cls):
        assert cls.server.stop() == 0, cls.server.err

    def test_pages_of_other_origins_are_refused(self):
        script = {"Origin": "http://attacker.example"}
        self.assertEqual(self.server.get("/v2/world", script)[0], 403)
        other = {"Host": "attacker.example"}
        self.assertEqual(self.server.get("/v2/world", other)[0], 421)
        for name in ("voxels.example.org", "OTHER.example.org:443"):
            self.assertEqual(self.server.get("/v2/world", {"Host": name})[0], 200)

    def test_a_name_that_is_none_is_refused_at_the_start(self):
        run = Run([binary("VOXELSERVER"), square(), "--public-name", "http://x"])
        self.assertRefused(run, 2, "http://x")


class HalfOpen(Case):
    """300 connections whose requests never end, with time limits that would let them stay."""

    THREADS = 64
    PATIENT = ("--cache", "none", "--request-threads", str(THREADS), "--keep-alive-s", "3600")
    PATIENT += ("--header-timeout-s", "3600")

    def closed(self, connections, least):
        """Waits until so many were closed by the server. @return how many were"""
        gone = set()
        until = time.monotonic() + MOST_WAIT_S
        while len(gone) < least and time.monotonic() < until:
            left = [c for c in connections if c not in gone]
            for connection in select.select(left, [], [], 1)[0]:
                try:
                    if not connection.recv(1 << 16):
                        gone.add(connection)
                except OSError:
                    gone.add(connection)
        return len(gone)

    def test_good_requests_are_answered_and_the_others_closed_with_tls_too(self):
        """host_test.cpp has what a plain connection leaves unfinished."""
        folder = self_signed()
        context = ssl.create_default_context(cafile=folder / "certificate.pem")
        server = Server(survey(), *self.PATIENT, "--tls-cert", folder / "both.pem")

        def ask():
            address = server.url + "/healthz"
            with urllib.request.urlopen(address, context=context, timeout=MOST_WAIT_S) as reply:
                return reply.read()

        with contextlib.ExitStack() as stack:
            stack.callback(server.stop)
            connections = [connect(server.port, MOST_WAIT_S) for _ in range(HALF_OPEN)]
            for connection in connections:
                stack.callback(connection.close)
                connection.sendall(HALF_HELLO)
            for _ in range(GOOD_REQUESTS):
                self.assertEqual(ask(), b"ok\n")
            least = HALF_OPEN - self.THREADS
            self.assertGreaterEqual(self.closed(connections, least), least)
            self.assertEqual(ask(), b"ok\n")
        self.assertEqual(server.process.returncode, 0, server.err)
        self.assertEqual(server.err.count("do not finish their requests"), 1, server.err)


if __name__ == "__main__":
    unittest.main()

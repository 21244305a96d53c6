#!/usr/bin/env python3
"""What the voxel server protects: its replies from web pages of other origins, and its threads from
clients that do not finish their requests."""

import contextlib
import http.client
import select
import ssl
import time
import unittest

from certificate import self_signed
from support import Case, Run, Server, binary, square, survey
from wire import connect, get

HALF_OPEN = 300
GOOD_REQUESTS = 20
MOST_WAIT_S = 60
HALF_HEADER = b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n"
HALF_REQUESTS = {
    "nothing": b"",
    "half a header": HALF_HEADER,
    "half a body": get(
        "/v2/boxes", "Content-Type: application/json", "Content-Length: 200000", method="POST"
    )
    + b"{",
}


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

    def among_half_open(self, server, first_bytes, ask):
        connections = [connect(server.port, MOST_WAIT_S) for _ in range(HALF_OPEN)]
        try:
            for connection in connections:
                connection.sendall(first_bytes)
            for _ in range(GOOD_REQUESTS):
                self.assertEqual(ask(), (200, b"ok\n"))
            least = HALF_OPEN - self.THREADS
            self.assertGreaterEqual(self.closed(connections, least), least)
            self.assertEqual(ask(), (200, b"ok\n"))
        finally:
            for connection in connections:
                connection.close()

    def serve_among_half_open(self, first_bytes, ask, *flags):
        server = Server(survey(), *self.PATIENT, *flags)
        try:
            self.among_half_open(server, first_bytes, lambda: ask(server))
        finally:
            code = server.stop()
        self.assertEqual(code, 0, server.err)
        self.assertEqual(server.err.count("do not finish their requests"), 1, server.err)

    def test_good_requests_are_answered_and_the_others_closed(self):
        def plain(server):
            return server.get("/healthz", timeout_s=MOST_WAIT_S)[::2]

        for name, first_bytes in HALF_REQUESTS.items():
            with self.subTest(name):
                self.serve_among_half_open(first_bytes, plain)

    def test_with_tls(self):
        folder = self_signed()
        context = ssl.create_default_context(cafile=folder / "certificate.pem")

        def secure(server):
            connection = http.client.HTTPSConnection(
                "127.0.0.1", server.port, timeout=MOST_WAIT_S, context=context
            )
            with contextlib.closing(connection):
                connection.request("GET", "/healthz")
                reply = connection.getresponse()
                return reply.status, reply.read()

        half_hello = bytes.fromhex("16030100c8010000c403033f")
        self.serve_among_half_open(half_hello, secure, "--tls-cert", folder / "both.pem")


if __name__ == "__main__":
    unittest.main()

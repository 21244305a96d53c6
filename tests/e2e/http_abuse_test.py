#!/usr/bin/env python3
"""The voxel server against malformed requests.

Every answer is a right one or a closed connection, and other clients are served.
"""

import http.client
import random
import select
import threading
import time
import unittest

import abuse_cases
from support import HANGS_S, Case, Server, has_sanitizers, survey
from wire import connect, get, talk

HEADER_TIMEOUT_S = 5
MOST_GROWTH_KIB = 10 * 1024
FUZZED = 10_000


class GoodClient:
    """Requests /healthz and one box over and over while others misbehave."""

    def __init__(self, server, path, body):
        self._server = server
        self._path = path
        self._body = body
        self.answered = 0
        self.failures = []
        self.slowest_s = 0
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._work, daemon=True)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._stop.set()
        self._thread.join()

    def _work(self):
        while not self._stop.wait(0.02):
            start = time.monotonic()
            try:
                if (
                    self._server.get("/healthz")[::2] != (200, b"ok\n")
                    or self._server.get(self._path)[2] != self._body
                ):
                    self.failures.append("another reply than before")
            except (OSError, http.client.HTTPException) as error:
                self.failures.append(repr(error))
            self.answered += 1
            self.slowest_s = max(self.slowest_s, time.monotonic() - start)


class Abuse(Case):
    @classmethod
    def setUpClass(cls):
        flags = ["--header-timeout-s", HEADER_TIMEOUT_S]
        cls.server = Server(survey(), "--cache", "none", "--memory-mib", "256", *flags)
        cls.box = next(p for p in cls.server.box_paths() if cls.server.get(p)[0] == 200)
        cls.bytes = cls.server.get(cls.box)[2]

    @classmethod
    def tearDownClass(cls):
        code = cls.server.stop()
        for line in cls.server.err.splitlines():
            assert not line.startswith(("[error", "terravox:")), cls.server.err
        assert code == 0, f"exit code {code}: {cls.server.err}"

    def setUp(self):
        self.good = GoodClient(self.server, self.box, self.bytes)
        self.good.__enter__()

    def tearDown(self):
        self.good.__exit__()
        self.assertIsNone(self.server.process.poll(), "the server is gone")
        self.assertEqual(self.good.failures, [])

    def check(self, said, allowed, most_replies=1):
        """Only the allowed statuses, errors as problem+json, no reply too many."""
        if not said.replies:
            self.assertTrue(said.closed and abuse_cases.CLOSED in allowed, str(said))
        else:
            self.assertIn(said.replies[0].status, allowed, str(said))
        self.assertLessEqual(len(said.replies), most_replies, str(said))
        self.assertEqual(said.rest, b"", str(said))
        for reply in said.replies:
            if reply.status >= 400:
                self.assertEqual(reply.problem(), "", str(said))

    def check_table(self, table):
        for name, (data, allowed, most_replies) in table.items():
            with self.subTest(name):
                self.check(talk(self.server.port, data), allowed, most_replies)

    def test_headers_and_bodies(self):
        self.check_table(abuse_cases.BODIES)

    def test_a_refused_body_is_never_the_next_request(self):
        inner = get("/v2/world")
        for name, headers in {
            "length": [f"Content-Length: {len(inner)}"],
            "chunked": ["Transfer-Encoding: chunked"],
            "both": ["Content-Length: 4", "Transfer-Encoding: chunked"],
            "two lengths": ["Content-Length: 0", f"Content-Length: {len(inner)}"],
            "blank": [f"Content-Length : {len(inner)}"],
        }.items():
            for method in ("GET", "POST", "PUT", "HEAD"):
                with self.subTest(f"{name}, {method}"):
                    said = talk(
                        self.server.port,
                        get("/healthz", *headers, method=method) + inner,
                        heads=[method == "HEAD"],
                    )
                    self.assertEqual(len(said.replies), 1, str(said))
                    self.assertGreaterEqual(said.replies[0].status, 400, str(said))
                    self.assertTrue(said.closed, str(said))

    def test_half_requests_and_idle_connections_are_closed(self):
        starts = [
            b"",
            b"G",
            b"GET /healthz",
            b"GET /healthz HTTP/1.1\r\n",
            b"GET /healthz HTTP/1.1\r\nHost: x\r\nA:",
        ]
        connections = [connect(self.server.port) for _ in range(50)]
        for i, connection in enumerate(connections):
            connection.sendall(starts[i % len(starts)])
        until = time.monotonic() + HANGS_S
        for connection in connections:
            while select.select([connection], [], [], max(0.0, until - time.monotonic()))[
                0
            ] and connection.recv(1 << 16):
                pass
            self.assertLess(
                time.monotonic(), until, "a connection without a request was not closed"
            )
            connection.close()

    def test_ten_thousand_malformed_requests(self):
        paths = ["/healthz", "/v2/world", "/v2/stats", self.box, "/v2/columns/0/1/1"]
        good = [get(p, "Accept: */*", "Accept-Encoding: zstd") for p in paths]
        good.append(
            get("/v2/boxes", "Content-Length: 30", "Content-Type: application/json", method="POST")
            + b'{"boxes":[[0,1,1,1],[1,0,0,0]]'
        )
        numbers = random.Random(7)
        counts = {}
        before = 0
        for i in range(FUZZED):
            if i == FUZZED // 10:
                before = self.server.memory_kib()
            data = abuse_cases.damaged(numbers, good)
            said = talk(self.server.port, data, half_close=True, quiet_s=HANGS_S)
            for reply in said.replies:
                counts[reply.status] = counts.get(reply.status, 0) + 1
                self.assertTrue(
                    reply.status in (200, 204, 304, 501, 505) or 400 <= reply.status < 500,
                    f"request {i}: {data[:300]}: {said}",
                )
                self.assertFalse(
                    reply.status >= 400 and reply.problem(),
                    f"request {i}: {data[:300]}: {reply.problem()}",
                )
            self.assertTrue(said.closed, f"request {i}: {data[:300]}: {said}")
        self.assertGreater(counts.get(400, 0), FUZZED // 4, str(counts))
        if not has_sanitizers():
            self.assertLess(self.server.memory_kib() - before, MOST_GROWTH_KIB, str(counts))


if __name__ == "__main__":
    unittest.main()

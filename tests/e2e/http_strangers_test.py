#!/usr/bin/env python3
"""What the voxel server protects: its folder names from clients, its replies from web pages of
other origins, and its threads from clients that do not finish their requests."""

import contextlib
import http.client
import json
import select
import shutil
import ssl
import time
import unittest

from certificate import self_signed
from support import ROOT, Case, Run, Server, binary, square, survey, temporary_folder
from wire import connect, get, talk

HALF_OPEN = 300
GOOD_REQUESTS = 20
MOST_WAIT_S = 60
# Far more than the half second for which a client may take a thread from others, and less than a
# good request may wait.
OWN_LIMIT_S = 30
HALF_HEADER = b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n"
HALF_REQUESTS = {
    "nothing": b"",
    "half a header": HALF_HEADER,
    "half a body": get(
        "/v2/boxes", "Content-Type: application/json", "Content-Length: 200000", method="POST"
    )
    + b"{",
}


def middle(world):
    low = world["bounds"]["min"]
    high = world["bounds"]["max"]
    return (low[0] + high[0]) // 2, (low[2] + high[2]) // 2


class Folders(Case):
    """Every route, with a request that succeeds and one that fails."""

    def place(self):
        """A folder with a blank in its name: a good square, a damaged one, orthophotos."""
        place = temporary_folder() / "a secret place"
        (place / "data").mkdir(parents=True)
        shutil.copy(square(), place / "data")
        data = bytearray(square().read_bytes())
        data[len(data) // 2 : len(data) // 2 + 2000] = bytes(2000)
        (place / "data" / "damaged.laz").write_bytes(data)
        shutil.copytree(survey() / "ortho", place / "ortho")
        return place

    def replies(self, server):
        """@return by address: status, headers, body"""
        world = server.json("/v2/world")
        x, z = middle(world)
        bx = x // 64
        bz = z // 64
        by = server.json(f"/v2/columns/0/{bx}/{bz}")["by_begin"]
        query = f"?format=raw&tmx={x}&tmy={-z}&x=0&y=0&z=0&sx=16&sy=16&sz=16"
        out = {}
        document = json.loads((ROOT / "docs" / "openapi.json").read_text())
        for path, methods in document["paths"].items():
            values = {"level": 0, "bx": bx, "by": by, "bz": bz, "name": "app.js"}
            values["file"] = "viewer.js"
            values["id"] = "0" * 32
            if path.startswith("/map"):
                values = {"z": world["map"]["zooms"][1], "x": x // 256, "y": z // 256}
            address = path.format(**values) + (query if path.startswith("/gkot") else "")
            if "post" in methods:
                body = json.dumps({"boxes": [[0, bx, by, bz]]})
                out[address] = server.post(address, body, {"Content-Type": "application/json"})
            else:
                out[address] = server.get(address)
        for address in ("/v2/boxes/0/2147483647/0/0", "/map/99/0/0.png", "/nothing"):
            out[address] = server.get(address)
        out["/v2/squares, once one has failed"] = server.get("/v2/squares")
        return out

    def test_no_reply_names_a_folder(self):
        place = self.place()
        flags = ["--ortho", place / "ortho", "--cache", place / "cache", "--jobs", "1"]
        server = Server(place / "data", *flags)
        try:
            seen = self.replies(server)
        finally:
            self.assertEqual(server.stop(), 0, server.err)
        self.assertIn(
            500, {reply[0] for reply in seen.values()}, "nothing failed, so no error was tested"
        )
        squares = json.loads(seen["/v2/squares, once one has failed"][2])["features"]
        errors = [s["properties"]["error"] for s in squares if s["properties"]["error"]]
        self.assertTrue(any("damaged.laz" in error for error in errors), errors)
        for address, (status, headers, body) in seen.items():
            with self.subTest(f"{address}: {status}"):
                for part in (str(place.parent), place.name, "/usr/", "/home/"):
                    self.assertNotIn(part.encode(), body)
                    self.assertNotIn(part, str(headers))
        self.assertIn(str(place), server.err, "the log names the damaged file")


class Pages(Case):
    """A web page of another origin cannot read a server of this machine, by any host name."""

    @classmethod
    def setUpClass(cls):
        names = ("--public-name", "voxels.example.org", "--public-name", "other.example.org")
        cls.server = Server(square(), "--cache", "none", *names)

    @classmethod
    def tearDownClass(cls):
        assert cls.server.stop() == 0, cls.server.err

    def test_the_servers_own_names_are_answered(self):
        port = self.server.port
        for host in (
            f"localhost:{port}",
            "127.0.0.1",
            "[::1]:8888",
            "voxels.example.org",
            "OTHER.example.org:443",
        ):
            for path, status in {"/": 200, "/healthz": 200, "/nothing": 404}.items():
                with self.subTest(f"{path}, Host: {host}"):
                    said = talk(port, get(path, "Connection: close", host=host))
                    self.assertEqual(said.statuses(), [status], str(said))

    def test_other_names_are_refused(self):
        port = self.server.port
        for host in (
            "attacker.example",
            f"attacker.example:{port}",
            "localhost.attacker.example",
            "example.org",
            "voxels.example.org.attacker.example",
            "127.0.0.1.example",
            "",
        ):
            for path in ("/", "/healthz", "/v2/world", "/page/app.js", "/nothing"):
                with self.subTest(f"{path}, Host: {host}"):
                    said = talk(port, get(path, "Connection: close", host=host))
                    self.assertEqual(said.statuses(), [421], str(said))
                    self.assertEqual(said.replies[0].problem(), "")

    def test_pages_of_other_origins_are_refused(self):
        picture = {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "no-cors"}
        script = {"Origin": "http://attacker.example"}
        self.assertEqual(self.server.get("/map/0/0/0.png", picture)[0], 403)
        self.assertEqual(self.server.get("/v2/world", script)[0], 403)
        body = '{"boxes":[[0,0,0,0]]}'
        kind = {"Content-Type": "application/json"}
        own = {**kind, "Origin": f"http://127.0.0.1:{self.server.port}"}
        other = {**kind, **script}
        self.assertEqual(self.server.post("/v2/boxes", body, own)[0], 200)
        self.assertEqual(self.server.post("/v2/boxes", body, other)[0], 403)
        for path in ("/", "/v2/world", "/nothing"):
            names = [name.lower() for name in self.server.get(path)[1]]
            self.assertEqual([n for n in names if n.startswith("access-control-")], [])
            self.assertIn("cross-origin-resource-policy", names)

    def test_a_name_that_is_none_is_refused_at_the_start(self):
        run = Run([binary("VOXELSERVER"), square(), "--public-name", "http://x"])
        self.assertRefused(run, 2, "http://x")


def has_reply(connection):
    try:
        return connection.recv(1) != b""
    except ConnectionError:
        return False


class HalfOpen(Case):
    """300 connections whose requests never end, with time limits that would let them stay."""

    THREADS = 64
    FLAGS = (
        "--cache",
        "none",
        "--request-threads",
        str(THREADS),
        "--keep-alive-s",
        "3600",
    )
    PATIENT = (*FLAGS, "--header-timeout-s", "3600")

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

    def plain(self, server):
        return lambda: server.get("/healthz", timeout_s=MOST_WAIT_S)[::2]

    def answers_before_a_limit_ends(self, server, first_bytes):
        """Whether a good request is answered before the time limit of the server ends others.

        A request that the limit ends has an error as its reply; one that is closed for others has
        none.
        """
        begin = time.monotonic()
        with contextlib.ExitStack() as stack:
            connections = [
                stack.enter_context(connect(server.port, MOST_WAIT_S)) for _ in range(HALF_OPEN)
            ]
            for connection in connections:
                connection.sendall(first_bytes)
            if time.monotonic() - begin > OWN_LIMIT_S / 2:
                self.skipTest(f"to open {HALF_OPEN} connections took half of the server's limit")
            self.assertEqual(self.plain(server)(), (200, b"ok\n"))
            ended = select.select(connections, [], [], 0)[0]
            return not any(map(has_reply, ended))

    def test_good_requests_do_not_wait_for_the_time_limits_of_others(self):
        limit = str(OWN_LIMIT_S)
        for name in ("half a header", "half a body"):
            with self.subTest(name):
                first_bytes = HALF_REQUESTS[name]
                server = Server(survey(), *self.FLAGS, "--header-timeout-s", limit)
                try:
                    self.assertTrue(self.answers_before_a_limit_ends(server, first_bytes))
                finally:
                    code = server.stop()
                self.assertEqual(code, 0, server.err)

    def test_good_requests_are_answered_and_the_others_closed(self):
        for name, first_bytes in HALF_REQUESTS.items():
            with self.subTest(name):
                server = Server(survey(), *self.PATIENT)
                try:
                    self.among_half_open(server, first_bytes, self.plain(server))
                finally:
                    code = server.stop()
                self.assertEqual(code, 0, server.err)
                self.assertEqual(server.err.count("do not finish their requests"), 1, server.err)

    def test_idle_connections_give_way(self):
        server = Server(survey(), *self.PATIENT)
        try:
            self.among_half_open(server, get("/healthz"), self.plain(server))
        finally:
            code = server.stop()
        self.assertEqual(code, 0, server.err)

    def test_with_tls(self):
        folder = self_signed()
        both = folder / "both.pem"
        context = ssl.create_default_context(cafile=folder / "certificate.pem")

        def secure(server):
            def ask():
                connection = http.client.HTTPSConnection(
                    "127.0.0.1", server.port, timeout=MOST_WAIT_S, context=context
                )
                try:
                    connection.request("GET", "/healthz")
                    reply = connection.getresponse()
                    return reply.status, reply.read()
                finally:
                    connection.close()

            return ask

        half_hello = bytes.fromhex("16030100c8010000c403033f")
        for name, first_bytes in {"nothing": b"", "half a handshake": half_hello}.items():
            with self.subTest(name):
                server = Server(survey(), *self.PATIENT, "--tls-cert", both)
                try:
                    self.among_half_open(server, first_bytes, secure(server))
                finally:
                    code = server.stop()
                self.assertEqual(code, 0, server.err)


if __name__ == "__main__":
    unittest.main()

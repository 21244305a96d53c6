#!/usr/bin/env python3
"""config/nginx before the voxel server: slow clients cost nothing, replies pass unchanged."""

import select
import shutil
import ssl
import statistics
import subprocess
import time
import unittest
import urllib.request

from certificate import self_signed
from crowd import Crowd, half_header, nothing, slow_body, slow_header
from nginx import NGINX, Front
from support import HANGS_S, ROOT, Case, Server, hold_port, survey, temporary_folder, wait_until
from wire import get, talk

# The limits of all that is no archive's file.
PAGES = """limit_conn terravox_connections 128;
        limit_req zone=terravox_requests burst="""
BAD_CLIENTS = 1000
GOOD_REQUESTS = 200
# Where slow clients occupy the threads of a server, every request waits for 10 s and more. On a
# busy machine single requests may, too; half of 200 do not.
MEDIAN_LIMIT_S = 5


@unittest.skipIf(NGINX is None, "nginx is not installed (Debian package nginx)")
class FrontTest(Case):
    @classmethod
    def setUpClass(cls):
        names = ["--public-name", "voxels.example.org"]
        cls.server = Server(survey(), "--cache", "none", "--request-threads", "16", *names)
        cls.front = Front(cls.server.port)
        cls.front.__enter__()
        cls.paths = [p for p in cls.server.box_paths() if cls.server.get(p)[0] == 200]
        cls.box = max(cls.paths, key=lambda p: len(cls.server.get(p)[2]))

    @classmethod
    def tearDownClass(cls):
        cls.front.__exit__()
        assert cls.server.stop() == 0, cls.server.err
        assert "[alert]" not in cls.front.log() and "[emerg]" not in cls.front.log(), (
            cls.front.log()
        )

    def through(self, path, *headers, method="GET", body=b""):
        said = talk(
            self.front.port,
            get(path, *headers, "Connection: close", method=method) + body,
            quiet_s=2,
            heads=[method == "HEAD"],
        )
        self.assertEqual(len(said.replies), 1, str(said))
        return said.replies[0]

    def test_the_shipped_configuration_is_valid(self):
        prefix = temporary_folder()
        config = ROOT / "config" / "nginx" / "nginx.conf"
        done = subprocess.run(
            [NGINX, "-t", "-p", prefix, "-e", "error.log", "-c", config],
            capture_output=True,
            text=True,
            check=False,
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("[warn]", done.stderr)

    def test_tls_as_the_example_has_it(self):
        front = Front(self.server.port)
        port = hold_port()
        folder = self_signed()
        for name in ("key.pem", "certificate.pem"):
            shutil.copy(folder / name, front.folder)
        text = (ROOT / "config" / "nginx" / "terravox-tls.conf.example").read_text()
        text = text.replace("8443", f"127.0.0.1:{port}").replace("/etc/terravox", str(front.folder))
        (front.folder / "terravox-tls.conf").write_text(text)
        with front:
            context = ssl.create_default_context(cafile=front.folder / "certificate.pem")
            context.check_hostname = False
            with urllib.request.urlopen(
                f"https://127.0.0.1:{port}{self.box}", context=context, timeout=HANGS_S
            ) as reply:
                self.assertEqual(reply.read(), self.server.get(self.box)[2])
            said = talk(port, get("/healthz"))
            self.assertEqual(
                said.statuses()[:1], [400], "plain HTTP on the port with TLS: " + str(said)
            )

    def test_boxes_tags_and_heads_pass_unharmed(self):
        for path in self.paths[:10]:
            status, headers, body = self.server.get(path, {"Accept-Encoding": "zstd, gzip"})
            reply = self.through(path, "Accept-Encoding: zstd, gzip")
            self.assertEqual((reply.status, reply.body), (status, body))
            for name in ("ETag", "Content-Type", "Content-Length", "Cache-Control"):
                self.assertEqual(reply.headers.get(name.lower()), headers.get(name), name)
            tag = headers["ETag"]
            again = self.through(path, "Accept-Encoding: zstd, gzip", "If-None-Match: " + tag)
            self.assertEqual((again.status, again.headers.get("etag"), again.body), (304, tag, b""))
            head = self.through(path, "Accept-Encoding: zstd, gzip", method="HEAD")
            self.assertEqual(
                (head.status, head.headers.get("etag"), head.headers.get("content-length")),
                (200, tag, str(len(body))),
            )
        ranged = self.through(self.box, "Range: bytes=0-9")
        self.assertEqual((ranged.status, ranged.body), (200, self.server.get(self.box)[2]))
        air = self.through("/v2/boxes/0/2147483647/0/0")
        self.assertEqual((air.status, air.body), (204, b""))

    def test_host_names_are_checked_by_the_server(self):
        port = self.front.port
        for host, status in {
            "voxels.example.org": 200,
            f"localhost:{port}": 200,
            "192.0.2.7": 200,
            "attacker.example": 421,
            f"attacker.example:{port}": 421,
        }.items():
            with self.subTest(host):
                said = talk(port, get("/v2/world", "Connection: close", host=host))
                self.assertEqual(said.statuses(), [status], str(said))
        page = ("Sec-Fetch-Site: cross-site", "Sec-Fetch-Mode: no-cors", "Sec-Fetch-Dest: image")
        self.assertEqual(self.through("/map/0/0/0.png", *page).status, 403)

    def test_refusals_of_both_are_problems(self):
        cases = {
            "the server: no numbers": (get("/v2/boxes/a/b/c/d"), 400),
            "the server: nothing there": (get("/nothing"), 404),
            "the server: a method": (get("/v2/world", method="DELETE"), 405),
            "a malformed line": (b"GET /\x01 HTTP/1.1\r\nHost: x\r\n\r\n", 400),
            "no Host": (b"GET / HTTP/1.1\r\n\r\n", 400),
            "two lengths": (
                get("/healthz", "Content-Length: 0", "Content-Length: 5") + b"abcde",
                400,
            ),
            "a length and chunks": (
                get("/healthz", "Content-Length: 5", "Transfer-Encoding: chunked") + b"0\r\n\r\n",
                400,
            ),
            "TRACE": (get("/healthz", method="TRACE"), 405),
            "a body too long": (get("/v2/boxes", "Content-Length: 300000", method="POST"), 413),
            "an address too long": (get("/" + "a" * 8000), 414),
            "a header line too long": (get("/healthz", "A: " + "a" * 8000), 431),
            "headers too long": (get("/healthz", *(f"A{i}: " + "a" * 3000 for i in range(9))), 431),
            "another encoding": (get("/healthz", "Transfer-Encoding: xchunked"), 501),
            "another version": (b"GET / HTTP/3.0\r\nHost: x\r\n\r\n", 505),
        }
        for name, (data, status) in cases.items():
            with self.subTest(name):
                said = talk(self.front.port, data)
                self.assertEqual(said.statuses(), [status], str(said))
                self.assertEqual(said.replies[0].problem(), "", str(said))

    def test_too_many_requests_of_one_address_get_429_and_retry_after(self):
        # A smaller rate than that of the requests, however slow this machine is.
        with Front(
            self.server.port, [("rate=1000r/s", "rate=1r/m"), (PAGES + "2000", PAGES + "50")]
        ) as front:
            said = talk(
                front.port,
                get("/v2/world") * 199 + get("/v2/world", "Connection: close"),
                quiet_s=HANGS_S,
            )
        self.assertEqual(len(said.replies), 200)
        refused = [r for r in said.replies if r.status == 429]
        self.assertEqual(set(said.statuses()), {200, 429})
        self.assertGreater(said.statuses().count(200), 50)
        self.assertEqual(
            [r for r in refused if r.problem() or r.headers.get("retry-after") != "1"], []
        )

    def test_a_server_that_is_gone(self):
        with Front(hold_port()) as front:
            for path in ("/v2/world", "/healthz"):
                said = talk(front.port, get(path))
                self.assertEqual(said.statuses(), [502], str(said))
                self.assertEqual(said.replies[0].problem(), "")
                self.assertEqual(said.replies[0].headers.get("retry-after"), "5")

    def median_of_good_client(self):
        """@return the median of a good client's requests, seconds"""
        body = self.server.get(self.box)[2]
        times = []
        for _ in range(GOOD_REQUESTS):
            start = time.monotonic()
            reply = self.through(self.box)
            times.append(time.monotonic() - start)
            self.assertEqual((reply.status, reply.body), (200, body))
        return statistics.median(times)

    def test_a_good_client_among_a_thousand_bad_ones(self):
        for behaviour in (nothing, half_header, slow_header, slow_body):
            with (
                self.subTest(behaviour.__name__),
                Crowd(self.front.port, BAD_CLIENTS, behaviour) as crowd,
            ):
                wait_until(lambda crowd=crowd: crowd.steps > 1, "the crowd has behaved twice")
                self.assertLessEqual(self.median_of_good_client(), MEDIAN_LIMIT_S)

    def test_a_good_client_among_slow_readers(self):
        # Each requests 300 KB of replies and never reads; there are far more than server threads.
        size = len(self.server.get(self.box)[2])
        requests = get(self.box) * (300_000 // size + 1)

        def slow_reader(connection, step):
            if step == 0:
                connection.sendall(requests)
            elif select.select([connection], [], [], 0)[0] and not connection.recv(64):
                raise ConnectionError

        with Crowd(self.front.port, BAD_CLIENTS, slow_reader) as crowd:
            wait_until(lambda: crowd.steps > 2, "the crowd has behaved three times")
            self.assertLessEqual(self.median_of_good_client(), MEDIAN_LIMIT_S)


if __name__ == "__main__":
    unittest.main()

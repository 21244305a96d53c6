#!/usr/bin/env python3
"""The voxel server and the ray tracer together.

A picture of served boxes is the direct one; a failing server is reported.
"""

import threading
import unittest
import urllib.error
import urllib.request
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

from support import HANGS_S, Case, Server, entries, render, square, survey, temporary_folder

SMALL = ["--size", "160x90", "--samples", "1", "--quiet"]


class Serve(Case):
    def test_served_and_direct_pictures_are_the_same_bits(self):
        out = temporary_folder()
        server = Server(survey(), "--ortho", survey() / "ortho")
        try:
            served = render(server.url, *SMALL, "-o", out / "served.exr", "-o", out / "served.png")
            flags = [*SMALL, "--memory-mib", "1", "--threads", "3"]
            again = render(server.url + "/", *flags, "-o", out / "again.exr")
        finally:
            code = server.stop()
        self.assertDone(served)
        self.assertDone(again)
        self.assertEqual(code, 0, server.err)
        for line in server.err.splitlines():
            self.assertFalse(line.startswith(("[warn", "[error")), server.err)
        words = ["--ortho", survey() / "ortho", *SMALL]
        self.assertDone(
            render(survey(), *words, "-o", out / "direct.exr", "-o", out / "direct.png")
        )
        self.assertAlike(out / "served.exr", out / "direct.exr", exact=True)
        self.assertAlike(out / "served.png", out / "direct.png", exact=True)
        self.assertAlike(out / "again.exr", out / "direct.exr", exact=True)


class Fake(BaseHTTPRequestHandler):
    """Answers /v2/world with the body of the test, and boxes with an error."""

    protocol_version = "HTTP/1.1"
    world = b""

    def do_GET(self):
        body, status = (
            (self.world, 200)
            if self.path == "/v2/world"
            else (b'{"detail": "the disk is gone"}', 500)
        )
        self.send_response(status)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_):
        pass


class BadServer(Case):
    def render_from(self, world):
        handler = type("World", (Fake,), {"world": world})
        server = ThreadingHTTPServer(("127.0.0.1", 0), handler)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        out = temporary_folder()
        try:
            return render(
                f"http://127.0.0.1:{server.server_port}", *SMALL, "-o", out / "a.png"
            ), out
        finally:
            server.shutdown()
            server.server_close()

    def test_replies_that_are_no_world(self):
        for body, said in {
            b"<html>hello</html>": "not the reply of a voxel server",
            b"{}": "not the reply of a voxel server",
            b'{"version": 3}': "version 3; allowed: 2",
        }.items():
            with self.subTest(body):
                run, out = self.render_from(body)
                self.assertRefused(run, 1, said)
                self.assertEqual(entries(out), [])

    def test_boxes_that_cannot_be_fetched_are_holes_in_log_exit_code_and_picture(self):
        server = Server(square())
        try:
            world = urllib.request.urlopen(server.url + "/v2/world", timeout=HANGS_S).read()
        finally:
            server.stop()
        run, out = self.render_from(world)
        self.assertEqual(run.code, 3, str(run))
        self.assertEqual(entries(out), ["a.png"])
        self.assertIn("the disk is gone", run.err)
        self.assertIn("holes", run.err)


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
"""The voxel server and the ray tracer together.

A picture of served boxes is the direct one; a failing server is reported.
"""

import json
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
            again = render(
                server.url + "/",
                *SMALL,
                "--memory-mib",
                "1",
                "--threads",
                "3",
                "-o",
                out / "again.exr",
            )
        finally:
            code = server.stop()
        self.assertDone(served)
        self.assertDone(again)
        self.assertEqual(code, 0, server.err)
        for line in server.err.splitlines():
            self.assertFalse(line.startswith(("[warn", "[error")), server.err)
        self.assertDone(
            render(
                survey(),
                "--ortho",
                survey() / "ortho",
                *SMALL,
                "-o",
                out / "direct.exr",
                "-o",
                out / "direct.png",
            )
        )
        self.assertAlike(out / "served.exr", out / "direct.exr", exact=True)
        self.assertAlike(out / "served.png", out / "direct.png", exact=True)
        self.assertAlike(out / "again.exr", out / "direct.exr", exact=True)

    def test_coarse_levels_are_served_too(self):
        out = temporary_folder()
        server = Server(survey())
        try:
            self.assertDone(render(server.url, *SMALL, "--level", "2", "-o", out / "served.exr"))
        finally:
            server.stop()
        self.assertDone(render(survey(), *SMALL, "--level", "2", "-o", out / "direct.exr"))
        self.assertAlike(out / "served.exr", out / "direct.exr", exact=True)

    def test_the_world_is_described_and_its_boxes_have_tags(self):
        server = Server(square())
        try:
            world = json.load(urllib.request.urlopen(server.url + "/v2/world", timeout=HANGS_S))
            self.assertEqual(world["version"], 2)
            self.assertEqual(world["crs"], "EPSG:3794")
            low = world["bounds"]["min"]
            high = world["bounds"]["max"]
            key = (
                f"0/{(low[0] + high[0]) // 2 // 64}/{low[1] // 256}/{(low[2] + high[2]) // 2 // 64}"
            )
            reply = urllib.request.urlopen(f"{server.url}/v2/boxes/{key}", timeout=HANGS_S)
            tag = reply.headers["ETag"]
            self.assertTrue(tag and not tag.startswith("W/"))
            with self.assertRaises(urllib.error.HTTPError) as not_modified:
                urllib.request.urlopen(
                    urllib.request.Request(
                        f"{server.url}/v2/boxes/{key}", headers={"If-None-Match": tag}
                    ),
                    timeout=HANGS_S,
                )
            self.assertEqual(not_modified.exception.code, 304)
            not_modified.exception.close()
        finally:
            server.stop()


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

    def test_no_server_listens(self):
        out = temporary_folder()
        run = render("http://127.0.0.1:1", *SMALL, "-o", out / "a.png")
        self.assertRefused(run, 1, "http://127.0.0.1:1")
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

#!/usr/bin/env python3
"""Worlds of every kind behind the voxel server: the same boxes as without it, kept and named."""

import contextlib
import json
import os
import re
import shutil
import struct
import unittest
import zipfile

from static_host import StaticHost
from support import (
    Case,
    Run,
    Server,
    binary,
    hold_port,
    temporary_folder,
)

AREA = ["--area", "-128,-128,128,128"]
SEED = "generated:3"
TOKEN_OF_FAR = "the-token-of-the-far-server-2f7a1c93"
TOKEN_OF_NEAR = "the-token-of-the-near-server-8b40d6e5"


def convert(*arguments):
    return Run([binary("RAYTRACER"), "convert", *arguments, "--quiet"])


def serve(*arguments, environment=None):
    """A server that is expected to refuse. @return the Run"""
    return Run(
        [binary("VOXELSERVER"), *arguments, "--cache", "none", "--port", "0"],
        environment=environment,
    )


@contextlib.contextmanager
def variables(**values):
    os.environ.update(values)
    try:
        yield
    finally:
        for name in values:
            del os.environ[name]


class Help(unittest.TestCase):
    def test_the_server_names_the_inputs_that_the_renderer_names(self):
        rendered = Run([binary("RAYTRACER"), "render", "--help", "all"]).out
        inputs = re.search(r"inputs TEXT \.\.\. REQUIRED\s+(.+)", rendered).group(1).split(", ")
        self.assertGreater(len(inputs), 6)
        served = serve("--help").out
        for name in inputs:
            with self.subTest(name):
                self.assertIn(name, served)


def web_host(archive, etag='"one"'):
    """A host of an archive, which may be exchanged. @return it, and the archive's address"""
    host = StaticHost({"place.tvx": archive}, etag=etag, is_bare=True)
    return host, host.url + "place.tvx"


def heights(file, lift=0):
    """An ASCII grid of 200 m x 200 m hills near the origin of EPSG:3794."""
    rows = [
        " ".join(str(300 + lift + (x * 7 + y * 3) % 40 / 2) for x in range(40)) for y in range(40)
    ]
    file.write_text(
        "ncols 40\nnrows 40\nxllcorner 462000\nyllcorner 101000\ncellsize 5\n"
        "NODATA_value -9999\n" + "\n".join(rows) + "\n"
    )
    return file


class Kinds(Case):
    """One input of each kind, made once."""

    @classmethod
    def setUpClass(cls):
        cls.folder = temporary_folder()
        cls.archive = cls.folder / "noise.tvx"
        cls.game = cls.folder / "game"
        for target in (cls.archive, cls.game):
            convert(SEED, target, *AREA).done()
        cls.zipped = cls.folder / "game.zip"
        with zipfile.ZipFile(cls.zipped, "w") as out:
            for file in sorted(cls.game.rglob("*")):
                if file.is_file():
                    out.write(file, file.relative_to(cls.folder))
        cls.raster = heights(cls.folder / "hills.asc")
        cls.web, there = web_host(cls.archive.read_bytes())
        cls.far = Server(cls.archive, "--cache", "none", "--no-ahead")
        cls.kinds = {
            "a Minecraft folder": [cls.game],
            "a Minecraft ZIP": [cls.zipped],
            "a raster of heights": [cls.raster, "--crs", "EPSG:3794"],
            "noise": [SEED],
            "an archive": [cls.archive],
            "an archive on a web server": [there],
            "a voxel server": [cls.far.url],
        }
        cls.servers = {}

    @classmethod
    def tearDownClass(cls):
        for name, server in cls.servers.items():
            assert server.stop() == 0, (name, server.err)
        cls.web.stop()
        cls.far.stop()

    @classmethod
    def server_of(cls, kind):
        """A server without a cache, for all tests that only send requests."""
        if kind not in cls.servers:
            cls.servers[kind] = Server(*cls.kinds[kind], "--cache", "none")
        return cls.servers[kind]

    def each_kind(self):
        for name, inputs in self.kinds.items():
            with self.subTest(name):
                yield name, inputs

    def stopped(self, server):
        self.assertEqual(server.stop(), 0, server.err)

    def some_box(self, server, level=0):
        """The address of a box of a level that is not air, in the middle."""
        world = server.json("/v2/world")
        bounds = world.get("framed", world["bounds"])
        side = 64 << level
        place = [(bounds["min"][a] + bounds["max"][a]) // 2 // side for a in (0, 2)]
        column = server.json(f"/v2/columns/{level}/{place[0]}/{place[1]}")
        for by in range(column["by_begin"], column["by_end"]):
            path = f"/v2/boxes/{level}/{place[0]}/{by}/{place[1]}"
            if server.get(path)[0] == 200:
                return path
        raise AssertionError(f"only air in the middle of {world}")

    def test_boxes_are_those_of_the_world_itself(self):
        out = temporary_folder()
        for name, inputs in self.each_kind():
            part = AREA if name == "noise" else []
            worlds = {"served": [self.server_of(name).url], "direct": inputs}
            for how, world in worlds.items():
                flags = [*part, "--overwrite"]
                self.assertDone(convert(*world, out / f"{how}.tvx", *flags))
            boxes = {(out / f"{how}.tvx").read_bytes() for how in worlds}
            self.assertEqual(len(boxes), 1, "not the same boxes")

    def test_the_second_start_serves_what_the_first_has_kept(self):
        for _, inputs in self.each_kind():
            cache = temporary_folder()
            server = Server(*inputs, "--cache", cache, "--no-ahead")
            paths = [self.some_box(server), self.some_box(server, 1)]
            before = [server.get(path) for path in paths]
            edition = server.get("/v2/world")[1]["Terravox-Edition"]
            made = server.json("/v2/stats")["making"]["made"]
            again = [server.get(path)[2] for path in paths]
            self.assertEqual(server.json("/v2/stats")["making"]["made"], made)
            self.stopped(server)
            server = Server(*inputs, "--cache", cache, "--no-ahead")
            after = [server.get(path) for path in paths]
            self.assertEqual(server.json("/v2/stats")["making"]["made"], 0)
            self.assertEqual(server.get("/v2/world")[1]["Terravox-Edition"], edition)
            tag = before[0][1]["ETag"]
            self.assertEqual(server.get(paths[0], {"If-None-Match": tag})[0], 304)
            self.stopped(server)
            self.assertEqual([reply[2] for reply in before], again)
            self.assertEqual([reply[2] for reply in after], again)

    def changed_inputs(self):
        """Inputs of which something changes: arguments, and what changes it."""
        folder = temporary_folder()
        game = folder / "game"
        shutil.copytree(self.game, game)
        region = next(game.rglob("*.mca"))
        zipped = folder / "game.zip"
        shutil.copy(self.zipped, zipped)
        archive = folder / "noise.tvx"
        shutil.copy(self.archive, archive)
        raster = heights(folder / "hills.asc")
        web, there = web_host(self.archive.read_bytes())
        self.addCleanup(web.stop)
        other = folder / "other.tvx"
        self.assertDone(convert("generated:4", other, *AREA))

        def later(path):
            facts = path.stat()
            os.utime(path, ns=(facts.st_atime_ns, facts.st_mtime_ns + 1_000_000_000))

        def exchange():
            web.files["place.tvx"] = other.read_bytes()
            web.etag = '"two"'

        return {
            "a region": ([game], lambda: later(region)),
            "a ZIP": ([zipped], lambda: later(zipped)),
            "an archive": ([archive], lambda: shutil.copy(other, archive)),
            "a raster": ([raster, "--crs", "EPSG:3794"], lambda: heights(raster, 5)),
            "an archive on a web server": ([there], exchange),
        }

    def test_an_input_that_changes_while_it_is_served_is_not_mixed_with_the_old(self):
        for name, (inputs, change) in self.changed_inputs().items():
            with self.subTest(name):
                cache = temporary_folder()
                server = Server(*inputs, "--cache", cache, "--no-ahead")
                path = self.some_box(server)
                # Of an archive, what was read to open it holds the coarse boxes.
                new = self.all_boxes(server, 0)[-1] if "archive" in name else None
                new = new or self.all_boxes(server, 1)[0]
                kept = server.get(path)[2]
                change()
                self.assertEqual(server.get(new)[0], 500)
                self.assertEqual(server.get("/healthz")[0], 503)
                self.assertEqual(server.get(path)[2], kept)
                self.stopped(server)
                self.assertIn("has changed since the server started", server.err)
                server = Server(*inputs, "--cache", cache, "--no-ahead")
                self.assertEqual(server.get(self.some_box(server))[0], 200)
                self.assertEqual(server.json("/v2/stats")["disk"]["hits"], 0)
                self.stopped(server)

    def all_boxes(self, server, level):
        world = server.json("/v2/world")
        return server.box_paths(level, world.get("framed", world["bounds"]))

    def test_an_input_without_a_known_state_is_not_kept_on_disk(self):
        web, there = web_host(self.archive.read_bytes(), etag=None)
        self.addCleanup(web.stop)
        cache = temporary_folder()
        editions = []
        for _ in range(2):
            server = Server(there, "--cache", cache)
            self.assertEqual(server.get(self.some_box(server))[0], 200)
            self.assertIsNone(server.json("/v2/stats")["disk"])
            editions.append(server.get("/v2/world")[1]["Terravox-Edition"])
            self.stopped(server)
        self.assertNotEqual(*editions)
        self.assertRefused(
            Run([binary("VOXELSERVER"), there, "--cache", cache, "--prepare-only"]),
            2,
            "does not name the state of its world",
        )

    def test_unsuitable_or_broken_inputs_are_refused_by_one_line(self):
        folder = temporary_folder()
        (folder / "cut.tvx").write_bytes(self.archive.read_bytes()[:1000])
        for arguments, code, *said in (
            ([self.game, "--classes", "asprs"], 2, "--classes", "a Minecraft world", "--dimension"),
            ([folder / "none"], 2, "does not exist", "generated:SEED"),
            ([folder / "cut.tvx"], 1, "cut.tvx"),
            ([SEED, "--prepare"], 2, "columns of boxes"),
            (["http://127.0.0.1:1", "--processing-box-timeout-s", "1"], 1, "127.0.0.1:1"),
        ):
            with self.subTest(arguments):
                self.assertRefused(serve(*arguments), code, *said)


class Far(Case):
    """A server that serves another one's world."""

    TIMEOUT = ("--processing-box-timeout-s", "1")

    def setUp(self):
        self.archive = temporary_folder() / "noise.tvx"
        self.assertDone(convert(SEED, self.archive, *AREA))

    def test_a_remote_server_that_is_gone_makes_502_and_nothing_wrong_is_kept(self):
        port = hold_port()
        far = Server(self.archive, "--cache", "none", port=port)
        cache = temporary_folder()
        near = Server(far.url, "--cache", cache, *self.TIMEOUT)
        kept, missing = near.box_paths()[:2]
        first = near.get(kept)
        far.kill()
        self.assertEqual(near.get(kept)[2], first[2])
        status, headers, body = near.get(missing)
        self.assertEqual((status, headers["Retry-After"]), (502, "5"))
        self.assertNotIn(b"127.0.0.1", body)
        key = [int(v) for v in missing.split("/")[3:]]
        status, _, body = near.post(
            "/v2/boxes", json.dumps({"boxes": [key]}), {"Content-Type": "application/json"}
        )
        self.assertEqual((status, struct.unpack("<4iII", body[:24])[4]), (200, 502))
        self.assertEqual(near.get("/healthz")[0], 200)
        far = Server(self.archive, "--cache", "none", port=port)
        self.assertEqual(near.get(missing)[0], 200)
        self.assertEqual(near.json("/v2/stats")["disk"]["damaged"], 0)
        self.assertEqual((near.stop(), far.stop()), (0, 0), near.err)

    def test_two_servers_that_serve_each_other_end_in_an_error(self):
        port = hold_port()
        first = Server(self.archive, "--cache", "none", "--no-ahead", port=port)
        second = Server(first.url, "--cache", "none", *self.TIMEOUT)
        paths = second.box_paths()
        first.stop()
        circle = Server(second.url, "--cache", "none", *self.TIMEOUT, port=port)
        status, _, _ = circle.get(paths[0])
        self.assertIn(status, (500, 502))
        self.assertEqual((circle.stop(), second.stop()), (0, 0))

    def test_each_server_has_a_token_of_its_own(self):
        folder = temporary_folder()
        tokens = {}
        for name, text in (("far", TOKEN_OF_FAR), ("near", TOKEN_OF_NEAR)):
            tokens[name] = folder / name
            tokens[name].touch(mode=0o600)
            tokens[name].write_text(text)
        far = Server(self.archive, "--cache", "none", "--token-file", tokens["far"])
        bound = {
            "TERRAVOX_SERVER_ORIGIN": far.url,
            "TERRAVOX_SERVER_TOKEN": TOKEN_OF_FAR,
        }
        with variables(**bound):
            near = Server(far.url, "--cache", "none", "--token-file", tokens["near"])
            open_to_all = serve(far.url, "--bind", "0.0.0.0")
        given = {
            token: near.get("/v2/world", {"Authorization": f"Bearer {token}"})[0]
            for token in (TOKEN_OF_NEAR, TOKEN_OF_FAR)
        }
        self.assertEqual(given, {TOKEN_OF_NEAR: 200, TOKEN_OF_FAR: 401})
        self.assertRefused(open_to_all, 2, "--token-file")
        self.assertEqual((near.stop(), far.stop()), (0, 0))


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
"""An archive that is patched while many read it over HTTP: from the server, and from nginx."""

import asyncio
import pathlib
import resource
import shutil
import time
import unittest

from archive_readers import read_while, two_states
from nginx import NGINX, Front, Static
from support import HANGS_S, THOROUGH, Case, Server, make, render, temporary_folder

# Readers at the same time.
READERS = 1000 if THOROUGH else 120
PATCHES = 4


class ArchiveReaders(Case):
    @classmethod
    def setUpClass(cls):
        hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
        resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, 16384), hard))
        cls.first, cls.changes, cls.states = two_states(
            temporary_folder(), squares="3x3", square_m=128, number=4
        )

    def setUp(self):
        self.folder = temporary_folder()
        self.folder.chmod(0o755)
        self.place = pathlib.Path(shutil.copy(self.first, self.folder / "place.tvx"))
        self.place.chmod(0o644)

    def patch(self, counts):
        """Each state is opened by some before the next one replaces it."""
        for n in range(PATCHES):
            opened = counts.opened
            deadline = time.monotonic() + HANGS_S
            while counts.opened < opened + READERS and not counts.errors:
                self.assertLess(time.monotonic(), deadline, "nobody reads")
                time.sleep(0.01)
            make("ARCHIVE", "patch", self.place, self.changes[n % 2], "--quiet")

    def assertReadWell(self, port, path):
        counts = asyncio.run(
            read_while(self.patch, readers=READERS, port=port, path=path, states=self.states)
        )
        self.assertEqual(counts.errors, [])
        self.assertEqual(counts.states, {0, 1}, "readers have met one state alone")
        self.assertGreater(counts.changed, 0, "nobody has met a change")
        self.assertGreater(counts.parts, READERS)

    def served(self, *options):
        return Server(self.place, "--cache", "none", *options)

    def test_readers_of_the_server_see_whole_archives(self):
        with self.served() as server:
            self.assertReadWell(server.port, "/v2/archive.tvx")

    @unittest.skipIf(NGINX is None, "nginx is not installed (Debian package nginx)")
    def test_readers_behind_the_front_see_whole_archives(self):
        with self.served() as server, Front(server.port) as front:
            self.assertReadWell(front.port, "/v2/archive.tvx")

    @unittest.skipIf(NGINX is None, "nginx is not installed (Debian package nginx)")
    def test_readers_of_static_files_see_whole_archives(self):
        with Static(self.folder) as host:
            self.assertReadWell(host.port, "/place.tvx")

    def test_the_server_goes_on_with_the_archive_that_it_has_opened(self):
        with self.served("--no-ahead") as server:
            edition = server.get("/v2/world")[1]["Terravox-Edition"]
            with self.served("--no-ahead") as other:
                # Behind one front they are one server.
                self.assertEqual(other.get("/v2/world")[1]["Terravox-Edition"], edition)
                self.assertEqual(
                    other.get("/v2/archive.tvx", {"Range": "bytes=0-9"})[1]["ETag"],
                    server.get("/v2/archive.tvx", {"Range": "bytes=0-9"})[1]["ETag"],
                )
                expected = {path: other.get(path)[2] for path in other.box_paths()}
            make("ARCHIVE", "patch", self.place, self.changes[0], "--quiet")
            for path, body in expected.items():
                status, _, now = server.get(path)
                self.assertIn(status, (200, 204), path)
                self.assertEqual(now, body, path)
            self.assertEqual(server.get("/v2/world")[1]["Terravox-Edition"], edition)
            self.assertEqual(server.get("/healthz")[0], 200)
            self.place.unlink()
            self.assertEqual(server.get("/healthz")[0], 200)
            self.assertEqual(server.get("/v2/archive.tvx")[0], 404)
            make("ARCHIVE", "patch", self.first, self.changes[0], "-o", self.place, "--quiet")
        self.assertEqual(server.err.count("was replaced or removed"), 1, server.err)
        with self.served() as server:
            self.assertNotEqual(server.get("/v2/world")[1]["Terravox-Edition"], edition)

    def test_a_picture_from_the_server_s_archive_is_that_of_the_file(self):
        words = ["--size", "80x45", "--samples", "1", "--quiet", "-o"]
        pictures = [self.folder / name for name in ("file.png", "served.png")]
        self.assertDone(render(self.place, *words, pictures[0]))
        with self.served() as server:
            self.assertDone(render(server.url + "/v2/archive.tvx", *words, pictures[1]))
        self.assertAlike(*pictures, exact=True)

    def test_pages_of_an_origin_that_the_operator_names_may_read_it(self):
        page = {"Origin": "https://maps.example"}
        with self.served("--allow-origin", page["Origin"]) as server:
            status, headers, body = server.get("/v2/archive.tvx", {**page, "Range": "bytes=0-9"})
            self.assertEqual((status, body), (206, self.states[0][:10]))
            self.assertEqual(headers["Access-Control-Allow-Origin"], page["Origin"])
            self.assertEqual(server.get("/v2/world", page)[0], 403)


if __name__ == "__main__":
    unittest.main()

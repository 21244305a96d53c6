#!/usr/bin/env python3
"""What opening an archive of ten million boxes reads over HTTP: one whose index alone is there."""

import json
import struct
import unittest

from raw_archive import made_up_facts, write_archive
from static_host import StaticHost
from support import Case, Run, Server, binary, temporary_folder

ENTRIES = 10_000_000
ENTRIES_OF_LEAF = 1024
LEAF_BYTES = 16_384
SIDE = 4096  # boxes
# A stranger's text: it would clear the terminal, and turn around what follows.
TITLE = "made up \x1b[2J\x9b2J\u202e"
HARMFUL = "[\x1b\x9b\u202e]"
LEVELS = 13
MAX_REQUESTS = 3
MAX_BYTES = 1 << 20


def place_on_curve(number):
    """bx and bz of a box of by 0, as the Morton curve passes them."""
    bits = range(SIDE.bit_length())
    return [sum((number >> (2 * n + axis) & 1) << n for n in bits) for axis in (0, 1)]


def root_of_the_index(begin):
    """@param begin where the records would begin @return the entries, and where they lie"""
    leaves = begin + 48 * ENTRIES
    root = bytearray()
    for first in range(0, ENTRIES, ENTRIES_OF_LEAF):
        bx, bz = place_on_curve(first)
        offset = leaves + first // ENTRIES_OF_LEAF * LEAF_BYTES
        count = min(ENTRIES_OF_LEAF, ENTRIES - first)
        root += struct.pack("<4iQ2IQ", 0, bx, 0, bz, offset, LEAF_BYTES, count, 0)
    return bytes(root), leaves + len(root) // 40 * LEAF_BYTES


def make_archive(file):
    """Header, facts and root are whole; leaves and records are holes of the file."""
    bounds = [0, 0, 0], [64 * SIDE, 256, 64 * SIDE]
    write_archive(file, made_up_facts(bounds, LEVELS, title=TITLE), root_of_the_index)


class LargeArchive(Case):
    @classmethod
    def setUpClass(cls):
        cls.folder = temporary_folder()
        cls.file = cls.folder / "large.tvx"
        make_archive(cls.file)

    def setUp(self):
        self.host = StaticHost(self.folder)
        self.addCleanup(self.host.stop)
        self.url = self.host.url + "large.tvx"

    def assertCheap(self):
        self.assertLessEqual(self.host.requests, MAX_REQUESTS, self.host.log)
        self.assertLessEqual(self.host.sent, MAX_BYTES, self.host.log)
        # The root of the index was read: the archive is open.
        self.assertGreater(self.host.sent, 40 * ENTRIES // ENTRIES_OF_LEAF)

    def test_the_tracer_opens_it(self):
        run = Run([binary("RAYTRACER"), "world", "info", self.url])
        self.assertDone(run)
        self.assertIn("made up", run.out)
        self.assertCheap()

    def test_its_title_does_not_speak_to_the_terminal(self):
        text = Run([binary("RAYTRACER"), "world", "info", self.file])
        self.assertIn(r"made up \x1b[2J\u009b2J\u202e", text.out)
        as_json = Run([binary("RAYTRACER"), "world", "info", self.file, "--json"])
        self.assertEqual(json.loads(as_json.out)["title"], TITLE)
        server = Server(self.file, "--cache", "none", "--no-ahead")
        self.assertEqual(server.stop(), 0, server.err)
        self.assertIn("made up", server.out)
        for said in (text.out, as_json.out, server.out):
            self.assertNotRegex(said, HARMFUL)

    def test_the_voxel_server_opens_it(self):
        server = Server(self.url, "--cache", "none", "--no-ahead")
        world = server.json("/v2/world")
        self.assertEqual(world["levels"], LEVELS)
        self.assertEqual(server.stop(), 0, server.err)
        self.assertCheap()


if __name__ == "__main__":
    unittest.main()

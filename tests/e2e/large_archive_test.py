#!/usr/bin/env python3
"""What opening an archive of ten million boxes reads over HTTP: one whose index alone is there."""

import json
import struct
import unittest

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
WORD = (1 << 64) - 1
PRIMES = (
    0x9E3779B185EBCA87,
    0xC2B2AE3D27D4EB4F,
    0x165667B19E3779F9,
    0x85EBCA77C2B2AE63,
    0x27D4EB2F165667C5,
)


def rotated(x, bits):
    return (x << bits | x >> (64 - bits)) & WORD


def turn(lane, word):
    return rotated((lane + word * PRIMES[1]) & WORD, 31) * PRIMES[0] & WORD


def xxh64(data):
    """Of a multiple of 8 bytes. Ref: Collet, xxHash specification 0.1.1."""
    at = 0
    value = PRIMES[4]
    if len(data) >= 32:
        lanes = [(PRIMES[0] + PRIMES[1]) & WORD, PRIMES[1], 0, -PRIMES[0] & WORD]
        for at in range(0, len(data) - 31, 32):
            words = struct.unpack_from("<4Q", data, at)
            lanes = [turn(lane, word) for lane, word in zip(lanes, words)]
        at += 32
        value = sum(rotated(lane, bits) for lane, bits in zip(lanes, (1, 7, 12, 18))) & WORD
        for lane in lanes:
            value = ((value ^ turn(0, lane)) * PRIMES[0] + PRIMES[3]) & WORD
    value = (value + len(data)) & WORD
    for (word,) in struct.iter_unpack("<Q", data[at:]):
        value = (rotated(value ^ turn(0, word), 27) * PRIMES[0] + PRIMES[3]) & WORD
    value = (value ^ value >> 33) * PRIMES[1] & WORD
    value = (value ^ value >> 29) * PRIMES[2] & WORD
    return value ^ value >> 32


def place_on_curve(number):
    """bx and bz of a box of by 0, as the Morton curve passes them."""
    bits = range(SIDE.bit_length())
    return [sum((number >> (2 * n + axis) & 1) << n for n in bits) for axis in (0, 1)]


def make_archive(file):
    """Header, facts and root are whole; leaves and records are holes of the file."""
    facts = {
        "version": 2,
        "software": "test",
        "title": TITLE,
        "bounds": {"min": [0, 0, 0], "max": [64 * SIDE, 256, 64 * SIDE]},
        "voxel_m": 1.0,
        "box": [64, 256, 64],
        "levels": LEVELS,
        "crs": "EPSG:3794",
        "crs_wkt": "",
        "crs_units_per_voxel": 1.0,
        "materials": ["air", "rock"],
        "licence": "CC0",
        "attribution": "nobody",
    }
    info = json.dumps(facts).encode()
    info += b" " * (-len(info) % 8)
    leaves = 64 + len(info) + 48 * ENTRIES
    root = bytearray()
    for first in range(0, ENTRIES, ENTRIES_OF_LEAF):
        bx, bz = place_on_curve(first)
        offset = leaves + first // ENTRIES_OF_LEAF * LEAF_BYTES
        count = min(ENTRIES_OF_LEAF, ENTRIES - first)
        root += struct.pack("<4iQ2IQ", 0, bx, 0, bz, offset, LEAF_BYTES, count, 0)
    at = leaves + len(root) // 40 * LEAF_BYTES
    size = at + len(root) + 8
    header = b"TVXARC\r\n" + struct.pack("<2I5Q", 1, 0, 64, len(info), at, len(root) + 8, size)
    with file.open("wb") as out:
        out.write(header + struct.pack("<Q", xxh64(header)) + info)
        out.seek(at)
        out.write(root + struct.pack("<Q", xxh64(bytes(root))))


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

    def test_the_server_of_the_file_shares_it(self):
        """Another server's archive, as a file that is served with ranges."""
        server = Server(self.file, "--cache", "none", "--no-ahead")
        run = Run([binary("RAYTRACER"), "world", "info", server.url + "/v2/archive.tvx"])
        self.assertDone(run)
        self.assertIn("made up", run.out)
        self.assertEqual(server.stop(), 0, server.err)


if __name__ == "__main__":
    unittest.main()

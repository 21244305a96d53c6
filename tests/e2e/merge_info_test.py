#!/usr/bin/env python3
"""Texts of a checkpoint do not speak to the terminal: titles, names of files, notes on damage.
A picture that is joined of parts with such a note is one with holes.
"""

import struct
import unittest

from raw_archive import made_up_facts, write_archive
from support import Case, Run, binary, render, temporary_folder

# They would clear the screen, colour what follows, and turn it around.
HOSTILE = "x\x1b[2J\x9b31m\u202e"
SHOWN = r"x\x1b[2J\u009b31m\u202e"
HARMFUL = "[\x1b\x9b\u202e]"
PART = ["--size", "32x32", "--tile", "16", "--samples", "1", "--quiet"]
NOTE = 3  # kind of a record: damage of the world's data
WORD = (1 << 64) - 1
# The beginning of XXH3's secret, as 64-bit numbers.
SECRET = struct.unpack(
    "<7Q",
    bytes.fromhex(
        "b8fe6c3923a44bbe7c01812cf721ad1cded46de9839097db7240a4a4b7b3671f"
        "cb79e64eccc0e578825ad07dccff7221b8084674f743248e"
    ),
)


def folded(a, b):
    """Both halves of the product together."""
    return (a * b ^ a * b >> 64) & WORD


def xxh3(data):
    """Of 9 to 16, or of 24 bytes. Ref: Collet, xxHash specification, XXH3 of short inputs."""
    low, high = struct.unpack("<Q", data[:8])[0], struct.unpack("<Q", data[-8:])[0]
    if len(data) == 24:
        (middle,) = struct.unpack("<Q", data[8:16])
        value = 24 * 0x9E3779B185EBCA87 + folded(low ^ SECRET[0], middle ^ SECRET[1])
        value += folded(middle ^ SECRET[2], high ^ SECRET[3])
    else:
        low ^= SECRET[3] ^ SECRET[4]
        high ^= SECRET[5] ^ SECRET[6]
        value = len(data) + int.from_bytes(low.to_bytes(8, "little"), "big") + high
        value += folded(low, high)
    value &= WORD
    value = (value ^ value >> 37) * 0x165667919E3779F9 & WORD
    return value ^ value >> 32


def note_on_damage(text):
    """@return a record (docs/formats/checkpoints.md)"""
    payload = text.encode()
    head = struct.pack("<4I", 0x9E01C57A, NOTE, 0, len(payload)) + struct.pack("<Q", xxh3(payload))
    return head + struct.pack("<Q", xxh3(head)) + payload


def merge(*arguments):
    return Run([binary("RAYTRACER"), "merge", *arguments])


class MergeInfo(Case):
    def setUp(self):
        self.folder = temporary_folder()

    def part(self, world, number=1):
        """@return the checkpoint of one of two parts of a picture, which has a usual name"""
        run = render(world, *PART, "--part", f"{number}/2", "-o", self.folder / "a.exr")
        self.assertDone(run)
        self.assertNotRegex(run.out + run.err, HARMFUL)
        return self.folder / f"a.exr.part-{number}-of-2.tiles"

    def info(self, part):
        run = merge("--info", part)
        self.assertDone(run)
        self.assertNotRegex(run.out + run.err, HARMFUL)
        return run.out

    def archive(self, name, **facts):
        file = self.folder / name
        write_archive(file, made_up_facts(([0, 0, 0], [64, 256, 64]), 1, **facts))
        return file

    def test_the_title_of_the_world(self):
        part = self.part(self.archive("a.tvx", title=HOSTILE))
        self.assertIn(f"of       {SHOWN}, 32x32 pixels", self.info(part))

    def test_notes_on_damage(self):
        part = self.part(self.archive("a.tvx"))
        with part.open("ab") as file:
            file.write(note_on_damage(HOSTILE))
        self.assertIn(f"damage   {SHOWN}\n", self.info(part))

    def test_damage_of_a_joined_picture(self):
        parts = [self.part(self.archive("a.tvx"), number) for number in (1, 2)]
        joined = self.folder / "joined.exr"
        self.assertDone(merge(*parts, "-o", joined, "--quiet"))
        joined.unlink()
        with parts[1].open("ab") as file:
            file.write(note_on_damage("a rotten box"))
        run = merge(*parts, "-o", joined, "--quiet")
        self.assertEqual(run.code, 3, str(run))
        self.assertIn("a rotten box", run.err)
        self.assertTrue(joined.exists())


if __name__ == "__main__":
    unittest.main()

"""Writes box archives of made-up contents, byte by byte (docs/formats/box-archive.md)."""

import json
import struct

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


def made_up_facts(bounds, levels, **more):
    """@param bounds of the voxels: the lowest corner, and the one after the highest"""
    return {
        "version": 2,
        "software": "test",
        "title": "made up",
        "bounds": {"min": bounds[0], "max": bounds[1]},
        "voxel_m": 1.0,
        "box": [64, 256, 64],
        "levels": levels,
        "crs": "EPSG:3794",
        "crs_wkt": "",
        "crs_units_per_voxel": 1.0,
        "materials": ["air", "rock"],
        "licence": "CC0",
        "attribution": "nobody",
        **more,
    }


def write_archive(file, facts, root=lambda begin: (b"", begin)):
    """Records and leaves are holes of the file, unless the caller writes them.

    @param root called with the offset behind the facts; returns the entries of the index' root,
    and the offset to write them at, behind all that they lead to
    """
    info = json.dumps(facts).encode()
    info += b" " * (-len(info) % 8)
    entries, at = root(64 + len(info))
    size = at + len(entries) + 8
    header = b"TVXARC\r\n" + struct.pack("<2I5Q", 1, 0, 64, len(info), at, len(entries) + 8, size)
    with file.open("wb") as out:
        out.write(header + struct.pack("<Q", xxh64(header)) + info)
        out.seek(at)
        out.write(entries + struct.pack("<Q", xxh64(entries)))

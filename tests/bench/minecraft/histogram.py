#!/usr/bin/env python3
"""Counts the blocks of Minecraft worlds with a reader that shares nothing with Terravox.

It consists of nbtlib from PyPI, and of slow, plain slicing of the rest.

    histogram.py PATH...
        prints {path: {chunks, damaged, blocks}} as JSON
    histogram.py PATH... --compare PROGRAM ARG
        runs `PROGRAM ARG... PATH` for each path, whose JSON is that of
        `world info --json --blocks`, prints a table, and fails when a count differs

A PATH is a folder with regions (in it or in its `region`) or Alpha chunks, a region, or one chunk.
Only the overworld is read. Air is not counted. Keys: "minecraft:stone", or "id:data" in chunks of
numeric ids.
"""

import argparse
import collections
import gzip
import io
import json
import pathlib
import struct
import subprocess
import sys
import zlib

import nbtlib

AIR = {"minecraft:air", "minecraft:cave_air", "minecraft:void_air"}
FIRST_PADDED = 2529  # 20w17a: indices no longer run across longs


def parse(raw):
    if raw[:2] == b"\x1f\x8b":
        raw = gzip.decompress(raw)
    elif raw[:1] == b"\x78":
        raw = zlib.decompress(raw)
    return nbtlib.File.parse(io.BytesIO(raw))


def region_chunks(path):
    data = path.read_bytes()
    for slot in range(1024):
        (location,) = struct.unpack_from(">I", data, 4 * slot)
        if location:
            begin = (location >> 8) * 4096
            length, kind = struct.unpack_from(">IB", data, begin)
            packed = data[begin + 5 : begin + 4 + length]
            yield parse(packed if kind in (1, 2, 3) else None)


def chunks(path):
    if path.is_file():
        if path.suffix in (".mca", ".mcr"):
            yield from region_chunks(path)
        else:
            yield parse(path.read_bytes())
        return
    folder = path / "region" if (path / "region").is_dir() else path
    regions = sorted(folder.glob("r.*.mca")) or sorted(folder.glob("r.*.mcr"))
    for region in regions:
        yield from region_chunks(region)
    if not regions:
        for chunk in sorted(path.rglob("c.*.*.dat")):
            yield parse(chunk.read_bytes())


def nibble(array, i):
    return (int(array[i // 2]) & 0xFF) >> (4 * (i % 2)) & 15


def count_numeric(blocks, data, add, counts):
    # Without air's data: a block of id 0 is air whatever they are.
    for i, low in enumerate(blocks):
        number = (int(low) & 0xFF) | (nibble(add, i) << 8 if add is not None else 0)
        if number:
            counts[f"{number}:{nibble(data, i) if data is not None else 0}"] += 1


def indices(longs, size, padded):
    bits = max(4, (size - 1).bit_length())
    words = [int(word) & (1 << 64) - 1 for word in longs]
    mask = (1 << bits) - 1
    if padded:
        each = 64 // bits
        return [words[i // each] >> bits * (i % each) & mask for i in range(4096)]
    bits = len(words) // 64
    mask = (1 << bits) - 1
    return [
        (
            words[i * bits // 64]
            | (words[i * bits // 64 + 1] << 64 if i * bits // 64 + 1 < len(words) else 0)
        )
        >> i * bits % 64
        & mask
        for i in range(4096)
    ]


def count_chunk(root, counts):
    version = int(root.get("DataVersion", 0))
    level = root.get("Level", root)
    if "Blocks" in level and "Sections" not in level:
        count_numeric(level["Blocks"], level["Data"], None, counts)
    for section in level.get("sections", level.get("Sections", [])):
        if "Blocks" in section:
            count_numeric(section["Blocks"], section.get("Data"), section.get("Add"), counts)
            continue
        states = section.get("block_states")
        palette = states.get("palette") if states is not None else section.get("Palette")
        longs = states.get("data") if states is not None else section.get("BlockStates")
        if palette is None:
            continue
        names = [str(entry["Name"]) for entry in palette]
        if len(names) == 1:
            counts[names[0]] += 4096
        else:
            for index, count in collections.Counter(
                indices(longs, len(names), version >= FIRST_PADDED)
            ).items():
                counts[names[index]] += count


def histogram(path):
    counts = collections.Counter()
    seen = 0
    damaged = 0
    for chunk in chunks(path):
        seen += 1
        count_chunk(chunk, counts)
    return {
        "chunks": seen,
        "damaged": damaged,
        "blocks": {name: n for name, n in sorted(counts.items()) if name not in AIR and n},
    }


def ours(command, path):
    facts = json.loads(
        subprocess.run([*command, str(path)], check=True, capture_output=True, text=True).stdout
    )
    world = next(d for d in facts["dimensions"] if d["name"] == "overworld")
    return {
        "chunks": world["chunks"]["all"],
        "damaged": world["chunks"]["damaged"],
        "blocks": world.get("blocks", {}),
    }


def main():
    arguments = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    arguments.add_argument("paths", nargs="+", type=pathlib.Path)
    arguments.add_argument(
        "--compare",
        nargs=argparse.REMAINDER,
        metavar="PROGRAM",
        help="a program and its arguments, to which the path is added",
    )
    options = arguments.parse_args()
    if not options.compare:
        json.dump({str(path): histogram(path) for path in options.paths}, sys.stdout, indent=1)
        print()
        return 0
    differing = 0
    print("| world | chunks | kinds of blocks | blocks | differing kinds |\n|---|---|---|---|---|")
    for path in options.paths:
        theirs = histogram(path)
        mine = ours(options.compare, path)
        kinds = set(theirs["blocks"]) | set(mine["blocks"])
        wrong = [kind for kind in kinds if theirs["blocks"].get(kind) != mine["blocks"].get(kind)]
        same_chunks = theirs["chunks"] == mine["chunks"]
        differing += len(wrong) + (0 if same_chunks else 1)
        chunk_text = (
            str(theirs["chunks"]) if same_chunks else f"{theirs['chunks']} / ours {mine['chunks']}"
        )
        print(
            f"| {'/'.join(path.parts[-2:])} | {chunk_text} | {len(kinds)} "
            f"| {sum(theirs['blocks'].values())} | {len(wrong)} |",
            flush=True,
        )
        for kind in sorted(wrong)[:10]:
            print(f"  {kind}: {theirs['blocks'].get(kind)} / ours {mine['blocks'].get(kind)}")
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main())

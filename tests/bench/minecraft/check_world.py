#!/usr/bin/env python3
"""Opens a written Minecraft world with independent readers and prints its contents.

The readers are nbtlib and anvil-parser2.

    python3 -m venv venv
    venv/bin/pip install --require-hashes -r ../../../config/setup/python/minecraft.txt
    venv/bin/python check_world.py WORLD [--every N] [--voxels N]

Every N-th chunk is counted block by block (anvil-parser2 reads some 10 a second), by block and,
with terravox.json, by material. Reads sections -4 to 19: worlds of the usual height. Exit code 1:
something is missing, or the blocks counted are not N (--voxels, with --every 1).
"""

import argparse
import collections
import json
import pathlib
import sys

import anvil
import nbtlib


def check_level(folder):
    data = nbtlib.load(folder / "level.dat")["Data"]
    spawn = [int(data["Spawn" + axis]) for axis in "XYZ"]
    generator = data["WorldGenSettings"]["dimensions"]["minecraft:overworld"]["generator"]
    print(
        f"{data['LevelName']}: version {data['Version']['Name']} ({int(data['DataVersion'])}), "
        f"spawn {spawn}, generator {generator['type']}, "
        f"packs {[str(p) for p in data['DataPacks']['Enabled']]}"
    )
    return spawn


def chunks_of(file):
    region = anvil.Region.from_file(str(file))
    rx, rz = (int(part) for part in file.name.split(".")[1:3])
    for z in range(rz * 32, rz * 32 + 32):
        for x in range(rx * 32, rx * 32 + 32):
            if region.chunk_location(x, z) != (0, 0):
                yield anvil.Chunk.from_region(region, x, z)


def count_chunk(chunk, blocks):
    for y in range(-4, 20):
        section = chunk.get_section(y)
        palette = chunk.get_palette(section)
        if len(palette) == 1:
            blocks[palette[0].name()] += 4096
        else:
            blocks.update(block.name() for block in chunk.stream_blocks(section=section))


def main():
    arguments = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    arguments.add_argument("world", type=pathlib.Path)
    arguments.add_argument("--every", type=int, default=1)
    arguments.add_argument("--voxels", type=int)
    options = arguments.parse_args()
    spawn = check_level(options.world)
    blocks = collections.Counter()
    chunks = 0
    counted = 0
    at_spawn = []
    for file in sorted((options.world / "region").glob("r.*.mca")):
        for chunk in chunks_of(file):
            if (chunk.x, chunk.z) == (spawn[0] >> 4, spawn[2] >> 4):
                at_spawn = [
                    chunk.get_block(spawn[0] & 15, spawn[1] + step, spawn[2] & 15).name()
                    for step in (-1, 0)
                ]
            if chunks % options.every == 0:
                count_chunk(chunk, blocks)
                counted += 1
            chunks += 1
    print(f"{chunks} chunks, {counted} counted; beneath the spawn and there: {at_spawn}")
    air = blocks.pop("minecraft:air", 0)
    solid = sum(blocks.values())
    print(f"{solid} blocks, {air} air")
    car_file = options.world / "terravox.json"
    meaning = json.loads(car_file.read_text())["blocks"] if car_file.exists() else {}
    materials = collections.Counter()
    for name, count in blocks.most_common():
        print(f"  {count:12d} {name}  {meaning.get(name, '')}")
        materials[meaning.get(name, "?")] += count
    print("by material:", dict(materials.most_common()))
    unknown = [name for name in blocks if meaning and name not in meaning]
    wrong = bool(unknown) or chunks == 0 or (options.voxels is not None and solid != options.voxels)
    if wrong:
        print(
            f"WRONG: without meaning {unknown}, {chunks} chunks, {solid} blocks of {options.voxels}"
        )
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env bash
# anvil-parser2 0.10.6 and anvil-parser-modern 0.10.0 (PyPI), Chunk.get_block() on a chunk of the
# Java edition 1.16.5: where a section's indices have more bits than its palette needs, most blocks
# that they return are not those that were stored, and there is no error.
#
# A good guess: a palette of 16 blocks has indices of 4 bits, as descriptions of the format say.
# What happens: the games of 1.16 and 1.17 take the number of bits from the length of the array
# (BlockStates), longs / 64 rounded down, and there are worlds with more bits than the palette needs
# (issues 78 of mcmap and 55 of prismarine-provider-anvil); 1.18 and later refuse them. Both readers
# take 4 bits.
#
# Output seen (blocks of the section that come back as stored, of 4096):
#   anvil-parser2 0.10.6         4 bits 4096, 5 bits 258, 8 bits 256
#   anvil-parser-modern 0.10.0   4 bits 4096, 5 bits 258, 8 bits 256
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
cat >blocks.py <<'PYTHON'
import struct
import sys
import zlib

import anvil

COLOURS = "white orange magenta light_blue yellow lime pink gray".split()
NAMES = [f"{colour}_{kind}" for kind in ("wool", "concrete") for colour in COLOURS]
CELLS = [(i * 7 + i // 256) % 16 for i in range(4096)]


def text(value):
    return struct.pack(">H", len(value)) + value.encode()


def field(kind, name, payload):
    return bytes([kind]) + text(name) + payload


def compound(*fields):
    return b"".join(fields) + b"\0"


def number(name, value):
    return field(3, name, struct.pack(">i", value))


def many(name, items=()):
    return field(9, name, struct.pack(">bi", 10, len(items)) + b"".join(items))


def packed(bits):
    each = 64 // bits
    longs = [
        sum(cell << k * bits for k, cell in enumerate(CELLS[i : i + each]))
        for i in range(0, 4096, each)
    ]
    return struct.pack(f">i{len(longs)}Q", len(longs), *longs)


def as_stored(bits):
    """@return how many blocks of a chunk of one section are read as they were stored"""
    palette = [compound(field(8, "Name", text(f"minecraft:{name}"))) for name in NAMES]
    states = field(12, "BlockStates", packed(bits))
    section = compound(field(1, "Y", b"\0"), many("Palette", palette), states)
    empty = [many(name) for name in ("TileEntities", "Entities", "TileTicks", "LiquidTicks")]
    level = compound(
        number("xPos", 0),
        number("zPos", 0),
        field(8, "Status", text("full")),
        many("Sections", [section]),
        *empty,
    )
    chunk = zlib.compress(
        b"\x0a\0\0" + compound(number("DataVersion", 2586), field(10, "Level", level))
    )
    with open("r.0.0.mca", "wb") as region:
        region.write(struct.pack(">I", 2 << 8 | 2).ljust(8192, b"\0"))
        region.write((struct.pack(">IB", len(chunk) + 1, 2) + chunk).ljust(8192, b"\0"))
    read = anvil.Chunk.from_region(anvil.Region.from_file("r.0.0.mca"), 0, 0)
    return sum(
        read.get_block(i % 16, i // 256, i // 16 % 16).id == NAMES[CELLS[i]] for i in range(4096)
    )


found = ", ".join(f"{bits} bits {as_stored(bits)}" for bits in (4, 5, 8))
print(f"{sys.argv[1]:28} {found}")
PYTHON
for reader in anvil-parser2==0.10.6 anvil-parser-modern==0.10.0; do
  python3 -m venv --clear venv
  venv/bin/pip --quiet --disable-pip-version-check install "$reader" NBT==1.5.1 frozendict==2.5.1
  venv/bin/python blocks.py "${reader/==/ }"
done >seen
cat seen
diff - seen <<'SEEN'
anvil-parser2 0.10.6         4 bits 4096, 5 bits 258, 8 bits 256
anvil-parser-modern 0.10.0   4 bits 4096, 5 bits 258, 8 bits 256
SEEN

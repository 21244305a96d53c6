"""Makes a small Luanti world: an island with trees in a sea."""

import contextlib
import sqlite3
import struct
import zlib

NAMES = [
    "air",
    "default:stone",
    "default:dirt_with_grass",
    "default:water_source",
    "default:tree",
    "default:leaves",
    "default:sand",
]
AIR, STONE, GRASS, WATER, TREE, LEAVES, SAND = range(len(NAMES))
SEA = 5
TRUNKS = [(-20, 10), (8, 22), (30, -14), (-34, -30), (18, -38)]
BLOCKS = range(-4, 4)


def height(x, z):
    """Ground of an island, in nodes."""
    return 14 - (x * x + z * z) // 180


def node(x, y, z):
    """What stands at a place, in the game's axes."""
    for tree_x, tree_z in TRUNKS:
        top = height(tree_x, tree_z) + 6
        if (x, z) == (tree_x, tree_z) and height(x, z) <= y < top:
            return TREE
        if abs(x - tree_x) + abs(y - top) + abs(z - tree_z) <= 3:
            return LEAVES
    ground = height(x, z)
    if y >= ground:
        return WATER if y < SEA else AIR
    if y < ground - 1:
        return STONE
    return GRASS if ground > SEA + 1 else SAND


def map_block(bx, by, bz):
    """A map block of version 28, which Python's own zlib can write."""
    ids = [
        node(16 * bx + x, 16 * by + y, 16 * bz + z)
        for z in range(16)
        for y in range(16)
        for x in range(16)
    ]
    nodes = struct.pack(">4096H", *ids) + bytes(2 * 4096)
    names = b"".join(
        struct.pack(">HH", number, len(name)) + name.encode() for number, name in enumerate(NAMES)
    )
    return b"".join(
        [
            struct.pack(">BBHBB", 28, 0, 0xFFFF, 2, 2),
            zlib.compress(nodes),
            zlib.compress(b"\x02\x00\x00"),  # no metadata
            struct.pack(">BHI", 0, 0, 0),  # no objects; time
            struct.pack(">BH", 0, len(NAMES)),
            names,
            struct.pack(">BH", 10, 0),  # no timers
        ]
    )


def write_world(folder):
    """@return the folder"""
    folder.mkdir(parents=True)
    settings = "gameid = minetest\nworld_name = Isle\nbackend = sqlite3\n"
    (folder / "world.mt").write_text(settings)
    with contextlib.closing(sqlite3.connect(folder / "map.sqlite")) as database:
        database.execute("CREATE TABLE blocks (pos INT NOT NULL PRIMARY KEY, data BLOB)")
        for bx in BLOCKS:
            for bz in BLOCKS:
                for by in range(-2, 3):
                    row = (bz * 16777216 + by * 4096 + bx, map_block(bx, by, bz))
                    database.execute("INSERT INTO blocks VALUES (?, ?)", row)
        database.commit()
    return folder

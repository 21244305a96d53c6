"""Writes small Minecraft worlds, as the game and others do, with the standard library alone.

A world has four chunks around its origin in each dimension: stone up to 66, then dirt and grass.
"""

import dataclasses
import gzip
import struct
import zipfile
import zlib

STONE, DIRT, GRASS = "minecraft:stone", "minecraft:dirt", "minecraft:grass_block"
OVERWORLD = "dimensions/minecraft/overworld/region/"
NETHER = "dimensions/minecraft/the_nether/region/"
DEEP = "dimensions/modid/some/deep/name/region/"
LIST, COMPOUND = 9, 10


def text(value):
    return struct.pack(">H", len(value)) + value.encode()


def field(kind, name, payload):
    return bytes([kind]) + text(name) + payload


def number(name, value):
    return field(3, name, struct.pack(">i", value))


def string(name, value):
    return field(8, name, text(value))


def compound(*fields):
    return b"".join(fields) + b"\0"


def many(name, items):
    return field(LIST, name, struct.pack(">bi", COMPOUND, len(items)) + b"".join(items))


def longs(name, cells, bits):
    """Indices that do not run across longs, as since 1.16."""
    each = 64 // bits
    packed = [
        sum(cell << k * bits for k, cell in enumerate(cells[i : i + each]))
        for i in range(0, 4096, each)
    ]
    return field(12, name, struct.pack(f">i{len(packed)}Q", len(packed), *packed))


def bits_for(names):
    return max(4, (len(names) - 1).bit_length())


def chunk(x, z, version, names=(), bits=0):
    """A chunk of one section from 64 on: of three layers, or of a cell of each name."""
    layers = ["minecraft:air", STONE, DIRT, GRASS]
    cells = [1] * 512 + [2] * 256 + [3] * 256 + [0] * 3072
    if names:
        layers = ["minecraft:air", *names]
        cells = [*range(len(layers)), *[0] * (4096 - len(layers))]
    palette = [compound(string("Name", name)) for name in layers]
    bits = bits or bits_for(layers)
    place = [number("xPos", x), number("zPos", z), string("Status", "minecraft:full")]
    height = field(1, "Y", b"\4")
    if version >= 2860:
        states = compound(many("palette", palette), longs("data", cells, bits))
        section = compound(height, field(COMPOUND, "block_states", states))
        fields = [*place, many("sections", [section])]
    else:
        section = compound(height, many("Palette", palette), longs("BlockStates", cells, bits))
        level = compound(*place, many("Sections", [section]))
        fields = [field(COMPOUND, "Level", level)]
    return b"\x0a\0\0" + compound(number("DataVersion", version), *fields)


def region(version, **facts):
    table, body = bytearray(8192), b""
    for i in range(4):
        x, z = i % 2, i // 2
        record = zlib.compress(chunk(x, z, version, **facts))
        record = struct.pack(">IB", len(record) + 1, 2) + record
        sectors = -(-len(record) // 4096)
        first = (len(table) + len(body)) // 4096
        struct.pack_into(">I", table, 4 * (x + 32 * z), first << 8 | sectors)
        body += record.ljust(4096 * sectors, b"\0")
    return bytes(table) + body


def level_dat(version):
    data = compound(string("LevelName", "w"), number("DataVersion", version))
    return gzip.compress(b"\x0a\0\0" + compound(field(COMPOUND, "Data", data)))


def world(version, files=None, regions=("region/",), **facts):
    """@return the files of a world by their names"""
    whole = {folder + "r.0.0.mca": region(version, **facts) for folder in regions}
    return {"level.dat": level_dat(version), **whole, **(files or {})}


# Little-endian, behind a version and a length, as the Bedrock edition writes level.dat.
BEDROCK = {
    "level.dat": struct.pack("<II", 10, 8) + b"\x0a\0\0\0\0\0\0\0",
    "levelname.txt": b"My World",
    "db/CURRENT": b"MANIFEST-000004\n",
    "db/MANIFEST-000004": b"",
    "db/000005.ldb": b"",
}
# Of 26.2 and 26.3.
NEW_NAMES = [
    "minecraft:" + name
    for names in (
        ("sulfur", "potent_sulfur", "sulfur_spike", "polished_sulfur_wall", "chiseled_sulfur"),
        ("sulfur_brick_stairs", "cinnabar", "cinnabar_bricks", "chiseled_cinnabar"),
        ("polished_cinnabar_slab", "poplar_log", "poplar_wood", "stripped_poplar_log"),
        ("poplar_planks", "poplar_shelf", "poplar_wall_hanging_sign", "poplar_sapling"),
        ("potted_poplar_sapling", "red_poplar_leaves", "yellow_poplar_leaves", "red_shrub"),
        ("shelf_mushroom", "straw_bed", "white_wool_slab", "light_gray_wool_stairs"),
        ("black_concrete_slab", "pink_concrete_stairs"),
    )
    for name in names
]


@dataclasses.dataclass
class Row:
    """Files, packed into an archive where it is named, and what is right."""

    name: str
    files: dict
    archive: str = ""
    part: str = ""  # the path that is given, from the folder of the files
    versions: dict = dataclasses.field(default_factory=dict)  # of the overworld's chunks
    dimensions: tuple = ("overworld",)
    damaged: int = 0  # chunks
    damage: str = ""  # a part of the one line; without it there is none
    note: str = ""  # likewise
    says: str = ""  # a part of a warning
    refused: str = ""
    has_tables: bool = False  # all of its blocks are in the tables

    def write(self, folder):
        """@return the path to give"""
        if self.archive:
            with zipfile.ZipFile(folder / self.archive, "w") as archive:
                for name, content in self.files.items():
                    archive.writestr(name, content)
            return folder / self.archive
        for name, content in self.files.items():
            (folder / "w" / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / "w" / name).write_bytes(content)
        return folder / "w" / self.part


def readable(name, version, release, facts=None, **right):
    """@param facts of the world, by the names of world()'s parameters"""
    return Row(name, world(version, **(facts or {})), versions={release: 4}, **right)


def beside(content):
    return {"files": {"region/r.1.0.mca": content}}


IN_DIMENSIONS = {"regions": (OVERWORLD,)}
ROWS = [
    readable("1.16 with more bits than needed", 2586, "1.16.5", {"bits": 5}),
    readable("1.17 with bits for all the game's blocks", 2730, "1.17.1", {"bits": 16}),
    readable("1.18 with the bits that are needed", 2865, "1.18.1"),
    Row(
        "1.16 with fewer bits than needed",
        world(2586, names=NEW_NAMES[:20], bits=4),
        damaged=4,
        damage="chunk 0, 0: section y = 4: 256 longs of indices for a palette of 21",
    ),
    Row(
        "1.18 with more bits, which the game refuses",
        world(2865, bits=5),
        damaged=4,
        damage="chunk 0, 0: section y = 4: 342 longs of indices for a palette of 4 blocks",
    ),
    readable(
        "a region of no bytes",
        2586,
        "1.16.5",
        beside(b""),
        note="region/r.1.0.mca: an empty file",
    ),
    readable("a region of a head alone", 2586, "1.16.5", beside(bytes(8192))),
    readable(
        "a region that ends in its table",
        2586,
        "1.16.5",
        beside(bytes(5000)),
        damage="region/r.1.0.mca: 5000 bytes; a region has 8192 at least",
    ),
    readable("1.21.9", 4554, "1.21.9"),
    readable("1.21.11", 4671, "1.21.11"),
    readable("26.1", 4786, "26.1", IN_DIMENSIONS),
    readable(
        "26.3 with dimensions of a mod",
        5023,
        "26.3",
        {"regions": (OVERWORLD, NETHER, DEEP)},
        dimensions=("overworld", "modid:some/deep/name", "nether"),
    ),
    readable("26.2 without level.dat", 4903, "26.2", IN_DIMENSIONS, part=OVERWORLD),
    Row(
        "both places of the overworld, 26.2",
        world(4903, {OVERWORLD + "r.0.0.mca": region(4903)}) | {"region/r.0.0.mca": region(2586)},
        versions={"26.2": 4},
        note="region: passed over, the game since 26.1 reads dimensions/minecraft/overworld/region",
        says="region: passed over",
    ),
    Row(
        "both places of the overworld, 1.21.11",
        world(4671, {OVERWORLD + "r.0.0.mca": region(4903)}),
        versions={"1.21.11": 4},
        note="dimensions/minecraft/overworld/region: passed over, the game of level.dat, before",
        says="dimensions/minecraft/overworld/region: passed over",
    ),
    readable("a packed world", 5023, "26.3", IN_DIMENSIONS, archive="w.zip"),
    readable("a packed world under another name", 5023, "26.3", archive="w.backup"),
    Row(
        "two packed worlds",
        {f"{name}/{file}": content for name in "ab" for file, content in world(5023).items()},
        archive="w.zip",
        refused="it holds 2 worlds (a, b)",
    ),
    Row("Bedrock", BEDROCK, refused="the Bedrock edition"),
    Row("Bedrock's level.dat", BEDROCK, part="level.dat", refused="the Bedrock edition"),
    Row("Bedrock's database", BEDROCK, part="db", refused="the Bedrock edition"),
    Row("Bedrock, exported", BEDROCK, archive="w.mcworld", refused="the Bedrock edition"),
    Row(
        "Bedrock, packed within a folder",
        {f"My World/{name}": content for name, content in BEDROCK.items()},
        archive="w.zip",
        refused="the Bedrock edition",
    ),
    Row(
        "regions of servers alone",
        {"level.dat": level_dat(2865), "region/r.0.0.linear": b"\xc3\xff\x13\x18\x3c\xca\x9d\x9a"},
        refused="of the linear format (region/r.0.0.linear)",
    ),
    readable("blocks of 26.3", 5023, "26.3", {"names": NEW_NAMES}, has_tables=True),
]

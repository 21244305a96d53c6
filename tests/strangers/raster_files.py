"""Writes small rasters, as programs of others do, with the standard library alone.

The place: the 32 m x 32 m of las_files, from its south-west corner 462000, 101000 of EPSG:3794.
"""

import dataclasses
import struct

from las_files import SIDE_M, SOUTH, WEST

NORTH = SOUTH + SIDE_M
METRES = ((1024, 1), (1025, 1), (3072, 3794))
DEGREES = ((1024, 2), (1025, 1), (2048, 4326))
MINISWHITE, MINISBLACK, RGB, PALETTE, CMYK = 0, 1, 2, 3, 5
ALPHA, OTHER = 2, 0
UNSIGNED, SIGNED, FLOAT = 1, 2, 3
# Types of TIFF's fields, with their letters in struct.
SHORT, LONG, ASCII, DOUBLE = (3, "H"), (4, "I"), (2, "s"), (12, "d")
LETTERS = {
    (8, UNSIGNED): "B",
    (8, SIGNED): "b",
    (16, UNSIGNED): "H",
    (16, SIGNED): "h",
    (32, UNSIGNED): "I",
    (32, FLOAT): "f",
    (64, FLOAT): "d",
}


def item(name, text, sample=None, role=None):
    """One of GDAL's items of metadata."""
    more = "" if sample is None else f' sample="{sample}"'
    more += "" if role is None else f' role="{role}"'
    return f'<Item name="{name}"{more}>{text}</Item>'


def descriptions(*names):
    return "".join(item("DESCRIPTION", n, i, "description") for i, n in enumerate(names))


@dataclasses.dataclass
class Tiff:
    """A GeoTIFF of one strip; north up unless its steps say another thing."""

    bands: tuple  # of each: a value, or a function of column and row
    bits: int = 8
    kind: int = UNSIGNED
    photometric: int | None = None
    extra: tuple = ()  # what samples beyond those of the photometric interpretation are
    palette: object = None  # a function of an index: red, green, blue
    nodata: str | None = None
    items: str = ""  # of GDAL's metadata
    keys: tuple = METRES
    corner: tuple = (WEST, NORTH)
    step: tuple = (0.5, -0.5)  # to the next column and row
    turned: tuple = (0, 0)  # what a row adds to x, and a column to y
    point: bool = False  # the corner is the middle of the first pixel
    size: int = 64

    def write(self, file):
        pixels = self.pixels()
        tags = {
            256: (LONG, (self.size,)),
            257: (LONG, (self.size,)),
            258: (SHORT, (self.bits,) * len(self.bands)),
            259: (SHORT, (1,)),
            262: (SHORT, (self.interpretation(),)),
            273: (LONG, (8,)),
            277: (SHORT, (len(self.bands),)),
            278: (LONG, (self.size,)),
            279: (LONG, (len(pixels),)),
            339: (SHORT, (self.kind,) * len(self.bands)),
            34735: (SHORT, self.directory()),
            **self.place(),
        }
        if self.extra:
            tags[338] = (SHORT, self.extra)
        if self.palette:
            colours = [self.palette(i) for i in range(1 << self.bits)]
            tags[320] = (SHORT, tuple(257 * c[channel] for channel in range(3) for c in colours))
        if self.nodata is not None:
            tags[42113] = (ASCII, self.nodata)
        if self.items:
            tags[42112] = (ASCII, f"<GDALMetadata>{self.items}</GDALMetadata>")
        at = 8 + len(pixels) + len(pixels) % 2
        file.write_bytes(
            struct.pack("<2sHI", b"II", 42, at) + pixels.ljust(at - 8, b"\0") + written(tags, at)
        )

    def interpretation(self):
        if self.photometric is not None:
            return self.photometric
        if self.palette:
            return PALETTE
        return RGB if len(self.bands) - len(self.extra) >= 3 else MINISBLACK

    def place(self):
        x, y = self.corner
        if self.turned != (0, 0):
            matrix = (self.step[0], self.turned[0], 0, x, self.turned[1], self.step[1], 0, y)
            return {34264: (DOUBLE, (*matrix, *([0] * 7), 1))}
        if self.step[1] > 0:
            return {34264: (DOUBLE, (self.step[0], 0, 0, x, 0, self.step[1], 0, y, *([0] * 7), 1))}
        return {
            33550: (DOUBLE, (self.step[0], -self.step[1], 0)),
            33922: (DOUBLE, (0, 0, 0, x, y, 0)),
        }

    def directory(self):
        keys = dict(self.keys)
        if self.point:
            keys[1025] = 2
        out = [1, 1, 0, len(keys)]
        for key, value in sorted(keys.items()):
            out += [key, 0, 1, value]
        return tuple(out)

    def pixels(self):
        values = [
            [band(x, y) if callable(band) else band for band in self.bands]
            for y in range(self.size)
            for x in range(self.size)
        ]
        letter = LETTERS.get((self.bits, self.kind))
        if letter:
            flat = [value for pixel in values for value in pixel]
            return struct.pack(f"<{len(flat)}{letter}", *flat)
        rows = []
        for y in range(self.size):
            row = "".join(
                f"{value:0{self.bits}b}"
                for pixel in values[y * self.size : (y + 1) * self.size]
                for value in pixel
            )
            row = row.ljust(-(-len(row) // 8) * 8, "0")
            rows.append(int(row, 2).to_bytes(len(row) // 8, "big"))
        return b"".join(rows)


def written(tags, at):
    """A directory and its values behind it. @param at where it begins in the file"""
    entries = b""
    values = b""
    values_at = at + 2 + 12 * len(tags) + 4
    for tag, ((number, letter), what) in sorted(tags.items()):
        if letter == "s":
            value = what.encode() + b"\0"
            count = len(value)
        else:
            value = struct.pack(f"<{len(what)}{letter}", *what)
            count = len(what)
        if len(value) > 4:
            entries += struct.pack("<2H2I", tag, number, count, values_at + len(values))
            values += value + b"\0" * (len(value) % 2)
        else:
            entries += struct.pack("<2HI", tag, number, count) + value.ljust(4, b"\0")
    return struct.pack("<H", len(tags)) + entries + struct.pack("<I", 0) + values


def heights(**facts):
    """A grid of 32 x 32 heights of 1 m x 1 m."""
    bits = facts.get("bits", 32)
    kind = FLOAT if bits == 32 else UNSIGNED
    return Tiff(**{"bits": bits, "kind": kind, "size": 32, "step": (1, -1), **facts})


def grid_of_text(rows, nodata="NODATA_value -9999\n"):
    """An Esri ASCII grid of 10 m cells."""
    head = f"ncols {len(rows[0])}\nnrows {len(rows)}\nxllcorner {WEST}\nyllcorner {SOUTH}\n"
    text = head + "cellsize 10\n" + nodata + "".join(" ".join(row) + "\n" for row in rows)
    return lambda file: file.write_text(text, encoding="utf-8")

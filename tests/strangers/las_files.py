"""Writes small LAS files, as programs of others do, with the standard library alone.

The place: 32 m x 32 m of level ground at 100 m, a point each half metre, south-west corner
462000, 101000 of EPSG:3794.
"""

import dataclasses
import struct

WEST, SOUTH, SIDE_M, STEP_M = 462000, 101000, 32, 0.5
SCALE_M = 0.001
GROUND = 2
# Bytes of a header by the minor version, and of a point by its format.
HEADER_BYTES = {2: 227, 3: 235, 4: 375, 5: 393}
POINT_BYTES = {1: 28, 3: 34, 6: 30, 7: 36}

WKT = (
    'PROJCS["Slovenia 1996 / Slovene National Grid",GEOGCS["Slovenia 1996",'
    'DATUM["Slovenia_Geodetic_Datum_1996",SPHEROID["GRS 1980",6378137,298.257222101]],'
    'PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433],AUTHORITY["EPSG","4765"]],'
    'PROJECTION["Transverse_Mercator"],PARAMETER["latitude_of_origin",0],'
    'PARAMETER["central_meridian",15],PARAMETER["scale_factor",0.9999],'
    'PARAMETER["false_easting",500000],PARAMETER["false_northing",-5000000],UNIT["metre",1],'
    'AUTHORITY["EPSG","3794"]]'
)
GEOGRAPHIC = (
    'GEOGCS["GCS_WGS_1984",DATUM["D_WGS_1984",SPHEROID["WGS_1984",6378137.0,298.257223563]],'
    'PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]]'
)
GEOCENTRIC = (
    'GEOCCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],'
    'PRIMEM["Greenwich",0],UNIT["metre",1],'
    'AXIS["Geocentric X",OTHER],AXIS["Geocentric Y",OTHER],AXIS["Geocentric Z",NORTH]]'
)
SITE_GRID = (
    'LOCAL_CS["Site grid",LOCAL_DATUM["Site",0],UNIT["metre",1],AXIS["X",EAST],AXIS["Y",NORTH]]'
)


@dataclasses.dataclass
class Record:
    """A variable-length record."""

    user: str
    id: int
    payload: bytes


def wkt_record(text=WKT):
    return Record("LASF_Projection", 2112, text.encode() + b"\0")


def key_record(*keys):
    """GeoTIFF keys: pairs of a key and its value; without any, those of EPSG:3794."""
    keys = keys or ((1024, 1), (1025, 1), (3072, 3794))
    body = b"".join(struct.pack("<4H", key, 0, 1, value) for key, value in sorted(keys))
    return Record("LASF_Projection", 34735, struct.pack("<4H", 1, 1, 0, len(keys)) + body)


def copc_records():
    """Those that a program copies which knows nothing of COPC: they fit another file."""
    info = struct.pack("<5d2Q2d", WEST + 16, SOUTH + 16, 116, 16, 1, 1_000_000, 32, 0, 0)
    return Record("copc", 1, info.ljust(160, b"\0"))


@dataclasses.dataclass
class Las:
    minor: int = 4
    point_format: int = 6
    records: tuple = ()
    extended: tuple = ()  # records behind the points, of LAS 1.4 and later
    red: object = None  # a function of a point's number
    classification: int = GROUND
    extended_at: int | None = None  # instead of where they are
    extra_record_bytes: int = 0  # that each extended record is longer than it is

    def places(self):
        across = int(SIDE_M / STEP_M)
        for i in range(across * across):
            yield i % across * STEP_M + STEP_M / 2, i // across * STEP_M + STEP_M / 2

    def point(self, number, x, y):
        red = self.red(number) if self.red else 0
        at = struct.pack("<3i", round(x / SCALE_M), round(y / SCALE_M), 0)
        if self.point_format >= 6:
            rest = struct.pack("<HBBBBhHd", 1000, 0x11, 0, self.classification, 0, 0, 1, 1.0)
        else:
            rest = struct.pack("<HBBbBHd", 1000, 0x09, self.classification, 0, 0, 1, 1.0)
        colour = struct.pack("<3H", red, red // 2, red // 4)
        return at + rest + (colour if self.point_format in (3, 7) else b"")

    def write(self, file):
        points = b"".join(self.point(i, *at) for i, at in enumerate(self.places()))
        size = POINT_BYTES[self.point_format]
        count = len(points) // size
        assert count * size == len(points)
        records = b"".join(
            struct.pack("<H16sHH32s", 0, r.user.encode(), r.id, len(r.payload), b"") + r.payload
            for r in self.records
        )
        extended = b"".join(
            struct.pack(
                "<H16sHQ32s",
                0,
                r.user.encode(),
                r.id,
                len(r.payload) + self.extra_record_bytes,
                b"",
            )
            + r.payload
            for r in self.extended
        )
        header_bytes = HEADER_BYTES[self.minor]
        points_at = header_bytes + len(records)
        old_count = 0 if self.minor >= 4 and self.point_format >= 6 else count
        head = struct.pack(
            "<4sHH16sBB32s32sHHHIIBHI5I",
            *(b"LASF", 0, 16 if self.point_format >= 6 else 0, b"", 1, self.minor, b"", b""),
            *(1, 2026, header_bytes, points_at, len(self.records)),
            *(self.point_format, size, old_count, old_count, 0, 0, 0, 0),
        )
        far = SIDE_M - STEP_M / 2
        head += struct.pack("<3d3d", *([SCALE_M] * 3), WEST, SOUTH, 100)
        head += struct.pack("<6d", WEST + far, WEST + 0.25, SOUTH + far, SOUTH + 0.25, 100, 100)
        if self.minor >= 3:
            head += struct.pack("<Q", 0)
        if self.minor >= 4:
            at = self.extended_at
            if at is None:
                at = points_at + len(points) if self.extended else 0
            head += struct.pack("<QIQ15Q", at, len(self.extended), count, count, *([0] * 14))
        head = head.ljust(header_bytes, b"\0")
        file.write_bytes(head + records + points + extended)

"""Photographs."""

from checks import COLOUR, SLOVENIA, SURVEY, Row, Strangers, translated, with_prj
from las_files import GEOGRAPHIC, SOUTH, WEST
from raster_files import (
    ALPHA,
    DEGREES,
    FLOAT,
    MINISBLACK,
    MINISWHITE,
    NORTH,
    OTHER,
    SIGNED,
    Tiff,
    descriptions,
    heights,
    item,
)

from support import only_in_all

SEEN = dict(zip(("red", "green", "blue"), COLOUR, strict=True))


def photo(name, bands=COLOUR, says="", means=None, **facts):
    tiff = Tiff(tuple(bands), **{k: v for k, v in facts.items() if k in Tiff.__dataclass_fields__})
    row = {k: v for k, v in facts.items() if k not in Tiff.__dataclass_fields__}
    means = SEEN if means is None and not row.get("refused") else means or {}
    row = {"ending": "tif", "write": tiff.write, "under": SURVEY, **row}
    return Row(name, says=says, means=means, **row)


def times(factor):
    return tuple(value * factor for value in COLOUR)


TWELVE = "12 bits: 4095 is white; if another value is, make images of 8 bits: gdal_translate"
SENTINEL = descriptions("B02 (blue)", "B03 (green)", "B04 (red)")
TURNED = (40, 40, 200)

PHOTO_ROWS = [
    photo("8 bits"),
    photo("8 bits in 16", bits=16, notes="from 0 to 200 are taken for 8 bits: 255 is white"),
    photo("12 bits in 16", times(16), TWELVE, bits=16),
    photo("12 bits, as the file states", times(16), bits=12),
    photo("16 bits", times(256), bits=16, notes="are taken for 16 bits: 65535 is white"),
    photo(
        "12 bits in 16 with a white edge",
        tuple(lambda x, y, v=v: 65535 if y < 4 else 16 * v for v in COLOUR),
        TWELVE,
        bits=16,
        means={"red": 203.4, "green": 53.4},
    ),
    photo(
        "12 bits in 16 with one hot pixel",
        tuple(lambda x, y, v=v: 60000 if (x, y) == (3, 3) else 16 * v for v in COLOUR),
        TWELVE,
        bits=16,
    ),
    photo(
        "reflectance in parts of 10000",
        tuple(round(v / 255 * 10000) for v in COLOUR),
        "reflectance in parts of 10000: 10000 is white",
        bits=16,
    ),
    photo(
        "reflectance with scale and offset",
        tuple(round(v / 255 * 10000) + 1000 for v in COLOUR),
        bits=16,
        items="".join(
            item("SCALE", "0.0001", i, "scale") + item("OFFSET", "-0.1", i, "offset")
            for i in range(3)
        ),
        notes="are taken for parts of 1: 1 is white",
    ),
    photo("signed 16 bits", times(16), TWELVE, bits=16, kind=SIGNED),
    photo("0 to 1", times(1 / 255), bits=32, kind=FLOAT, notes="are taken for parts of 1"),
    photo("0 to 255", bits=32, kind=FLOAT, notes="are taken for 0 to 255: 255 is white"),
    photo(
        "0 to 1 with nan",
        tuple(lambda x, y, v=v: float("nan") if x < 32 else v / 255 for v in COLOUR),
        bits=64,
        kind=FLOAT,
        covered=0.5,
    ),
    photo(
        "the lowest number is no data",
        tuple(lambda x, y, v=v: -1.7976931348623157e308 if x < 32 else v / 255 for v in COLOUR),
        bits=64,
        kind=FLOAT,
        nodata="-1.7976931348623157e+308",
        covered=0.5,
    ),
    photo(
        "12 bits with a scale to radiance",
        times(16),
        TWELVE,
        bits=16,
        items="".join(item("SCALE", "0.01", i, "scale") for i in range(3)),
    ),
    photo("black", (0, 0, 0), "all of it that was read is black", means={"red": 0}),
    photo(
        "black of 16 bits",
        (0, 0, 0),
        "all of it that was read is black",
        bits=16,
        means={"red": 0},
    ),
    photo(
        "no data declared",
        tuple(lambda x, y, v=v: 0 if x < 32 else v for v in COLOUR),
        nodata="0",
        covered=0.5,
    ),
    photo("named as Sentinel-2", TURNED, photometric=MINISBLACK, extra=(0, 0), items=SENTINEL),
    photo(
        "numbered as Sentinel-2",
        TURNED,
        photometric=MINISBLACK,
        extra=(0, 0),
        items=descriptions("B2", "B3", "B4"),
    ),
    photo(
        "in words",
        TURNED,
        photometric=MINISBLACK,
        extra=(0, 0),
        items=descriptions("Blue band", "Green band", "Red band"),
    ),
    photo(
        "in letters",
        (40, 90, 40, 200),
        photometric=MINISBLACK,
        extra=(0, 0, 0),
        items=descriptions("B", "NIR", "G", "R"),
    ),
    photo(
        "red edge first",
        (90, 200, 40, 40),
        photometric=MINISBLACK,
        extra=(0, 0, 0),
        items=descriptions("red edge 1", "red", "green", "blue"),
    ),
    photo(
        "names against tags",
        TURNED,
        "band 3 is named 'B04 (red)', but tagged blue; it is taken for red",
        items=SENTINEL,
    ),
    photo(
        "two reds",
        (200, 40, 40, 90),
        "bands 1 and 4 are both named red; the first is taken",
        photometric=MINISBLACK,
        extra=(0, 0, 0),
        items=descriptions("red", "green", "blue", "red"),
    ),
    photo(
        "one name against the order",
        says="band 1 is named 'blue'; it is taken for red",
        photometric=MINISBLACK,
        extra=(0, 0),
        items=descriptions("blue"),
    ),
    photo("a palette", (7,), palette=lambda i: COLOUR if i == 7 else (1, 2, 3)),
    photo(
        "white is 0, 16 bits",
        (100 * 256,),
        bits=16,
        photometric=MINISWHITE,
        means={"red": 155},
    ),
    photo(
        "no data by custom",
        tuple(lambda x, y, v=v: -9999 if x < 32 else v / 255 for v in COLOUR),
        bits=32,
        kind=FLOAT,
        notes="values from 0 to 0.784314 are taken for parts of 1",
        covered=0.5,
    ),
    photo(
        "a system in a file beside",
        write=with_prj(
            Tiff(COLOUR, keys=(), corner=(14.508, 46.049), step=(3e-5, -3e-5)), GEOGRAPHIC
        ),
    ),
    photo("one bit", (lambda x, y: x // 2 % 2,), bits=1, means={"red": 127.5}),
    photo("alpha", (*COLOUR, lambda x, y: 0 if x < 32 else 255), extra=(ALPHA,), covered=0.5),
    photo(
        "alpha of 12 bits in 16",
        (*times(16), lambda x, y: 0 if x < 32 else 4095),
        TWELVE,
        bits=16,
        extra=(ALPHA,),
        covered=0.5,
    ),
    photo(
        "near infrared and alpha",
        (*COLOUR, 90, lambda x, y: 0 if x < 32 else 255),
        extra=(OTHER, ALPHA),
        covered=0.5,
    ),
    photo("south up", step=(0.5, 0.5), corner=(WEST, SOUTH)),
    photo("the corner is a middle", point=True, corner=(WEST + 0.25, NORTH - 0.25)),
    photo(
        "longitudes from 0 to 360",
        keys=DEGREES,
        corner=(345.999, 46.001),
        step=(7e-5, -7e-5),
        under=heights(bands=(300,), keys=DEGREES, corner=(-14, 46), step=(7e-5, -7e-5)).write,
        valid=99,
    ),
    photo(
        "across 180 degrees",
        keys=DEGREES,
        corner=(179.998, -15.999),
        step=(7e-5, -7e-5),
        under=heights(bands=(300,), keys=DEGREES, corner=(179.999, -16), step=(7e-5, -7e-5)).write,
        valid=99,
    ),
    photo(
        "degrees beyond a turn",
        keys=DEGREES,
        corner=(400, 46),
        step=(1e-5, -1e-5),
        refused="longitudes are 400 to 400.001",
    ),
    photo(
        "degrees that are metres", keys=DEGREES, refused="allowed: -180 to 360, one turn, and -90"
    ),
    photo(
        "a mask",
        write=translated(
            Tiff((*COLOUR, lambda x, y: 0 if x < 32 else 255), extra=(ALPHA,)),
            "-b",
            "1",
            "-b",
            "2",
            "-b",
            "3",
            "-mask",
            "4",
            "--config",
            "GDAL_TIFF_INTERNAL_MASK",
            "YES",
        ),
        covered=0.5,
    ),
    photo(
        "bands apart",
        write=translated(Tiff(times(16), bits=16), "-co", "INTERLEAVE=BAND", "-co", "TILED=YES"),
        says=TWELVE,
    ),
    photo(
        "12 bits in a mosaic",
        ending="vrt",
        write=translated(Tiff(times(16), bits=16), "-of", "VRT"),
        says=TWELVE,
    ),
    photo(
        "JPEG 2000 of 12 bits",
        ending="jp2",
        write=translated(
            Tiff(times(16), bits=16),
            "-of",
            "JP2OpenJPEG",
            "-co",
            "NBITS=12",
            "-co",
            "REVERSIBLE=YES",
            "-co",
            "QUALITY=100",
        ),
    ),
    photo(
        "control points alone",
        write=translated(
            Tiff(COLOUR),
            "-gcp",
            "0",
            "0",
            "462000",
            "101032",
            "-gcp",
            "64",
            "0",
            "462032",
            "101032",
            "-gcp",
            "0",
            "64",
            "462000",
            "101000",
            "-a_srs",
            SLOVENIA,
        ),
        refused="placed by control points alone",
    ),
    photo(
        "complex values",
        write=translated(Tiff(COLOUR), "-ot", "CFloat32"),
        refused="its values are complex",
    ),
    Row(
        "tiles of JPEG in YCbCr",
        "tif",
        translated(
            Tiff(COLOUR), "-co", "COMPRESS=JPEG", "-co", "PHOTOMETRIC=YCBCR", "-co", "TILED=YES"
        ),
        means=SEEN,
        under=SURVEY,
    ),
    Row(
        "a PNG of 16 bits",
        "png",
        translated(Tiff(times(256), bits=16), "-of", "PNG", "-co", "WORLDFILE=YES"),
        means=SEEN,
        under=SURVEY,
    ),
]


class Images(Strangers):
    @only_in_all
    def test_photographs(self):
        self.check_all(PHOTO_ROWS)

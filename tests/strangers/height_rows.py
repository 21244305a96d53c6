"""Rasters of heights."""

from checks import COLOUR, SLOVENIA, Row, Strangers, with_prj
from las_files import SOUTH, WEST, WKT
from raster_files import (
    ALPHA,
    DEGREES,
    METRES,
    NORTH,
    SIGNED,
    Tiff,
    grid_of_text,
    heights,
    item,
)

from support import only_in_all


def grid(name, bands=(300,), ending="tif", means=None, **facts):
    tiff = heights(
        bands=bands, **{k: v for k, v in facts.items() if k in Tiff.__dataclass_fields__}
    )
    row = {k: v for k, v in facts.items() if k not in Tiff.__dataclass_fields__}
    if means is None:
        means = {} if row.get("refused") else {"dsm": 301}  # the top of a voxel
    return Row(name, ending, row.pop("write", tiff.write), means=means, **row)


LAND = (WEST, SOUTH, WEST + 32, NORTH)
WEST_OF_GREENWICH = (577432, 5094287, 577607, 5094536)

HEIGHT_ROWS = [
    grid("heights", extent=LAND),
    grid("heights south up", step=(1, 1), corner=(WEST, SOUTH), extent=LAND),
    grid("the first cell's middle", point=True, corner=(WEST + 0.5, NORTH - 0.5), extent=LAND),
    grid("turned heights", turned=(0.5, 0.5), valid=52.8),
    grid("heights of 16 bits", bits=16, kind=SIGNED),
    grid("heights below zero of 8 bits", (-20,), bits=8, kind=SIGNED, means={"dsm": -19}),
    grid(
        "feet",
        (1000,),
        items=item("UNITTYPE", "ft", 0, "unittype"),
        means={"dsm": 305},
    ),
    grid(
        "feet of the survey",
        (1000,),
        items=item("UNITTYPE", "US survey foot", 0, "unittype"),
        means={"dsm": 305},
    ),
    grid("feet by a key", (1000,), keys=(*METRES, (4099, 9002)), means={"dsm": 305}),
    grid(
        "feet by a vertical system",
        (1000,),
        keys=(*METRES, (4096, 6360), (4099, 9003)),
        means={"dsm": 305},
    ),
    grid(
        "feet by a key under the code of metres",
        (1000,),
        keys=(*METRES, (4096, 5703), (4099, 9003)),
        means={"dsm": 305},
    ),
    grid("metres by a key under the code of feet", keys=(*METRES, (4096, 6360), (4099, 9001))),
    grid(
        "a unit that no key has",
        keys=(*METRES, (4099, 9999)),
        refused="unit of heights = 9999 by its GeoTIFF keys",
    ),
    grid(
        "a unit of the user's own",
        keys=(*METRES, (4099, 32767)),
        refused="unit of heights = 32767 by its GeoTIFF keys",
    ),
    grid(
        "a unit against the key",
        keys=(*METRES, (4099, 9003)),
        items=item("UNITTYPE", "m", 0, "unittype"),
        refused="unit of heights = 'm', but 0.304801 m by its GeoTIFF keys",
    ),
    grid(
        "a unit against the key, settled by the user",
        keys=(*METRES, (4099, 9003)),
        items=item("UNITTYPE", "m", 0, "unittype"),
        flags=("--world-vertical-unit", "m"),
    ),
    grid("a system in a file beside", write=with_prj(heights(bands=(300,), keys=()), WKT)),
    grid(
        "tenths of a metre above 100 m",
        (2000,),
        bits=16,
        items=item("SCALE", "0.1", 0, "scale") + item("OFFSET", "100", 0, "offset"),
    ),
    grid(
        "an unknown unit",
        items=item("UNITTYPE", "fathom", 0, "unittype"),
        refused="unit of heights = 'fathom'",
    ),
    grid("no data", (lambda x, y: -32767 if x < 16 else 300,), nodata="-32767", valid=50),
    grid("no data by custom", (lambda x, y: -9999 if x < 16 else 300,), valid=50),
    grid(
        "the lowest float is no data",
        (lambda x, y: -3.4028234663852886e38 if x < 16 else 300,),
        valid=50,
    ),
    grid(
        "heights with alpha",
        (200, lambda x, y: 0 if x < 16 else 255),
        bits=8,
        extra=(ALPHA,),
        means={"dsm": 201},
        valid=50,
    ),
    grid("three bands", COLOUR, bits=8, refused="it has 3 bands, and heights have one"),
    grid("three bands of 16 bits", COLOUR, bits=16, refused="give it with --ortho"),
    grid(
        "colours of a palette",
        (7,),
        bits=8,
        palette=lambda i: (i, i, i),
        refused="give it with --ortho",
    ),
    grid(
        "longitudes from 0 to 360",
        keys=DEGREES,
        corner=(346, 46),
        step=(7e-5, -7e-5),
        crs="EPSG:32628",
        extent=WEST_OF_GREENWICH,
        valid=99,
    ),
    grid(
        "across 180 degrees",
        keys=DEGREES,
        corner=(179.999, -16),
        step=(7e-5, -7e-5),
        crs="EPSG:32701",
        valid=99,
    ),
    grid(
        "degrees beyond a turn",
        keys=DEGREES,
        corner=(400, 46),
        step=(7e-5, -7e-5),
        refused="longitudes are 400 to 400.002",
    ),
    grid("degrees that are metres", keys=DEGREES, refused="or --crs with the system"),
    grid(
        "stars for no data",
        ending="asc",
        write=grid_of_text([["300"] * 4, ["300", "****", "300", "300"], *[["300"] * 4] * 2]),
        flags=("--crs", SLOVENIA),
        refused="its value '****' is no number",
    ),
    grid(
        "nan first",
        ending="asc",
        write=grid_of_text([["nan", *["300"] * 3], *[["300"] * 4] * 3]),
        flags=("--crs", SLOVENIA),
        refused="its first value is nan",
        is_read_by_newer_gdal=True,
        means={"dsm": 301},
        valid=93.75,
    ),
    grid(
        "nan first in all rows",
        ending="asc",
        write=grid_of_text([["nan", *["300"] * 3]] * 4, nodata="NODATA_value nan\n"),
        flags=("--crs", SLOVENIA),
        refused="its first value is nan",
        is_read_by_newer_gdal=True,
        means={"dsm": 301},
        valid=75,
    ),
    grid(
        "nan among whole numbers",
        ending="asc",
        write=grid_of_text([["300"] * 4, ["300", "nan", "nan", "300"], ["300"] * 4, ["300"] * 4]),
        flags=("--crs", SLOVENIA),
        valid=87.5,
    ),
]


class Heights(Strangers):
    @only_in_all
    def test_heights(self):
        self.check_all(HEIGHT_ROWS)

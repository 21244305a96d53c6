#!/usr/bin/env bash
# GDAL 3.9.3 (in the wheel of rasterio 1.4.3), driver GTiff, GTIFF_REPORT_COMPD_CS=YES: where the
# key of the unit of heights (VerticalUnits, 4099) has a number that EPSG does not know, heights are
# in metres, without a warning. Numbers that it knows, also rare ones, are read.
#
# A good guess: a unit of its own without a length, or no vertical part; or as in GDAL 3.5.3
# (rasterio 1.3.6), which gives no system at all for such a file, the known horizontal one neither.
#
# Output seen:
#   9003  US survey foot   0.304800609601219
#   9005  Clarke's foot    0.3047972654
#   9999  metre            1                  no warning
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip --quiet --disable-pip-version-check install rasterio==1.4.3 numpy==2.2.6
venv/bin/python - >seen <<'PYTHON'
import re
import struct
import warnings

import rasterio

assert rasterio.__gdal_version__ == "3.9.3", rasterio.__gdal_version__


def tiff(unit):
    """One pixel, whose keys are: a projected system, EPSG:3794, and the unit of heights."""
    keys = struct.pack("<16H", 1, 1, 0, 3, 1024, 0, 1, 1, 3072, 0, 1, 3794, 4099, 0, 1, unit)
    values = struct.pack("<9d", 1, 1, 0, 0, 0, 0, 462000, 101000, 0)
    tags = 12
    at = 8 + 2 + 12 * tags + 4
    entries = [(256, 3, 1, 1), (257, 3, 1, 1), (258, 3, 1, 8), (259, 3, 1, 1), (262, 3, 1, 1)]
    entries += [(273, 4, 1, at + len(values + keys)), (277, 3, 1, 1), (278, 3, 1, 1)]
    entries += [(279, 4, 1, 1), (33550, 12, 3, at), (33922, 12, 6, at + 24)]
    entries += [(34735, 3, len(keys) // 2, at + len(values))]
    assert len(entries) == tags
    out = struct.pack("<2sHIH", b"II", 42, 8, tags)
    for entry in entries:
        out += struct.pack("<HHII", *entry)
    return out + struct.pack("<I", 0) + values + keys + b"\0"


for unit in (9003, 9005, 9999):
    with open("a.tif", "wb") as file:
        file.write(tiff(unit))
    with rasterio.Env(GTIFF_REPORT_COMPD_CS="YES"), warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        with rasterio.open("a.tif") as image:
            wkt = image.crs.to_wkt()
    name, metres = re.search(r'VERT_CS\[.*UNIT\["([^"]+)",([0-9.]+)', wkt).groups()
    quiet = "no warning" if unit == 9999 and not said else ""
    print(f"{unit}  {name:15s}  {metres:17s}  {quiet}".rstrip())
PYTHON
cat seen
diff - seen <<'SEEN'
9003  US survey foot   0.304800609601219
9005  Clarke's foot    0.3047972654
9999  metre            1                  no warning
SEEN

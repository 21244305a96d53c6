#!/usr/bin/env bash
# GDAL 3.9.3 (in the wheel of rasterio 1.4.3), driver AAIGrid: a cell written as `nan` in an ASCII
# grid of whole heights is read as 0 and counts as valid, without a warning.
#
# A good guess: `nan` is no data, or makes the grid floating point, or is an error. What happens:
# the driver chooses the type from the first values of the grid. When those are whole numbers it is
# Int32, in which a later `nan` becomes 0. Only `NODATA_value nan` in the header makes the type
# Float32 and those cells no data; with NODATA_value -9999, or without the line, holes become land
# at sea level.
#
# Output seen:
#   NODATA_value -9999  int32    300 0 0 300      valid: 1 1 1 1
#   NODATA_value nan    float32  300 nan nan 300  valid: 1 0 0 1
#   (no line)           int32    300 0 0 300      valid: 1 1 1 1
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip --quiet --disable-pip-version-check install rasterio==1.4.3 numpy==2.2.6
venv/bin/python - >seen <<'PYTHON'
import rasterio

HEADER = "ncols 4\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 10\n"
ROWS = "300 300 300 300\n300 nan nan 300\n300 300 300 300\n"
assert rasterio.__gdal_version__ == "3.9.3", rasterio.__gdal_version__
for line in ("NODATA_value -9999", "NODATA_value nan", "(no line)"):
    with open("grid.asc", "w") as file:
        file.write(HEADER + (line + "\n" if line.startswith("N") else "") + ROWS)
    with rasterio.open("grid.asc") as grid:
        heights = " ".join(f"{value:g}" for value in grid.read(1)[1])
        valid = " ".join("1" if value else "0" for value in grid.read_masks(1)[1])
        print(f"{line:19s} {grid.dtypes[0]:8s} {heights:16s} valid: {valid}")
PYTHON
cat seen
diff - seen <<'SEEN'
NODATA_value -9999  int32    300 0 0 300      valid: 1 1 1 1
NODATA_value nan    float32  300 nan nan 300  valid: 1 0 0 1
(no line)           int32    300 0 0 300      valid: 1 1 1 1
SEEN

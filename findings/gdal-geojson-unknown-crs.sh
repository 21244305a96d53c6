#!/usr/bin/env bash
# GDAL 3.10.3 (in the wheel of pyogrio 0.11.0), driver GeoJSON: where the member `crs` (GeoJSON of
# 2008) names a system that GDAL does not know, the layer is in EPSG:4326, without a warning.
#
# A good guess: such a layer has no CRS, or the file is refused: its coordinates, here 462000 and
# 101000, are no degrees. What happens is what holds for files without the member (RFC 7946).
#
# Output seen:
#   urn:ogc:def:crs:EPSG::3794      EPSG:3794
#   urn:ogc:def:crs:EPSG::999999    EPSG:4326  no warning
#   urn:example:a-grid-of-ours      EPSG:4326  no warning
#   (no member)                     EPSG:4326  no warning
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip --quiet --disable-pip-version-check install pyogrio==0.11.0 numpy==2.2.6
venv/bin/python - >seen <<'PYTHON'
import json
import warnings

import pyogrio

assert pyogrio.__gdal_version__ == (3, 10, 3), pyogrio.__gdal_version__
point = {"type": "Point", "coordinates": [462000.0, 101000.0]}
feature = {"type": "Feature", "properties": {"n": 1}, "geometry": point}
for name in (
    "urn:ogc:def:crs:EPSG::3794",
    "urn:ogc:def:crs:EPSG::999999",
    "urn:example:a-grid-of-ours",
    "(no member)",
):
    collection = {"type": "FeatureCollection", "features": [feature]}
    if name.startswith("urn"):
        collection["crs"] = {"type": "name", "properties": {"name": name}}
    with open("a.geojson", "w") as file:
        json.dump(collection, file)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        crs = pyogrio.read_info("a.geojson")["crs"]
    quiet = "  no warning" if crs == "EPSG:4326" and not said else ""
    print(f"{name:31s} {crs}{quiet}")
PYTHON
cat seen
diff - seen <<'SEEN'
urn:ogc:def:crs:EPSG::3794      EPSG:3794
urn:ogc:def:crs:EPSG::999999    EPSG:4326  no warning
urn:example:a-grid-of-ours      EPSG:4326  no warning
(no member)                     EPSG:4326  no warning
SEEN

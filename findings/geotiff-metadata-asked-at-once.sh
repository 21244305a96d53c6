#!/usr/bin/env bash
# geotiff 3.1.0-beta.0 (npm; what OpenLayers 10.11.0 depends on), getGDALMetadata() and hasTag():
# asked for the metadata of several bands at once, an image answers the first question, and null to
# all others. Asked again a moment later, it knows all of them.
#
# A good guess: promises of a reader do not depend on each other, as Promise.all() over its bands
# takes for granted. What happens: a field that lies apart from the image's directory is fetched
# when it is first wanted; while it is on its way, hasTag() says that the image has no such field,
# and getGDALMetadata() believes it. Small files show nothing of it, since their fields come with
# the directory.
#
# Output seen:
#   at once      first_sun null null
#   in turn      first_sun last_sun hole
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip --quiet --disable-pip-version-check install rasterio==1.4.3 numpy==2.2.6
venv/bin/python - <<'PYTHON'
import numpy as np
import rasterio

shape = {"driver": "GTiff", "width": 16, "height": 16, "count": 3, "dtype": "float32"}
with rasterio.open("a.tif", "w", **shape) as out:
    out.write(np.zeros((3, 16, 16), np.float32))
    for band, name in enumerate(("first_sun", "last_sun", "hole"), 1):
        out.set_band_description(band, name)
    out.update_tags(ABOUT="x" * 8192)
PYTHON
npm install --silent --no-audit --no-fund --no-save geotiff@3.1.0-beta.0
cat >ask.mjs <<'JAVASCRIPT'
import { readFileSync } from 'node:fs';
import { fromArrayBuffer } from 'geotiff';

const file = readFileSync('a.tif');
const bytes = file.buffer.slice(file.byteOffset, file.byteOffset + file.byteLength);
const show = (how, found) =>
  console.log(`${how.padEnd(12)} ${found.map((each) => each?.DESCRIPTION ?? 'null').join(' ')}`);
const image = await (await fromArrayBuffer(bytes)).getImage();
show('at once', await Promise.all([0, 1, 2].map((band) => image.getGDALMetadata(band))));
const found = [];
for (const band of [0, 1, 2]) found.push(await image.getGDALMetadata(band));
show('in turn', found);
JAVASCRIPT
node ask.mjs >seen
cat seen
diff - seen <<'SEEN'
at once      first_sun null null
in turn      first_sun last_sun hole
SEEN

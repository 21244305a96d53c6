#!/usr/bin/env bash
# OpenImageIO 3.2.2.0 (its wheel on PyPI), format PNG: texts beyond ASCII are written as UTF-8 into
# chunks tEXt, which the standard (W3C PNG, third edition) reserves for Latin-1. OpenImageIO reads
# its own files back right, so a round trip through it shows nothing; readers that follow the
# standard (Pillow 11.3.0 here) show other letters.
#
# A good guess: a library that holds all strings as UTF-8 writes iTXt, the chunk for UTF-8, where a
# string has more than ASCII, or refuses it.
#
# Output seen:
#   chunk   tEXt Copyright b'\xc5\xa0kofja Loka'
#   OpenImageIO reads  Škofja Loka
#   Pillow reads       Å\xa0kofja Loka
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip --quiet --disable-pip-version-check install \
    OpenImageIO==3.2.2.0 numpy==2.2.6 pillow==11.3.0
PYTHONIOENCODING=utf-8 venv/bin/python - >seen <<'PYTHON'
import struct

import numpy as np
import OpenImageIO as oiio
from PIL import Image

assert oiio.VERSION_STRING == "3.2.2.0", oiio.VERSION_STRING
spec = oiio.ImageSpec(4, 4, 3, "uint8")
spec.attribute("Copyright", "Škofja Loka")
out = oiio.ImageOutput.create("a.png")
assert out.open("a.png", spec)
assert out.write_image(np.zeros((4, 4, 3), np.uint8))
out.close()

data, at = open("a.png", "rb").read(), 8
while at < len(data):
    size, kind = struct.unpack(">I4s", data[at : at + 8])
    body = data[at + 8 : at + 8 + size]
    if kind in (b"tEXt", b"iTXt") and body.startswith(b"Copyright"):
        print("chunk  ", kind.decode(), "Copyright", body.partition(b"\0")[2])
    at += 12 + size
back = oiio.ImageInput.open("a.png").spec().getattribute("Copyright")
print("OpenImageIO reads ", back)
print("Pillow reads      ", Image.open("a.png").text["Copyright"].replace("\xa0", r"\xa0"))
PYTHON
cat seen
diff - seen <<'SEEN'
chunk   tEXt Copyright b'\xc5\xa0kofja Loka'
OpenImageIO reads  Škofja Loka
Pillow reads       Å\xa0kofja Loka
SEEN

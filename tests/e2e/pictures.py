"""The contents of a picture file: size, metadata, and every channel as numbers."""

import array
import json
import math
import pathlib
import re
import struct

from support import Run, binary, temporary_folder


class Picture:
    """The contents of one picture file.

    `names` are the channels in their order, `types` their kinds by name.
    """

    def __init__(self, file):
        raw = temporary_folder() / "values"
        run = Run([binary("VALUES"), file, raw])
        if run.code != 0:
            raise AssertionError(f"{file}: {run}")
        said = json.loads(run.out)
        self.width = said["width"]
        self.height = said["height"]
        self.metadata = said["metadata"]
        self.tile = said["tile"]
        self.types = {c["name"]: c["type"] for c in said["channels"]}
        self.names = list(self.types)
        self.bytes = raw.read_bytes()
        self.values = array.array("f", self.bytes)
        raw.unlink()

    def channel(self, name):
        return self.values[self.names.index(name) :: len(self.names)]

    def channels(self, *names):
        """Tuples, one for each pixel, row by row."""
        return list(zip(*(self.channel(name) for name in names)))

    def numbers(self, key):
        """Metadata such as "1.5 2 3"."""
        return [float(v) for v in self.metadata[key].split()]

    def mattes(self, kind):
        """@return for each pixel a dictionary from name to share of the pixel

        @throws KeyError for an identity that is not in the manifest
        """
        (key,) = [
            k
            for k, v in self.metadata.items()
            if re.fullmatch("cryptomatte/[0-9a-f]{7}/name", k) and v == kind
        ]
        manifest = json.loads(self.metadata[key.removesuffix("name") + "manifest"])
        names = {int(identity, 16): name for name, identity in manifest.items()}
        ranks = [
            self.channels(f"{kind}{layer:02}.{a}", f"{kind}{layer:02}.{b}")
            for layer in range(3)
            for a, b in ("rg", "ba")
        ]
        out = []
        for pixel in zip(*ranks):
            out.append(
                {
                    names[struct.unpack("I", struct.pack("f", identity))[0]]: share
                    for identity, share in pixel
                    if share > 0
                }
            )
        return out


def camera_place(picture):
    """Where the eye stands, metres from terravox:origin."""
    voxel_m = float(picture.metadata["terravox:voxel_m"])
    return [
        (c - o) * voxel_m
        for c, o in zip(picture.numbers("terravox:camera"), picture.numbers("terravox:origin"))
    ]


def transformed(matrix, point):
    """A row vector times a matrix of 16 numbers, after the division by w."""
    x, y, z, w = (
        sum(p * matrix[4 * row + column] for row, p in enumerate([*point, 1]))
        for column in range(4)
    )
    return x / w, y / w, z / w


def distance(a, b):
    return math.dist(a, b)


def scene_of(picture):
    """The scene in a picture's metadata, without comments: {"camera.fov_deg": "40.0", ...}"""
    section = ""
    out = {}
    for line in picture.metadata["terravox:scene"].splitlines():
        if line.startswith("["):
            section = line.strip("[]")
        elif " = " in line:
            name, value = line.split(" = ", 1)
            out[f"{section}.{name}"] = value.split("  #")[0]
    return out


class Tags:
    """The tags of the first directory of a TIFF file that georeference it.

    Classic and BigTIFF, little-endian.

    Ref: "TIFF revision 6.0"; "OGC GeoTIFF Standard 1.1".
    """

    _FORMS = {2: "s", 3: "H", 4: "I", 12: "d", 16: "Q"}

    def __init__(self, file):
        data = pathlib.Path(file).read_bytes()
        magic, version = struct.unpack_from("<2sH", data)
        if magic != b"II" or version not in (42, 43):
            raise AssertionError(f"{file}: no little-endian TIFF")
        self.big = version == 43
        word, count_form, head = ("<Q", "<Q", 8) if self.big else ("<I", "<H", 2)
        (at,) = struct.unpack_from(word, data, 8 if self.big else 4)
        (count,) = struct.unpack_from(count_form, data, at)
        size, room = (20, 8) if self.big else (12, 4)
        self.tags = {}
        for i in range(count):
            entry = at + head + i * size
            tag, kind = struct.unpack_from("<HH", data, entry)
            (n,) = struct.unpack_from(word, data, entry + 4)
            if kind not in self._FORMS:
                continue
            form = f"<{n}{self._FORMS[kind]}"
            place = entry + 4 + room
            if struct.calcsize(form) > room:
                (place,) = struct.unpack_from(word, data, place)
            self.tags[tag] = struct.unpack_from(form, data, place)

    def geo_keys(self):
        """GeoKeys that are plain numbers, such as 3072: EPSG code of the projected CRS."""
        keys = self.tags.get(34735, ())
        return {keys[i]: keys[i + 3] for i in range(4, len(keys), 4) if keys[i + 1] == 0}

    def transform(self):
        """GDAL's six numbers, or None."""
        if 33550 in self.tags and 33922 in self.tags:
            sx, sy, _ = self.tags[33550]
            px, py, _, x, y, _ = self.tags[33922]
            return [x - px * sx, sx, 0.0, y + py * sy, 0.0, -sy]
        if 34264 in self.tags:
            m = self.tags[34264]
            return [m[3], m[0], m[1], m[7], m[4], m[5]]
        return None

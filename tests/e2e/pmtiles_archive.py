"""What a PMTiles archive holds, by the format's specification alone."""

import gzip
import json
import pathlib
import struct


class Archive:
    """A PMTiles archive, version 3.

    `zooms` are the least and the greatest, `bounds` west, south, east, north in degrees, `tiles`
    the bytes of each tile by its number, `metadata` what pages are told.
    """

    def __init__(self, file):
        self._bytes = pathlib.Path(file).read_bytes()
        if self._bytes[:8] != b"PMTiles\3":
            raise AssertionError(f"{file} is no PMTiles archive of version 3")
        numbers = struct.unpack_from("<11Q6B4i", self._bytes, 8)
        self._sections = [numbers[2 * i : 2 * i + 2] for i in range(4)]
        self.kind = numbers[14]
        self.zooms = numbers[15:17]
        self.bounds = [number / 1e7 for number in numbers[17:]]
        self.metadata = json.loads(gzip.decompress(self._section(1)))
        self.tiles = dict(self._read(gzip.decompress(self._section(0))))

    def _section(self, number):
        offset, length = self._sections[number]
        return self._bytes[offset : offset + length]

    def _read(self, directory):
        def numbers():
            value, shift = 0, 0
            for byte in directory:
                value |= (byte & 127) << shift
                shift += 7
                if byte < 128:
                    yield value
                    value, shift = 0, 0

        flat = list(numbers())
        count = flat.pop(0)
        columns = [flat[i * count : (i + 1) * count] for i in range(4)]
        tile, end = 0, 0
        for step, run, length, place in zip(*columns):
            tile += step
            offset = place - 1 if place else end
            end = offset + length
            if run == 0:
                yield from self._read(gzip.decompress(self._section(2)[offset:end]))
            for i in range(run):
                yield tile + i, self._section(3)[offset:end]

"""Pictures as arrays."""

import os
import pathlib
import struct
import zlib
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt


def _png(rgb: npt.NDArray[np.uint8]) -> bytes:
    """An RGB picture as a PNG file (ISO/IEC 15948), rows without filters."""
    height, width, _ = rgb.shape
    rows = np.concatenate([np.zeros((height, 1), np.uint8), rgb.reshape(height, -1)], axis=1)

    def chunk(kind: bytes, data: bytes) -> bytes:
        checked = kind + data
        return struct.pack(">I", len(data)) + checked + struct.pack(">I", zlib.crc32(checked))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", header)
        + chunk(b"IDAT", zlib.compress(rows.tobytes(), 6))
        + chunk(b"IEND", b"")
    )


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture, row by row from the top left. Notebooks show it."""

    rgb: npt.NDArray[np.uint8]
    """height x width x 3: sRGB, after exposure and tone curve."""
    light: npt.NDArray[np.float32]
    """height x width x 4: linear light, and the share of a pixel that shows the world."""
    depth: npt.NDArray[np.float32]
    """height x width: mean distance in metres; infinity: sky alone."""
    layers: dict[str, npt.NDArray[np.float32]]
    """With the field output.layers = "all": albedo, normal, position, material and others."""
    holes: int
    """Boxes that rays needed and that could not be read."""

    def png(self) -> bytes:
        """Return the picture as a PNG file."""
        return _png(self.rgb)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the picture as a PNG file."""
        pathlib.Path(path).write_bytes(self.png())

    def _repr_png_(self) -> bytes:
        return self.png()

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> npt.NDArray[Any]:
        if dtype is None or np.dtype(dtype) == self.rgb.dtype:
            return self.rgb.copy() if copy else self.rgb
        return self.rgb.astype(dtype)

    def __repr__(self) -> str:
        height, width, _ = self.rgb.shape
        more = f", layers {', '.join(self.layers)}" if self.layers else ""
        return f"<terravox.Picture {width} x {height}{more}>"

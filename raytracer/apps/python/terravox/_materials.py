"""What voxels are made of."""

from typing import NamedTuple

from terravox import _core


class Material(NamedTuple):
    """A material: its number in arrays, its name, and its plain colour (sRGB)."""

    number: int
    name: str
    rgb: tuple[int, int, int]


MATERIALS: tuple[Material, ...] = tuple(
    Material(number, name, (rgb[0], rgb[1], rgb[2])) for number, name, rgb in _core.materials()
)
"""All materials, by their numbers: `MATERIALS[0]` is air."""

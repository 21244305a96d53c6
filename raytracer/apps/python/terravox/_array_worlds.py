"""Worlds that are made of arrays."""

import math
import os
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from terravox import _core
from terravox._arrays import plain
from terravox._materials import MATERIALS
from terravox._scene import field_list
from terravox._world import Path, Progress, World

_FARTHEST = 1 << 26
"""Voxels from the origin of the map."""


def from_points(
    points: npt.ArrayLike,
    *,
    crs: str,
    classification: npt.ArrayLike | None = None,
    return_number: npt.ArrayLike | None = None,
    return_count: npt.ArrayLike | None = None,
    intensity: npt.ArrayLike | None = None,
    rgb: npt.ArrayLike | None = None,
    classes: str = "",
    voxel_m: float | None = None,
    orthophotos: Iterable[Path] = (),
    add: Iterable[str] = (),
    fields: Mapping[str, Any] | None = None,
    progress: Progress = None,
) -> World:
    """Voxelize points: of laspy, PDAL, Open3D, photogrammetry, or made up.

    They become voxels as those of a LAZ file do, to the millimetre, and wait in a temporary
    file until the world is closed.

    :param points: n x 3: easting, northing, height
    :param crs: of the points, "EPSG:3794"
    :param classification: n numbers of `classes`, 0 to 255; None: 1, not classified
    :param return_number: n numbers, 1 to 15; None: 1
    :param return_count: how many returns its pulse has, 1 to 15; None: 1
    :param intensity: n numbers, 0 to 65535; None: 0
    :param rgb: n x 3: 0 to 255 (uint8), or 0 to 65535 (uint16); black stands for no colour
    :param classes: table of LiDAR classes: its name, or a path; "": the one meant for such files
    :param voxel_m: edge of a voxel, metres; None: 1
    :param orthophotos: images, or folders of them
    :param add: planned objects that are put into the world, as `--add` takes them
    :param fields: further fields, as :func:`terravox.open` takes them
    :raises ValueError: for arrays of other shapes, or values that are out of range
    """
    xyz = np.ascontiguousarray(plain("points", points), dtype=np.float64)
    if xyz.ndim != 2 or xyz.shape[1] != 3:
        raise ValueError(f"points of shape {xyz.shape}; allowed: n x 3: easting, northing, height")
    if not np.isfinite(xyz).all():
        raise ValueError("points that are not finite; allowed: finite numbers")
    count = len(xyz)
    return World(
        _core.world_of_points(
            xyz,
            _column("classification", classification, count, 0, 255, np.uint8),
            _column("return_number", return_number, count, 1, 15, np.uint8),
            _column("return_count", return_count, count, 1, 15, np.uint8),
            _column("intensity", intensity, count, 0, 65535, np.uint16),
            _colours_of_points(rgb, count),
            crs,
            classes,
            voxel_m,
            [os.fspath(one) for one in orthophotos],
            list(add),
            field_list(fields or {}),
            progress,
        )
    )


def from_voxels(
    materials: npt.ArrayLike,
    *,
    west: float = 0,
    south: float = 0,
    bottom: float = 0,
    voxel_m: float = 1,
    crs: str = "",
    rgb: npt.ArrayLike | None = None,
    title: str = "",
) -> World:
    """Make a world of voxels: those of another program, or another world's that were changed.

    :param materials: layers from below x rows from the north x columns from the west, as
        :meth:`World.voxels` returns them: numbers of :data:`terravox.MATERIALS`, 0 for air. The
        world keeps those of voxels that can be seen
    :param west: easting of the western edge, metres, a multiple of `voxel_m`
    :param south: northing of the southern edge, metres, a multiple of `voxel_m`
    :param bottom: height of the lower edge, metres, a multiple of `voxel_m`
    :param voxel_m: edge of a voxel, metres, above 0, up to 1000
    :param crs: in metres; "": the world has no place on Earth
    :param rgb: the colours of the voxels (sRGB, uint8), of one dimension more; None: those of
        their materials
    :raises ValueError: for arrays of other shapes, or values that are out of range
    """
    if max(np.shape(materials), default=0) > _FARTHEST:
        raise ValueError(f"materials of shape {np.shape(materials)}; allowed: sides to {_FARTHEST}")
    # Its own, which nobody changes: boxes are made of it whenever they are needed.
    own = np.array(_bytes("materials", materials), order="C")
    if own.ndim != 3 or own.size == 0:
        raise ValueError(f"materials of shape {own.shape}; allowed: layers x rows x columns")
    if own.max() >= len(MATERIALS):
        raise ValueError(f"material {own.max()}; allowed: 0 to {len(MATERIALS) - 1}")
    colours = None
    if rgb is not None:
        colours = np.array(_bytes("rgb", rgb), order="C")
        if colours.shape != (*own.shape, 3):
            raise ValueError(f"rgb of shape {colours.shape}; allowed: {(*own.shape, 3)}")
    if not 0 < voxel_m <= 1000:
        raise ValueError(f"voxel_m = {voxel_m}; allowed: above 0, up to 1000")
    corner = [
        _whole("west", west, voxel_m),
        _whole("bottom", bottom, voxel_m),
        -(_whole("south", south, voxel_m) + own.shape[1]),
    ]
    core = _core.world_of_voxels(own, colours, corner, voxel_m, crs, title)
    if not math.isclose(core.info()["map_units"], voxel_m, rel_tol=1e-12):
        raise ValueError(f"crs = {crs}, which is not in metres; allowed: one in metres")
    return World(core)


def _column(
    name: str, values: npt.ArrayLike | None, count: int, least: int, most: int, kind: Any
) -> npt.NDArray[Any] | None:
    """Return values as an array of that kind, with one for each point."""
    if values is None:
        return None
    found = plain(name, values)
    if found.shape != (count,):
        raise ValueError(f"{name} of shape {found.shape}; allowed: one for each of {count} points")
    _check_range(name, found, least, most)
    return np.ascontiguousarray(found, dtype=kind)


def _colours_of_points(rgb: npt.ArrayLike | None, count: int) -> npt.NDArray[np.uint16] | None:
    if rgb is None:
        return None
    found = plain("rgb", rgb)
    if found.dtype not in (np.uint8, np.uint16):
        raise ValueError(f"rgb of {found.dtype}; allowed: uint8, uint16")
    if found.shape != (count, 3):
        raise ValueError(f"rgb of shape {found.shape}; allowed: {count} x 3")
    out = np.ascontiguousarray(found, dtype=np.uint16)
    # 0 to 255 becomes 0 to 65535.
    return out * np.uint16(257) if found.dtype == np.uint8 else out


def _bytes(name: str, values: npt.ArrayLike) -> npt.NDArray[np.uint8]:
    """Return values as an array of uint8."""
    found = plain(name, values)
    _check_range(name, found, 0, 255)
    return found.astype(np.uint8, copy=False)


def _check_range(name: str, values: npt.NDArray[Any], least: int, most: int) -> None:
    if values.dtype.kind not in "uib":
        raise ValueError(f"{name} of {values.dtype}; allowed: whole numbers")
    if values.size and (values.min() < least or values.max() > most):
        raise ValueError(
            f"{name} from {values.min()} to {values.max()}; allowed: {least} to {most}"
        )


def _whole(name: str, value: float, voxel_m: float) -> int:
    """Return a place on the map as a number of voxels."""
    found = value / voxel_m
    if not abs(found) < _FARTHEST:
        raise ValueError(f"{name} = {value}; allowed: up to {_FARTHEST} voxels from 0")
    number = round(found)
    if abs(found - number) > 1e-6:
        raise ValueError(f"{name} = {value}; allowed: multiples of voxel_m = {voxel_m}")
    return number

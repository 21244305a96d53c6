"""Worlds of voxels."""

import base64
import html
import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
import xarray as xr

from terravox import _core
from terravox._arrays import plain
from terravox._picture import Picture
from terravox._raster import array_of, dataset_of
from terravox._rays import Hits
from terravox._scene import SceneLike, field_list, toml_of

Path: TypeAlias = str | os.PathLike[str]
Bounds: TypeAlias = Sequence[float] | None
"""west, south, east, north; or west, south, east, north, bottom, top; None: all."""
Progress: TypeAlias = Callable[[int, int], object] | None
"""Called now and then with what is done, and how much there is."""


def open(  # noqa: A001 - terravox.open() is what users expect
    path: Path | Iterable[Path],
    *,
    crs: str = "",
    classes: str = "",
    voxel_m: float | None = None,
    orthophotos: Iterable[Path] = (),
    add: Iterable[str] = (),
    cache: Path = "",
    fields: Mapping[str, Any] | None = None,
) -> "World":
    """Open a world: LiDAR data, heights, Minecraft, Luanti, an archive, an address, noise.

    :param path: a path or an address; several only of LiDAR data and of rasters of heights
    :param crs: instead of that of the files, "EPSG:3794"
    :param classes: table of LiDAR classes: its name, or a path; "": the one meant for such files
    :param voxel_m: edge of a voxel of LiDAR data and heights, metres; None: 1
    :param orthophotos: images, or folders of them
    :param add: planned objects that are put into the world, as `--add` takes them
    :param cache: folder that keeps prepared squares; "": the user's own; "none": none
    :param fields: further fields of a scene's sections world, generated and processing,
        {"processing.memory_mib": 512}
    :raises UsageError: for a path that does not exist, or an option that is out of range
    :raises Error: for data that cannot be read
    """
    inputs = [path] if isinstance(path, (str, os.PathLike)) else list(path)
    core = _core.World.open(
        [os.fspath(one) for one in inputs],
        crs,
        classes,
        voxel_m,
        [os.fspath(one) for one in orthophotos],
        list(add),
        os.fspath(cache),
        field_list(fields or {}),
    )
    return World(core)


def _six(bounds: Bounds) -> list[float] | None:
    if bounds is None:
        return None
    numbers = [float(one) for one in bounds]
    if len(numbers) == 4:
        numbers += [-math.inf, math.inf]
    if len(numbers) != 6:
        raise ValueError(
            f"{len(numbers)} numbers of bounds; allowed: west, south, east, north, or these "
            "with bottom and top"
        )
    return numbers


def _rays(points: npt.ArrayLike, count: int | None = None) -> npt.NDArray[np.float64]:
    """Return points as n x 3 numbers; one point stands for `count` of them."""
    out = np.ascontiguousarray(plain("rays", points), dtype=np.float64)
    if out.ndim == 1 and out.size == 3:
        out = np.ascontiguousarray(np.broadcast_to(out, (1 if count is None else count, 3)))
    if out.ndim != 2 or out.shape[1] != 3:
        raise ValueError(f"rays of shape {out.shape}; allowed: n x 3: easting, northing, height")
    return out


def _both(
    origins: npt.ArrayLike, directions: npt.ArrayLike
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    first, second = np.ndim(origins), np.ndim(directions)
    if first == 1 and second == 2:
        towards = _rays(directions)
        return _rays(origins, len(towards)), towards
    starts = _rays(origins)
    return starts, _rays(directions, len(starts))


class World:
    """A world of voxels, read as needed. Copies and threads may share it.

    Made by :func:`terravox.open`, :func:`terravox.from_points` or
    :func:`terravox.from_voxels`. It is closed when nothing refers to it any more, by
    :meth:`close`, or at the end of a `with` statement.
    """

    def __init__(self, core: _core.World) -> None:
        self._opened: _core.World | None = core
        self._info = core.info()

    @property
    def _use(self) -> _core.World:
        if self._opened is None:
            raise ValueError(f"use the world {self.title!r}: it was closed")
        return self._opened

    def close(self) -> None:
        """Give up its files and memory, once calls in other threads have ended.

        What it has returned stays. Later calls of it raise ValueError, but facts, such as
        its bounds, can still be read.
        """
        self._opened = None

    def __enter__(self) -> "World":
        """Return this world, which is closed at the end of a `with` statement."""
        return self

    def __exit__(self, *_error: object) -> None:
        """Close it."""
        self.close()

    @property
    def title(self) -> str:
        """Name of the place, or of its files."""
        return str(self._info["title"])

    @property
    def crs(self) -> str:
        """The CRS, "EPSG:3794"; empty where the world has no place on Earth."""
        return str(self._info["crs"])

    @property
    def crs_wkt(self) -> str:
        """The CRS as WKT 2."""
        return str(self._info["crs_wkt"])

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """West, south, east, north in units of the CRS.

        Of all that is not air; of worlds without end, of what pictures show of them.
        """
        west, south, east, north = self._info["bounds"][:4]
        return (west, south, east, north)

    @property
    def heights(self) -> tuple[float, float]:
        """Lowest and highest height of these bounds, metres."""
        bottom, top = self._info["bounds"][4:]
        return (bottom, top)

    @property
    def voxel_m(self) -> float:
        """Edge of a voxel of level 0, metres. Those of level n have 2**n times that."""
        return float(self._info["voxel_m"])

    @property
    def levels(self) -> int:
        """Levels 0 to levels - 1 can be read."""
        return int(self._info["levels"])

    @property
    def centre(self) -> tuple[float, float] | None:
        """Latitude and longitude of the middle, degrees; None without a CRS."""
        found = self._info["centre"]
        return None if found is None else (found[0], found[1])

    @property
    def convergence_deg(self) -> float:
        """Azimuth of the map's north in the middle, clockwise from true north, degrees.

        Azimuths of scenes and results count from the map's north; 0 without a CRS.
        """
        return float(self._info["convergence_deg"])

    @property
    def attribution(self) -> str:
        """Whom pictures and maps of it must name."""
        return str(self._info["attribution"])

    @property
    def damage(self) -> list[str]:
        """Faults of the data that were met so far. What they concern is missing in results."""
        return self._use.damage()

    def voxels(
        self, bounds: Bounds = None, level: int = 0, *, threads: int = 0, progress: Progress = None
    ) -> npt.NDArray[np.uint8]:
        """Materials of a block of voxels, the smallest that covers the bounds.

        :returns: layers from the bottom up, rows from the north, columns from the west: numbers
            of `terravox.MATERIALS`, 0 for air; rock for voxels behind others on all sides, of
            which worlds keep no more
        :raises Error: where data cannot be read
        """
        values, _, holes = self._use.voxels(_six(bounds), level, threads, progress)
        if holes:
            raise _core.Error(f"read voxels: {holes} boxes could not be read")
        return values

    def surface(
        self, bounds: Bounds = None, level: int = 0, *, threads: int = 0, progress: Progress = None
    ) -> xr.DataArray:
        """Heights of the highest voxels, metres: a DSM. NaN where there are none."""
        found = self._use.surface(_six(bounds), level, threads, progress)
        return array_of(found, self.crs_wkt)

    def terrain(
        self,
        bounds: Bounds = None,
        resolution: float | None = None,
        *,
        level: int | None = None,
        threads: int = 0,
        progress: Progress = None,
    ) -> xr.Dataset:
        """Heights of surface and ground, slope, aspect, hillshade, class, material, colour."""
        return self.analyse(
            "terrain",
            bounds,
            resolution,
            level=level,
            threads=threads,
            progress=progress,
        )

    def analyse(
        self,
        kind: str,
        bounds: Bounds = None,
        resolution: float | None = None,
        *,
        level: int | None = None,
        observers: Iterable[Sequence[float]] = (),
        weather: Path = "",
        horizon: Path = "",
        scene: SceneLike = None,
        fields: Mapping[str, Any] | None = None,
        threads: int = 0,
        progress: Progress = None,
    ) -> xr.Dataset:
        """Measure the world on a grid of cells, as `terravox analyse` does.

        :param kind: as the command has them; sun with the fields analysis.from and analysis.to:
            of a period; also sun-months (of a period) and shadow (at sun.time_h)
        :param resolution: edge of a cell, metres; None: that of a voxel
        :param level: of the voxels; None: the coarsest that are no larger than a cell
        :param observers: of kind sight: easting, northing and height of the observers
        :param weather: of kind energy: an EPW file; "": a clear sky
        :param horizon: of kinds sky, sun and energy: a raster of heights around the data, whose
            hills hide sun and sky up to 60 km away; "": the horizon is free there
        :param fields: of a scene, {"sun.date": "2026-06-21", "sun.zone": "Europe/Ljubljana"}
        :returns: a variable for each band; `attrs["holes"]` counts the boxes that could not be
            read, whose cells have no values
        """
        found = self._use.analyse(
            kind,
            _six(bounds),
            resolution,
            level,
            [[float(one) for one in at] for at in observers],
            os.fspath(weather),
            os.fspath(horizon),
            toml_of(scene),
            field_list(fields or {}),
            threads,
            progress,
        )
        return dataset_of(found, self.crs_wkt)

    def cast(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        level: int = 0,
        *,
        range_m: float = math.inf,
        threads: int = 0,
        progress: Progress = None,
    ) -> Hits:
        """Find the first voxel that each ray meets.

        :param origins, directions: n x 3: easting, northing, height; one of both may be a single
            one for all rays
        :param range_m: how far rays go
        """
        starts, towards = _both(origins, directions)
        return Hits(*self._use.cast(starts, towards, level, range_m, threads, progress))

    def occluded(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        level: int = 0,
        *,
        range_m: float = math.inf,
        threads: int = 0,
        progress: Progress = None,
    ) -> npt.NDArray[np.bool_]:
        """Tell of each ray whether anything is in its way.

        :raises Error: where data cannot be read
        """
        starts, towards = _both(origins, directions)
        found, holes = self._use.occluded(starts, towards, level, range_m, threads, progress)
        if holes:
            raise _core.Error(f"cast rays: {holes} of them met boxes that could not be read")
        return found

    def render(
        self,
        scene: SceneLike = None,
        *,
        fields: Mapping[str, Any] | None = None,
        threads: int = 0,
        progress: Progress = None,
    ) -> Picture:
        """Render a picture.

        :param scene: sections of a scene, or the path of a scene file; None: the whole world
        :param fields: over those of the scene: {"output.size": "640x360"}
        """
        found = self._use.render(toml_of(scene), field_list(fields or {}), threads, progress)
        return Picture(
            found["rgb"], found["light"], found["depth_m"], found["layers"], found["holes"]
        )

    def convert(
        self,
        path: Path,
        *,
        format: str = "",  # noqa: A002 - the command has an option of that name
        level: int = 0,
        bounds: Bounds = None,
        overwrite: bool = False,
        threads: int = 0,
        progress: Progress = None,
    ) -> list[str]:
        """Write the world, or a part of it, in another format: .tvx, .vox, .glb, Minecraft, ...

        :param format: its name; "": by the ending of the path
        :returns: the files
        :raises Error: where data could not be read; what was written has holes then
        """
        files, _, holes = self._use.convert(
            os.fspath(path), format, level, _six(bounds), overwrite, threads, progress
        )
        if holes:
            raise _core.Error(f"convert to {os.fspath(path)}: {holes} boxes could not be read")
        return files

    def __repr__(self) -> str:
        if self._opened is None:
            return f"<terravox.World {self.title!r}, closed>"
        west, south, east, north = self.bounds
        bottom, top = self.heights
        return (
            f"<terravox.World {self.title!r}, {self.crs or 'no CRS'}, "
            f"{west:.0f} to {east:.0f} E, {south:.0f} to {north:.0f} N, "
            f"{bottom:.0f} to {top:.0f} m, voxels of {self.voxel_m:g} m, {self.levels} levels>"
        )

    def _repr_html_(self) -> str:
        if self._opened is None:
            return html.escape(repr(self))
        fields = {"output.size": "320x180", "quality.samples": 1}
        picture = base64.b64encode(self.render(fields=fields).png()).decode("ascii")
        return (
            f"<figure><img alt='' width='320' height='180' "
            f"src='data:image/png;base64,{picture}'>"
            f"<figcaption>{html.escape(repr(self)[1:-1])}</figcaption></figure>"
        )

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

__version__: str

class Error(RuntimeError): ...
class UsageError(Error, ValueError): ...

_Progress = Callable[[int, int], object] | None
_Fields = Sequence[tuple[str, str]]
_Rays = npt.NDArray[np.float64]

def set_log_level(level: str) -> None: ...
def materials() -> list[tuple[int, str, list[int]]]: ...
def finish() -> None: ...
def survey(
    folder: str,
    seed: int,
    density: float,
    squares: Sequence[int],
    square_m: int,
    threads: int,
    progress: _Progress,
) -> list[str]: ...

def world_of_points(
    xyz: _Rays,
    classification: npt.NDArray[np.uint8] | None,
    return_number: npt.NDArray[np.uint8] | None,
    return_count: npt.NDArray[np.uint8] | None,
    intensity: npt.NDArray[np.uint16] | None,
    rgb: npt.NDArray[np.uint16] | None,
    crs: str,
    classes: str,
    voxel_m: float | None,
    orthophotos: Sequence[str],
    additions: Sequence[str],
    fields: _Fields,
    progress: _Progress,
) -> World: ...
def world_of_voxels(
    materials: npt.NDArray[np.uint8],
    colours: npt.NDArray[np.uint8] | None,
    corner: Sequence[int],
    voxel_m: float,
    crs: str,
    title: str,
) -> World: ...

class World:
    @staticmethod
    def open(
        inputs: Sequence[str],
        crs: str,
        classes: str,
        voxel_m: float | None,
        orthophotos: Sequence[str],
        additions: Sequence[str],
        cache: str,
        fields: _Fields,
    ) -> World: ...
    def info(self) -> dict[str, Any]: ...
    def damage(self) -> list[str]: ...
    def voxels(
        self, bounds: Sequence[float] | None, level: int, threads: int, progress: _Progress
    ) -> tuple[npt.NDArray[np.uint8], list[float], int]: ...
    def surface(
        self, area: Sequence[float] | None, level: int, threads: int, progress: _Progress
    ) -> dict[str, Any]: ...
    def cast(
        self,
        origins: _Rays,
        directions: _Rays,
        level: int,
        range_m: float,
        threads: int,
        progress: _Progress,
    ) -> tuple[
        npt.NDArray[np.float64],
        npt.NDArray[np.int32],
        npt.NDArray[np.int8],
        npt.NDArray[np.uint8],
        int,
    ]: ...
    def occluded(
        self,
        origins: _Rays,
        directions: _Rays,
        level: int,
        range_m: float,
        threads: int,
        progress: _Progress,
    ) -> tuple[npt.NDArray[np.bool_], int]: ...
    def render(
        self, toml: str, fields: _Fields, threads: int, progress: _Progress
    ) -> dict[str, Any]: ...
    def analyse(
        self,
        kind: str,
        area: Sequence[float] | None,
        resolution_m: float | None,
        level: int | None,
        observers: Sequence[Sequence[float]],
        weather: str,
        horizon: str,
        toml: str,
        fields: _Fields,
        threads: int,
        progress: _Progress,
    ) -> dict[str, Any]: ...
    def convert(
        self,
        out: str,
        format: str,
        level: int,
        area: Sequence[float] | None,
        overwrite: bool,
        threads: int,
        progress: _Progress,
    ) -> tuple[list[str], int, int]: ...

"""Synthetic surveys, to try things with."""

import os
from collections.abc import Callable

from terravox import _core


def survey(
    folder: str | os.PathLike[str],
    *,
    seed: int = 7,
    density: float = 8,
    squares: tuple[int, int] = (1, 1),
    square_m: int = 1000,
    threads: int = 0,
    progress: Callable[[int, int], object] | None = None,
) -> list[str]:
    """Write LAZ squares and orthophotos of a made-up place, which depends on the seed alone.

    :param density: laser pulses on a square metre, 0.1 to 200
    :param squares: to the east and to the north, 1 to 100 each
    :param square_m: side of a square: a multiple of 16 from 64 on, or 1000
    :param threads: 0: one for each core
    :param progress: called with the squares that are done, and with all
    :returns: the LAZ files
    """
    return _core.survey(
        os.fspath(folder), seed, density, [squares[0], squares[1]], square_m, threads, progress
    )

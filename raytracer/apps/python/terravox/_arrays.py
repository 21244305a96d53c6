"""Arrays that callers give."""

from typing import Any

import numpy as np
import numpy.typing as npt

_NUMBERS = "biuf"
"""Kinds of numpy's types: bool, integers, unsigned integers, floating point."""

_masks: Any = np.ma
"""Of numpy 1.24, which has no types for it."""


def is_masked(value: Any) -> bool:
    """Tell whether a mask hides a value, or values of an array."""
    return bool(_masks.is_masked(value))


def plain(name: str, values: npt.ArrayLike) -> npt.NDArray[Any]:
    """Return values as an array of real numbers.

    numpy itself would take what is behind a mask for data, and the real part of complex numbers
    for all of them.

    :param name: of the values, for messages
    :raises ValueError: for masked values, and for what are no real numbers
    """
    # Knows masks within lists, too.
    found = _masks.asarray(values)
    if found.dtype.kind not in _NUMBERS:
        raise ValueError(f"{name} of {found.dtype}; allowed: real numbers")
    if is_masked(found):
        raise ValueError(
            f"{name} with {_masks.count_masked(found)} masked values of {found.size}; allowed: "
            "none, so leave them out (compressed()) or replace them (filled())"
        )
    return np.asarray(found)

"""What rays meet."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt


class Hits(NamedTuple):
    """What rays have hit: arrays with a row for each ray."""

    distance: npt.NDArray[np.float64]
    """Metres; infinity: nothing was hit; NaN: data that could not be read were."""
    voxel: npt.NDArray[np.int32]
    """n x 3: voxels of the level to the east, up, and to the south."""
    face: npt.NDArray[np.int8]
    """0 west, 1 east, 2 bottom, 3 top, 4 north, 5 south; -1: none."""
    material: npt.NDArray[np.uint8]
    """Numbers of `terravox.MATERIALS`; 0: nothing was hit."""
    holes: int
    """Rays that ended where data could not be read."""

"""Real places as voxels: read them, measure them, cast rays at them, and make pictures of them.

>>> import terravox
>>> world = terravox.open("generated:7")
>>> world.levels > 1
True

Coordinates are those of the map: easting and northing in the world's CRS, heights in metres.
"""

import atexit as _atexit

from terravox import _core
from terravox._array_worlds import from_points, from_voxels
from terravox._core import Error, UsageError, __version__, set_log_level
from terravox._materials import MATERIALS, Material
from terravox._picture import Picture
from terravox._rays import Hits
from terravox._survey import survey
from terravox._world import World, open

__all__ = [
    "MATERIALS",
    "Error",
    "Hits",
    "Material",
    "Picture",
    "UsageError",
    "World",
    "__version__",
    "from_points",
    "from_voxels",
    "open",
    "set_log_level",
    "survey",
]

# Threads of interrupted calls end before the interpreter does.
_atexit.register(_core.finish)

#!/usr/bin/env python3
"""Small inputs as other people's programs write them, each with its right value.

A row stands for a kind. What it says is right, or it is refused with the reason; nothing may be
quietly wrong. Each kind of data has a module of rows.
"""

import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "e2e"))

from height_rows import Heights
from image_rows import Images
from object_rows import Objects
from point_rows import Points
from world_rows import Worlds

__all__ = ["Heights", "Images", "Objects", "Points", "Worlds"]

if __name__ == "__main__":
    unittest.main()

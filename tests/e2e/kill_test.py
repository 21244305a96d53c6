#!/usr/bin/env python3
"""kill -9 in the middle of computing and writing boxes: later replies are the truth."""

import pathlib
import sys
import unittest

from support import Case, survey

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "bench" / "serve"))
from kill import kill_often  # noqa: E402

KILLS = 20


class Kill(Case):
    def test_no_box_is_corrupt_after_kills(self):
        figures = kill_often(KILLS, seed=9, world=[survey()])
        self.assertGreaterEqual(figures["kills"], KILLS)
        self.assertGreater(figures["compared"], KILLS * figures["boxes"] // 2, str(figures))
        self.assertEqual(figures["paths"], [])
        if figures["keeps_boxes"]:
            self.assertGreater(
                figures["from_disk"],
                0,
                "nothing was kept on disk, so nothing was tried: " + str(figures),
            )


if __name__ == "__main__":
    unittest.main()

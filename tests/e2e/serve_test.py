#!/usr/bin/env python3
"""A picture of boxes that the voxel server serves is the direct one."""

import unittest

from support import Case, Server, render, survey, temporary_folder

SMALL = ["--size", "160x90", "--samples", "1", "--quiet"]


class Serve(Case):
    def test_served_and_direct_pictures_are_the_same_bits(self):
        out = temporary_folder()
        with Server(survey(), "--ortho", survey() / "ortho") as server:
            served = render(server.url, *SMALL, "-o", out / "served.exr", "-o", out / "served.png")
            flags = [*SMALL, "--memory-mib", "1", "--threads", "3"]
            again = render(server.url + "/", *flags, "-o", out / "again.exr")
        self.assertDone(served)
        self.assertDone(again)
        for line in server.err.splitlines():
            self.assertFalse(line.startswith(("[warn", "[error")), server.err)
        words = ["--ortho", survey() / "ortho", *SMALL]
        self.assertDone(
            render(survey(), *words, "-o", out / "direct.exr", "-o", out / "direct.png")
        )
        self.assertAlike(out / "served.exr", out / "direct.exr", exact=True)
        self.assertAlike(out / "served.png", out / "direct.png", exact=True)
        self.assertAlike(out / "again.exr", out / "direct.exr", exact=True)


if __name__ == "__main__":
    unittest.main()

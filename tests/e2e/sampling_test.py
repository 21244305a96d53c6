#!/usr/bin/env python3
"""Samples: a noise threshold, a time limit, another seed; exposure and curves."""

import json
import unittest

from pictures import Picture
from support import Case, render, square, temporary_folder

W = 96
H = 54
SIZE = ["--size", f"{W}x{H}", "--quiet"]


class Sampling(Case):
    def setUp(self):
        self.out = temporary_folder()

    def made(self, name, *flags):
        """@return picture and report"""
        picture, report = (self.out / f"{name}{ending}" for ending in (".exr", ".json"))
        self.assertDone(render(square(), *SIZE, *flags, "--report", report, "-o", picture))
        return Picture(picture), json.loads(report.read_text())

    def test_noise_ends_pixels_that_are_known(self):
        primary = {}
        for noise in ("0.3", "0.05", "0"):
            p, report = self.made(
                noise, "--noise", noise, "--samples", "64", "--integrator", "path"
            )
            primary[noise] = report["rays_by_kind"]["primary"]
            self.assertEqual(p.metadata["terravox:samples"], "64")
        self.assertEqual(primary["0"], 64 * W * H)
        self.assertLess(primary["0.3"], primary["0.05"])
        self.assertLess(primary["0.05"], primary["0"])
        self.assertGreaterEqual(primary["0.3"], 16 * W * H)

    def test_time_takes_what_samples_it_can(self):
        p, report = self.made("timed", "--time", "1.5", "--samples", "65536")
        self.assertGreaterEqual(report["samples"], 2)
        self.assertLess(report["samples"], 65536)
        self.assertEqual(int(p.metadata["terravox:samples"]), report["samples"])
        self.assertEqual(report["rays_by_kind"]["primary"], report["samples"] * W * H)
        # With enough time all requested samples are taken, and the picture is that without a time
        # limit, except for rounding of means of means.
        timed, report = self.made("enough", "--time", "1000", "--samples", "8")
        self.assertEqual(report["samples"], 8)
        plain, _ = self.made("plain", "--samples", "8")
        for name in ("R", "G", "B", "A"):
            for i, (a, b) in enumerate(zip(timed.channel(name), plain.channel(name))):
                self.assertAlmostEqual(
                    a, b, delta=1e-4 * max(1, abs(b)), msg=f"{name} of pixel {i}"
                )


if __name__ == "__main__":
    unittest.main()

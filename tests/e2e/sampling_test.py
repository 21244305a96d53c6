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
        self.assertDone(
            render(
                square(),
                *SIZE,
                *flags,
                "--report",
                self.out / f"{name}.json",
                "-o",
                self.out / f"{name}.exr",
            )
        )
        return Picture(self.out / f"{name}.exr"), json.loads(
            (self.out / f"{name}.json").read_text()
        )

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

    def test_noise_is_the_same_whatever_the_threads_and_tiles(self):
        flags = ["--noise", "0.1", "--samples", "48", "--integrator", "path", "--layers", "all"]
        a, _ = self.made("a", *flags, "--threads", "1", "--tile", "64")
        b, _ = self.made(
            "b", *flags, "--threads", "2", "--tile", "16", "--quality-coarse-step", "1"
        )
        self.assertTrue(a.bytes == b.bytes)

    def test_more_samples_are_nearer_to_many(self):
        many, _ = self.made("many", "--samples", "256", "--quality-seed", "9")

        def error(samples):
            p, _ = self.made(str(samples), "--samples", str(samples))
            return sum((a - b) ** 2 for a, b in zip(p.channel("G"), many.channel("G")))

        errors = [error(n) for n in (1, 4, 16, 64)]
        self.assertEqual(errors, sorted(errors, reverse=True))
        self.assertLess(errors[-1], errors[0] / 8)

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

    def test_another_seed_is_other_noise_of_the_same_picture(self):
        a, _ = self.made("a", "--samples", "4")
        again, _ = self.made("again", "--samples", "4")
        b, _ = self.made("b", "--samples", "4", "--quality-seed", "1")
        self.assertTrue(a.bytes == again.bytes)
        self.assertFalse(a.bytes == b.bytes)
        for name in "RGB":
            means = [sum(p.channel(name)) / (W * H) for p in (a, b)]
            self.assertAlmostEqual(means[0], means[1], delta=0.03 * means[0])

    def test_exposure_and_curve_change_bytes_and_not_light(self):
        def bytes_of(name, *flags):
            self.assertDone(
                render(
                    square(),
                    *SIZE,
                    "--samples",
                    "1",
                    *flags,
                    "-o",
                    self.out / f"{name}.png",
                    "-o",
                    self.out / f"{name}.exr",
                )
            )
            return Picture(self.out / f"{name}.png"), Picture(self.out / f"{name}.exr").bytes

        plain, light = bytes_of("plain")
        brighter, same = bytes_of("brighter", "--exposure", "1")
        self.assertTrue(light == same)
        self.assertGreater(sum(brighter.values), 1.1 * sum(plain.values))
        seen = {plain.bytes}
        for tone in ("filmic", "agx", "linear"):
            p, same = bytes_of(tone, "--tone", tone)
            self.assertTrue(light == same, tone)
            self.assertNotIn(p.bytes, seen, tone)
            seen.add(p.bytes)


if __name__ == "__main__":
    unittest.main()

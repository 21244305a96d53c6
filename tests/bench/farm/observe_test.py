#!/usr/bin/env python3
"""Conclusions of the fault benches from the log of a coordinator."""

import io
import unittest

from ideal import ideal_s
from observe import Band, Watch, fates, held, lease_delays_s, quantile


def line(kind, tile, y0, y1, worker):
    return (
        f"[debug] {kind}: tile {tile} rows {y0} to {y1} "
        f"step 1 sample 0 {'to' if kind == 'lease' else 'of'} {worker}\n"
    )


def events_of(*lines):
    """Each comes at its number, in seconds."""
    watch = Watch(io.StringIO("".join(lines)))
    watch.join()
    return [e._replace(when=float(i)) for i, e in enumerate(watch.events())]


class Observe(unittest.TestCase):
    def test_bands_held_by_each_worker(self):
        events = events_of(
            line("lease", 1, 0, 16, "a"),
            line("lease", 2, 0, 16, "b b"),
            line("lease", 3, 0, 16, "a"),
            line("lease", 3, 0, 16, "c"),
            line("answer", 1, 0, 16, "a"),
        )
        self.assertEqual(held(events, "a", 3.5), [Band(1, 0, 16, 1, 0)])
        self.assertEqual(held(events, "a", 4.5), [])
        self.assertEqual(held(events, "b b", 4.5), [Band(2, 0, 16, 1, 0)])

    def test_a_band_that_is_cut_anew_is_leased_with_the_first_of_its_rows(self):
        events = events_of(
            line("lease", 1, 0, 32, "a"),
            line("lease", 1, 32, 48, "b"),
            line("lease", 1, 16, 32, "b"),
            line("lease", 1, 0, 16, "c"),
        )
        self.assertEqual(lease_delays_s(events, "a", 0.5), [1.5])

    def test_a_band_that_no_worker_gets_has_an_infinite_delay(self):
        events = events_of(
            line("lease", 1, 0, 32, "a"),
            line("lease", 1, 0, 32, "checks"),
            line("lease", 2, 0, 32, "b"),
        )
        self.assertEqual(lease_delays_s(events, "a", 0.5), [float("inf")])

    def test_an_answer_on_its_way_is_no_loss(self):
        events = events_of(
            line("lease", 1, 0, 16, "a"),
            line("lease", 2, 0, 16, "a"),
            line("answer", 1, 0, 16, "a"),
            line("lease", 2, 0, 16, "b"),
        )
        self.assertEqual(lease_delays_s(events, "a", 1.5), [1.5])
        self.assertEqual([f.answered_s for f in fates(events, "a", 1.5)], [0.5, None])

    def test_waiting_for_a_line(self):
        watch = Watch(io.StringIO("one\ntwo\ntwo and a half\n"))
        self.assertEqual(watch.saw_times("^two", 2, 5)[1].string, "two and a half")
        watch.join()
        with self.assertRaisesRegex(RuntimeError, "three.*0 of 1"):
            watch.saw("three", 5)

    def test_quantiles(self):
        for share, value in ((0.5, 2), (0.75, 3), (0.99, 4), (1, 4)):
            self.assertEqual(quantile([4, 1, 3, 2], share), value, share)


class Ideal(unittest.TestCase):
    def test_remaining_work_is_divided_among_remaining_workers(self):
        for name, work_s, prepare_s, workers, killed_at_s, most, wanted_s in (
            ("no worker is killed", 12, 0, 3, [], 3, 4),
            ("half way", 12, 0, 3, [2], 3, 5),
            ("two of them", 12, 0, 3, [2, 1], 3, 1 + 1 + 7),
            ("after the end", 12, 0, 3, [4.5], 3, 4),
            ("two cores", 12, 0, 3, [2], 2, 6),
            ("one core", 12, 0, 3, [2, 3], 1, 12),
            ("before it was ready", 12, 1, 3, [0.5], 3, 7),
            ("later", 12, 1, 3, [3], 3, 6),
        ):
            with self.subTest(name):
                self.assertAlmostEqual(
                    ideal_s(work_s, prepare_s, workers, killed_at_s, most), wanted_s
                )


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
"""Charts, read back from their SVG."""

import pathlib
import sys
import unittest
import xml.etree.ElementTree

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

import chart  # noqa: E402

SVG = "{http://www.w3.org/2000/svg}"


def drawn(svg, kind):
    return xml.etree.ElementTree.fromstring(svg).iter(SVG + kind)


def words(svg):
    return [element.text for element in drawn(svg, "text")]


class Scale(unittest.TestCase):
    def test_steps_are_round_and_few(self):
        for largest, expected in ((1, 0.2), (6, 1), (6.1, 2), (28, 5), (0.03, 0.005), (1200, 200)):
            with self.subTest(largest=largest):
                self.assertAlmostEqual(chart.round_step(largest), expected)

    def test_the_median_of_an_even_count_lies_between(self):
        self.assertEqual(chart.median([4, 1, 3, 2]), 2.5)
        self.assertEqual(chart.median([3, 1, 2]), 2)


class Lines(unittest.TestCase):
    def points(self, svg):
        return [
            [tuple(map(float, point.split(","))) for point in line.get("points").split()]
            for line in drawn(svg, "polyline")
        ]

    def test_more_is_higher_in_proportion_and_places_are_evenly_spaced(self):
        (rising,) = self.points(
            chart.line_chart("t", "c", "x", "y", [8, 16, 32], {"one": [[10], [20], [40]]})
        )
        self.assertAlmostEqual(rising[1][0] - rising[0][0], rising[2][0] - rising[1][0], delta=0.2)
        self.assertAlmostEqual(
            (rising[1][1] - rising[2][1]) / (rising[0][1] - rising[1][1]), 2, delta=0.02
        )

    def test_a_mark_is_the_median_of_its_values(self):
        svg = chart.line_chart("t", "c", "x", "y", [1], {"many": [[1, 2, 30]], "two": [[2]]})
        (many,), (two,) = self.points(svg)
        self.assertEqual(many[1], two[1])

    def test_names_may_hold_any_character(self):
        svg = chart.line_chart("a < b & c", '"quoted"', "x", "y", ["<8>"], {"1 > 0": [[1]]})
        for text in ("a < b & c", '"quoted"', "<8>", "1 > 0"):
            self.assertIn(text, words(svg))


class Bars(unittest.TestCase):
    def test_ten_times_as_much_is_one_step_wider(self):
        svg = chart.bar_chart(
            "t", "c", "x", {"low": 0.1, "middle": 1, "high": 10, "lowest": 0.02}, {}, "other"
        )
        low, middle, high, _ = [float(bar.get("width")) for bar in drawn(svg, "rect")][1:]
        self.assertAlmostEqual(middle - low, high - middle, delta=0.2)
        self.assertGreater(middle - low, 50)

    def test_marks_lie_on_the_same_scale_and_only_next_to_their_bars(self):
        svg = chart.bar_chart("t", "c", "x", {"a": 2, "b": 50}, {"a": 50, "elsewhere": 7}, "other")
        bar = list(drawn(svg, "rect"))[2]
        marks = [float(mark.get("cx")) for mark in drawn(svg, "circle") if mark.get("stroke")]
        self.assertEqual(len(marks), 1)
        self.assertAlmostEqual(marks[0], float(bar.get("x")) + float(bar.get("width")), delta=0.2)


if __name__ == "__main__":
    unittest.main()

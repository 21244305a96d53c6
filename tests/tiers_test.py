#!/usr/bin/env python3
"""tests/budget keeps its own sums, and tests/tiers.py finds what a change touches."""

import os
import pathlib
import tempfile
import textwrap
import unittest

import tiers

BUILD = pathlib.Path(os.environ.get("TERRAVOX_BUILD", tiers.ROOT / "build" / "release"))


class Budget(unittest.TestCase):
    def setUp(self):
        self.sums, self.entries = tiers.read_budget()

    def test_each_tier_declares_no_more_than_its_sum(self):
        declared = {"default": 0, "all": 0}
        for tier, seconds in self.entries.values():
            declared["all"] += seconds
            declared[tier] += seconds if tier == "default" else 0
        for tier, seconds in declared.items():
            self.assertLessEqual(seconds, self.sums[tier], f"processor time of {tier}, s")

    def test_lines_are_sorted(self):
        self.assertEqual(list(self.entries), sorted(self.entries))

    def test_a_line_that_is_none_is_refused_by_its_number(self):
        with tempfile.NamedTemporaryFile("w", suffix="-budget") as file:
            for line in ("a_test sometimes 3", "a_test all", "all = many"):
                pathlib.Path(file.name).write_text(f"# who\n{line}\n", encoding="utf-8")
                with self.assertRaisesRegex(ValueError, f":2: '{line}'"):
                    tiers.read_budget(pathlib.Path(file.name))
            pathlib.Path(file.name).write_text("a all 1\na default 1\n", encoding="utf-8")
            with self.assertRaisesRegex(ValueError, "a stands twice"):
                tiers.read_budget(pathlib.Path(file.name))


class Report(unittest.TestCase):
    def test_it_names_the_dearest_and_those_above_their_budget(self):
        entries = {f"e{i}": ("default", 10) for i in range(12)}
        times = "".join(f"e{i}\t{i}.5\n" for i in range(12))
        lines = tiers.report(times, ({}, entries))
        self.assertEqual(lines[0], "Processor time of 12 entries: 72 s. The dearest:")
        self.assertEqual(lines[1], "     11.5 of 10 s  e11")
        self.assertEqual(len(lines), 1 + tiers.SHOWN + 3)
        self.assertEqual(lines[-2:], ["     10.5 of 10 s  e10", "     11.5 of 10 s  e11"])


class Fake:
    """A build whose program `bin/seen` is made of one source."""

    root = tiers.ROOT
    build = root / "build" / "none"

    def sources(self, target):
        return frozenset({"common/seen.cpp"} if target == "bin/seen" else ())


def entry(*words, **environment):
    test = tiers.Test({"name": "e"})
    test.words = [str(word) for word in words]
    test.environment = environment
    return test


class Touched(unittest.TestCase):
    def test_a_program_depends_on_what_it_is_made_from(self):
        test = entry(Fake.build / "bin" / "seen")
        self.assertEqual(tiers.is_touched(test, {"common/seen.cpp"}, Fake()), "common/seen.cpp")
        self.assertIsNone(tiers.is_touched(test, {"common/other.cpp"}, Fake()))

    def test_of_a_module_only_what_is_used_counts(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            (folder / "shared.py").write_text(
                textwrap.dedent("""
                    KEPT = "kept"
                    def render():
                        return binary("RAYTRACER")
                    def serve():
                        return binary("VOXELSERVER")
                    def binary(name):
                        return name + KEPT
                """),
                encoding="utf-8",
            )
            (folder / "a_test.py").write_text(
                "from shared import render, serve\n\ndef test():\n    render()\n", encoding="utf-8"
            )
            files, texts = tiers.used_by(folder / "a_test.py")
        self.assertEqual({file.name for file in files}, {"a_test.py", "shared.py"})
        self.assertEqual(texts, {"RAYTRACER", "kept"})

    def test_a_script_of_node_depends_on_the_folders_that_it_names(self):
        run = tiers.ROOT / "tests" / "grabber" / "run.js"
        for path in ("grabber/src/main.ts", "tests/grabber/cli/grab.test.ts"):
            self.assertTrue(tiers.is_touched(entry("node", run), {path}, Fake()), path)
        self.assertIsNone(tiers.is_touched(entry("node", run), {"common/seen.cpp"}, Fake()))


@unittest.skipUnless((BUILD / "build.ninja").exists(), "nothing was built by Ninja")
class Build(unittest.TestCase):
    def test_a_header_of_the_lowest_layer_is_a_source_of_the_programs(self):
        graph = tiers.Graph(BUILD)
        self.assertIn("common/voxel/material.hpp", graph.sources("bin/terravox-raytracer"))
        self.assertNotIn("voxelserver/serve/server/serve.cpp", graph.sources("bin/terravox-survey"))

    def test_every_line_of_the_budget_is_an_entry(self):
        cache = (BUILD / "CMakeCache.txt").read_text(encoding="utf-8")
        whole = ("CMAKE_BUILD_TYPE:STRING=Release", "TERRAVOX_PREVIEW:BOOL=ON")
        if not all(line in cache for line in (*whole, "TERRAVOX_PYTHON:BOOL=ON")):
            self.skipTest("this build leaves out entries, such as those of the window")
        names = {test.name for test in tiers.list_tests(BUILD)}
        self.assertEqual(set(tiers.read_budget()[1]) - names, set())


if __name__ == "__main__":
    unittest.main()

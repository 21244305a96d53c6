#!/usr/bin/env python3
"""The seeded faults still apply to the tree, and name entries that there are."""

import collections
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from mutants import FOLDER, ROOT, WINGS, all_mutants, read_mutant

TESTS = ROOT / "tests"
LEAST = 60


def has_entry(name):
    """Whether a file of the tests registers an entry of this name, built here or not."""
    scripts = [
        TESTS / "e2e" / f"{name.removeprefix('e2e_')}.py",
        TESTS / "raytracer" / "apps" / "python" / f"{name.removeprefix('python_')}.py",
    ]
    if name.startswith(("e2e_", "python_")):
        return any(script.exists() for script in scripts)
    wanted = re.compile(rf"\bNAME {re.escape(name)}\b")
    lists = [p for p in TESTS.rglob("CMakeLists.txt") if "node_modules" not in p.parts]
    return any(wanted.search(p.read_text()) for p in lists)


class Mutants(unittest.TestCase):
    def test_there_are_many_in_every_wing(self):
        mutants = all_mutants()
        wings = collections.Counter(mutant.wing for mutant in mutants)
        self.assertGreaterEqual(len(mutants), LEAST)
        self.assertEqual(set(wings), set(WINGS.values()))

    def test_each_names_entries_that_there_are(self):
        for mutant in all_mutants():
            for nearest in mutant.nearest:
                with self.subTest(mutant=mutant.name):
                    self.assertTrue(has_entry(nearest.entry), nearest.entry)

    @unittest.skipUnless(shutil.which("git"), "git is missing")
    def test_each_applies(self):
        environment = {**os.environ, "GIT_CEILING_DIRECTORIES": str(ROOT.parent)}
        for mutant in all_mutants():
            with self.subTest(mutant=mutant.name):
                run = subprocess.run(
                    ["git", "apply", "--check", "-p1", mutant.patch],
                    cwd=ROOT,
                    env=environment,
                    capture_output=True,
                    text=True,
                    check=False,
                )
                self.assertEqual(run.returncode, 0, run.stderr)

    def test_a_patch_of_another_form_is_refused(self):
        patch = next(FOLDER.glob("*.patch")).read_text()
        fault, entries, rest = patch.split("\n", 2)
        hunk = rest[rest.index("@@ ") :]
        bad = {
            "no entries": f"{fault}\n{rest}",
            "two lines of text": f"{fault}\n{fault}\n{entries}\n{rest}",
            "two hunks": patch + hunk,
            "no diff": f"{fault}\n{entries}\n",
        }
        with tempfile.TemporaryDirectory() as folder:
            for what, text in bad.items():
                with self.subTest(what):
                    file = pathlib.Path(folder) / "bad.patch"
                    file.write_text(text)
                    with self.assertRaises(ValueError):
                        read_mutant(file)


if __name__ == "__main__":
    sys.exit(unittest.main())

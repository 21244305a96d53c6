#!/usr/bin/env python3
"""What the hooks of the checkout (config/git) say of the subjects of commits, and of long lines."""

import pathlib
import subprocess
import tempfile
import unittest

HOOKS = pathlib.Path(__file__).resolve().parents[1] / "config" / "git"
HOOK = HOOKS / "commit-msg"


class CommitSubject(unittest.TestCase):
    def refused(self, message):
        """What the hook writes, or nothing where it lets the commit go."""
        with tempfile.NamedTemporaryFile("w", encoding="utf-8") as file:
            file.write(message)
            file.flush()
            run = subprocess.run([HOOK, file.name], capture_output=True, text=True, check=False)
        self.assertEqual(run.returncode, 1 if run.stderr else 0)
        return run.stderr

    def test_what_a_stranger_understands_passes(self):
        for message in (
            "raytracer: keep parked rays in order",
            "page, server: name what a job may ask\n\nWhy it does.\n",
            "e2e_farm_test: wait for the second worker",
            "store: feed squares\n# a comment of git\n",
            "x: " + "y" * 69,
            "fixup! raytracer: keep parked rays in order",
            'Revert "raytracer: keep parked rays in order"',
        ):
            with self.subTest(message):
                self.assertEqual(self.refused(message), "")

    def test_each_rule(self):
        for said, message in (
            ("over 72 columns", "x: " + "y" * 70),
            ("has no area", "texts of strangers do not speak to the terminal"),
            ("has no area", "raytracer: Keep parked rays"),
            ("ends in a full stop", "raytracer: keep parked rays."),
            ('"added" is no verb', "raytracer: added rays"),
            ('"adding" is no verb', "raytracer: adding rays"),
            ("second line is not empty", "raytracer: keep rays\nin order\n"),
            ("has no area", ""),
        ):
            with self.subTest(said):
                self.assertIn(said, self.refused(message))


class LongLines(unittest.TestCase):
    def refused(self, name, line):
        """What the hook writes of a file of one line, or nothing where it lets the commit go."""
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / name).write_text(f"{line}\n", encoding="utf-8")
            for words in (["git", "init", "--quiet"], ["git", "add", name]):
                subprocess.run(words, cwd=folder, check=True)
            run = subprocess.run(
                [HOOKS / "pre-commit"], cwd=folder, capture_output=True, text=True, check=False
            )
        self.assertEqual(run.returncode, 1 if run.stderr else 0)
        return run.stderr

    def test_lines_have_at_most_100_columns(self):
        for name in ("a.py", "CMakeLists.txt", "a.cmake", "a.sh"):
            self.assertIn(f"{name}:1: over 100 columns", self.refused(name, "# " + "y" * 99))
            self.assertEqual(self.refused(name, "# " + "é" * 98), "")
        self.assertEqual(self.refused("a.md", "y" * 200), "")


if __name__ == "__main__":
    unittest.main()

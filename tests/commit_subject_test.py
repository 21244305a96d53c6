#!/usr/bin/env python3
"""What the hook of the checkout (config/git/commit-msg) says of the subjects of commits."""

import pathlib
import subprocess
import tempfile
import unittest

HOOK = pathlib.Path(__file__).resolve().parents[1] / "config" / "git" / "commit-msg"


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


if __name__ == "__main__":
    unittest.main()

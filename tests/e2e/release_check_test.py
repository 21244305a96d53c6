#!/usr/bin/env python3
"""What stands in the way of a release."""

import re
import shutil
import subprocess
import unittest

from releasing import tool, version
from support import ROOT, Case, temporary_folder

READ = (
    "CMakeLists.txt",
    "CHANGELOG.md",
    "config/cluster/kubernetes/frames.yaml",
    "config/cluster/kubernetes/pool.yaml",
    "config/debian/control",
    "docs/guide/install.md",
    "grabber/package.json",
    "grabber/package-lock.json",
    "raytracer/apps/python/pyproject.toml",
    "voxelserver/serve/page/package.json",
    "voxelserver/serve/page/package-lock.json",
)
MINOR = version().rpartition(".")[0]
GIT = ("git", "-c", "user.name=T", "-c", "user.email=t@example.org", "-c", "commit.gpgsign=false")


class Check(Case):
    def setUp(self):
        super().setUp()
        self.folder = temporary_folder() / "checkout"
        for name in READ:
            (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, self.folder / name)
        self.replace("CHANGELOG.md", r"(?m)^## .*", f"## {version()}, 2026-12-01", 1)
        self.git("init", "--quiet")
        self.commit()

    def git(self, *words):
        command = [*GIT, "-C", self.folder, *words]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)

    def commit(self):
        self.git("add", "--all")
        self.git("commit", "--quiet", "--message", "state")

    def replace(self, name, pattern, text, count=0):
        file = self.folder / name
        old = file.read_text(encoding="utf-8")
        new = re.sub(pattern, text, old, count=count)
        self.assertNotEqual(old, new, (name, pattern))
        file.write_text(new, encoding="utf-8")

    def write(self, name, text):
        file = self.folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
        self.commit()

    def other(self, name, found):
        return f"{name} has version {found}; CMakeLists.txt has {version()}"

    def problems(self):
        run = tool("check_release.py", self.folder)
        self.assertDone(run)
        return run.out.splitlines()

    def test_a_checkout_can_be_released_whose_versions_agree(self):
        self.assertEqual(self.problems(), [])

    def test_each_file_with_another_version_is_named(self):
        was = re.escape(version())
        for name in (
            "config/cluster/kubernetes/frames.yaml",
            "config/cluster/kubernetes/pool.yaml",
            "docs/guide/install.md",
            "grabber/package.json",
            "grabber/package-lock.json",
            "voxelserver/serve/page/package.json",
        ):
            with self.subTest(name):
                self.replace(name, was, "7.8.9", 1)
                self.commit()
                found = self.problems()
                self.assertEqual(len(found), 1, found)
                self.assertIn(f"{name} has version 7.8.9", found[0])
                self.git("revert", "--no-edit", "HEAD")

    def test_each_name_with_another_version_is_found_wherever_it_is(self):
        for name, text, found in (
            ("notes/new.md", "See `terravox-data_7.8.9_all.deb`.", "7.8.9"),
            ("notes/new.md", "https://example.org/v/terravox-v7.8.9", "7.8.9"),
            ("notes/new.md", "the package libterravox7.8", "7.8"),
            ("notes/new.md", "linked with libterravox.so.7.8.9", "7.8"),
            ("config/new/pod.yaml", "    - image: registry.example/terravox:7.8.9", "7.8.9"),
            ("config/new/pod.yaml", "  image: terravox:latest", "latest"),
            ("config/new/pod.yaml", f"  image: terravox:{MINOR}", MINOR),
            ("config/new/pod.yaml", "  image: terravox", "none"),
        ):
            with self.subTest(text):
                self.write(name, f"first line\n{text}\n")
                self.assertEqual(self.problems(), [self.other(name, found)])
                self.git("revert", "--no-edit", "HEAD")

    def test_what_names_no_version_of_this_project_is_no_problem(self):
        name = version()
        for text in (
            f"terravox_{name}_amd64.deb, terravox:{name}",
            f"libterravox{MINOR}, libterravox.so.{MINOR}, libterravox.so.{name}",
            "terravox_VERSION_amd64.deb, `terravox:VERSION`, libterravox.so, libterravox-dev",
            "terravox:origin, terravox-coordinator:7879, image: terravox-gui:3, nginx:1.2.3",
            "a picture of terravox, 7.8.9 of another program",
        ):
            with self.subTest(text):
                self.write("notes/new.md", text)
                self.assertEqual(self.problems(), [])

    def test_history_and_made_up_versions_are_left_out(self):
        self.write("tests/e2e/new_test.py", 'FILE = "terravox_7.8.9_all.deb"\n')
        self.replace("CHANGELOG.md", r"\Z", "\n## 0.0.1, 2025-01-01\n\nAs terravox:0.0.1.\n", 1)
        (self.folder / "picture.png").write_bytes(b"\x89PNG\xff terravox:7.8.9")
        self.commit()
        self.assertEqual(self.problems(), [])

    def test_a_new_version_is_missed_everywhere_else(self):
        self.replace("CMakeLists.txt", rf"VERSION {re.escape(version())}", "VERSION 7.8.9")
        self.commit()
        found = "\n".join(self.problems())
        for name in ("frames.yaml", "pool.yaml", "install.md", "package-lock.json", "CHANGELOG"):
            self.assertIn(name, found)

    def test_a_change_without_a_date_is_named(self):
        self.replace("CHANGELOG.md", r"2026-12-01", "unreleased")
        self.commit()
        self.assertEqual(
            self.problems(),
            [
                f"CHANGELOG.md begins with '{version()}, unreleased'; "
                f"a release wants '{version()}, YYYY-MM-DD'"
            ],
        )

    def test_what_is_not_committed_is_named(self):
        (self.folder / "new file").write_text("x", encoding="utf-8")
        self.replace("CHANGELOG.md", r"\Z", "\nmore\n", 1)
        found = self.problems()
        self.assertEqual(len(found), 2, found)
        self.assertIn("CHANGELOG.md", found[0])
        self.assertIn("new file", found[1])

    def test_this_checkout_misses_no_more_than_its_date_and_commits(self):
        run = tool("check_release.py", ROOT)
        self.assertDone(run)
        lines = run.out.splitlines()
        others = [line for line in lines if not re.match(r"CHANGELOG.md|not committed", line)]
        self.assertEqual(others, [])


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
"""The documents hold: the commands of README.md and docs/guide run, links lead somewhere, options
exist, and messages are those of the sources. markdown.py lists the comments that steer it."""

import os
import pathlib
import re
import unittest

import markdown
import options
from checkout import run_page
from support import ROOT, Case, only_in_all, temporary_folder

GUIDE = ROOT / "docs" / "guide"
FORMATS = ROOT / "docs" / "formats"
RUN_PAGES = [ROOT / "README.md", *sorted(GUIDE.glob("*.md"))]
README_LINES = 100
NOT_OURS = {"build", "node_modules", "dist", "dist-test", ".git"}
SOURCES = ("common", "config", "docs", "grabber", "raytracer", "tests", "voxelserver")
TEXTS = {".cpp", ".hpp", ".ts", ".py", ".sh", ".toml", ".proto", ".sql", ".json", ".md"}
# A path from the top, without letters that stand for a name (config/tints/NAME.toml).
NAMED_SOURCE = re.compile(
    r"(?<![\w./<*-])(?:common|config|grabber|raytracer|tests|voxelserver)/[a-z0-9_./-]+"
    r"\.(?:cpp|hpp|ts|py|sh|toml)\b(?![\w*-])"
)


def files_below(folder, endings):
    """Those of the repository, not those that were built or fetched."""
    for path, inner, names in os.walk(folder):
        inner[:] = sorted(set(inner) - NOT_OURS)
        if pathlib.Path(path) == ROOT and "out" in inner:  # what commands of the pages write
            inner.remove("out")
        for name in sorted(names):
            file = pathlib.Path(path, name)
            if file.suffix in endings:
                yield file


class Commands(Case):
    """One test for each page; they are added here."""


def run_commands_of(page):
    def test(_):
        run_page(page)

    return only_in_all(test) if page.is_relative_to(GUIDE) else test


for one in RUN_PAGES:
    name = "test_commands_of_" + re.sub(r"\W", "_", str(one.relative_to(ROOT)))
    setattr(Commands, name, run_commands_of(one))


class Pages(Case):
    def test_links_and_anchors_of_all_pages_lead_somewhere(self):
        pages = list(files_below(ROOT, {".md"}))
        self.assertIn(ROOT / "docs" / "glossary.md", pages)
        broken = [line for page in pages for line in markdown.broken_links(page, ROOT)]
        self.assertEqual(broken, [])

    def test_pages_that_sources_name_exist(self):
        missing = set()
        for folder in SOURCES:
            for file in files_below(ROOT / folder, TEXTS):
                text = file.read_text(encoding="utf-8", errors="replace")
                for name in re.findall(r"(?<![\w./-])docs/[\w./-]+\.md\b", text):
                    if not (ROOT / name).exists():
                        missing.add(f"{file.relative_to(ROOT)}: {name}")
        self.assertEqual(sorted(missing), [])

    def test_sources_that_pages_name_exist(self):
        missing = set()
        for page in files_below(ROOT, {".md"}):
            text = page.read_text(encoding="utf-8")
            for name in NAMED_SOURCE.findall(text):
                if not (ROOT / name).exists():
                    missing.add(f"{page.relative_to(ROOT)}: {name}")
        self.assertEqual(sorted(missing), [])

    def test_sources_to_look_at_first_exist(self):
        text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
        text = text.partition("## Where to look first")[2].partition("\n## ")[0]
        folders, found = [], []
        for line in text.splitlines():
            if headed := re.findall(r"\(`([\w/]+)`\)", line) if line.startswith("| ") else []:
                folders = headed
            elif line.startswith("| "):
                names = [cell.strip() for cell in line.strip("|").split("|")]
                found += [ROOT / folder / name for folder, name in zip(folders, names, strict=True)]
        self.assertGreater(len(found), 20)
        self.assertEqual([str(file) for file in found if not file.is_file()], [])

    def test_readme_is_short(self):
        lines = (ROOT / "README.md").read_text(encoding="utf-8").splitlines()
        self.assertLessEqual(len(lines), README_LINES)

    def test_each_page_of_a_folder_is_in_its_index(self):
        for folder in (GUIDE, FORMATS):
            listed = {target for _, target in markdown.links(folder / "README.md")}
            there = {page.name for page in folder.glob("*.md")} - {"README.md"}
            self.assertEqual(there - listed, set(), folder)

    def test_options_exist(self):
        wrong = []
        for page in [*RUN_PAGES, *sorted(FORMATS.glob("*.md"))]:
            for block in markdown.read(page)[1]:
                for line in markdown.commands(block):
                    wrong += [f"{block}: {flag}" for flag in options.unknown_in_command(line)]
            for line, text in markdown.spans(page):
                flags = options.unknown(markdown.flags(text))
                wrong += [f"{page}:{line}: {flag}" for flag in flags]
        self.assertEqual(wrong, [])

    def test_messages_of_the_troubleshooting_page_are_those_of_the_sources(self):
        files = [ROOT / "terravox", *ROOT.glob("config/setup/*.sh")]
        files += files_below(ROOT / "grabber" / "src", {".ts"})
        for folder in ("common", "raytracer", "voxelserver"):
            files += files_below(ROOT / folder, {".cpp", ".hpp"})
        sources = "\n".join(file.read_text(encoding="utf-8") for file in files)
        # The compiler joins literals that stand one after the other.
        sources = re.sub(r'"\s*\n\s*"', "", sources)
        page = (GUIDE / "troubleshooting.md").read_text(encoding="utf-8")
        messages = re.findall(r"^\| `([^`]+)` \|", page, re.M)
        self.assertGreater(len(messages), 40)
        missing = []
        for message in messages:
            for part in re.split(r" ?\.\.\. ?", message):  # it stands for a value
                if part not in sources:
                    missing.append(f"'{part}' of '{message}'")
        self.assertEqual(missing, [])


class ThisTest(Case):
    """It can fail."""

    def page(self, text):
        page = temporary_folder() / "page.md"
        page.write_text(text, encoding="utf-8")
        return page

    def test_a_command_that_fails_is_found(self):
        wrong = "\n    ./terravox world info nowhere\n"
        with self.assertRaisesRegex(AssertionError, "page.md:3: exit code 2, not 0"):
            run_page(self.page("Try:\n" + wrong))
        run_page(self.page("<!-- exit code: 2 -->\n" + wrong))

    def test_a_comment_that_steers_nothing_is_found(self):
        with self.assertRaisesRegex(ValueError, "page.md:1: 'not runn'"):
            markdown.read(self.page("<!-- not runn: why -->\n"))

    def test_a_broken_link_is_found(self):
        page = self.page(
            "# One, two: `three`\n"
            "[a](nowhere.md) [b](#one-two-three) [c](#four) `[d](no)`\n"
            "\n"
            "    [e](no)\n"
        )
        self.assertEqual(
            markdown.broken_links(page, page.parent),
            ["page.md:2: nowhere.md: no such file", "page.md:2: #four: no such heading"],
        )

    def test_an_option_that_does_not_exist_is_found(self):
        for line, unknown in (
            ("./terravox render DATA --size 1x1 --sizes 2  # --no", ["--sizes"]),
            ("A=b ./terravox serve DATA --port 1 --look x", ["--look"]),
            ("./terravox test --loaded 5", []),
            ("curl --silent address", []),
        ):
            self.assertEqual(options.unknown_in_command(line), unknown, line)
        self.assertEqual(options.unknown(["--look", "--lok", "--generated-"]), ["--lok"])


if __name__ == "__main__":
    unittest.main()

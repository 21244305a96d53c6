#!/usr/bin/env python3
"""cmake --install: the programs in a prefix of their own, moved, without the checkout."""

import json
import os
import pathlib
import shutil
import sys
import unittest
import urllib.request

import markdown
from installed import hidden, moved_prefix, rows, start
from support import HANGS_S, ROOT, Case, Run, binary, survey, temporary_folder

PICTURE = ("--size", "64x36", "--samples", "1", "--cache", "none", "--quiet")


def node_folder():
    """@return the folder of Node.js where it is not in the checkout, which is hidden"""
    folder = pathlib.Path(os.environ["TERRAVOX_NODE"]).resolve().parent
    return None if folder.is_relative_to(ROOT) else folder


class Installed(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        if not hidden():
            print("the checkout cannot be hidden here: it stays visible", file=sys.stderr)
        cls.prefix = moved_prefix()
        cls.terravox = cls.prefix / "bin" / "terravox"
        cls.folder = temporary_folder()

    def run_installed(self, *arguments, **options):
        options.setdefault("cwd", self.folder)
        return Run([*hidden(), self.terravox, *arguments], **options)

    def test_a_picture_has_the_bytes_of_the_checkouts(self):
        ours, theirs = (self.folder / f"{name}.png" for name in ("checkout", "installed"))
        words = [survey(), "--ortho", survey() / "ortho", *PICTURE, "--materials", "clay", "-o"]
        self.assertDone(Run([binary("RAYTRACER"), "render", *words, ours]))
        self.assertDone(self.run_installed("render", *words, theirs))
        self.assertEqual(ours.read_bytes(), theirs.read_bytes())

    def test_jobs_of_clusters_are_filled_from_the_installed_templates(self):
        run = self.run_installed(
            *("cluster", "kubernetes", "--image", "i", "--claim", "c", "--nodes", "2"),
            *("generated:7", "-o", "a.png"),
        )
        self.assertDone(run)
        self.assertEqual(len(json.loads(run.out)["items"]), 3)
        dry = ("cluster", "slurm", "--dry-run", "--folder", self.folder / "job")
        self.assertDone(self.run_installed(*dry, "generated:7", "-o", "a.png"))
        self.assertDone(Run(["bash", "-n", self.folder / "job" / "worker.sbatch"]))

    def test_licences_of_what_is_compiled_in_and_of_the_page_are_there(self):
        folder = self.prefix / "share" / "doc" / "terravox"
        for name, words in {
            "LICENSE": "Apache License",
            "THIRD_PARTY.md": "## Compiled in",
            "copyright": "ProggyClean, in Dear ImGui",
            "licences-page.txt": "(MIT)",
        }.items():
            with self.subTest(name):
                self.assertIn(words, (folder / name).read_text(encoding="utf-8"))

    def test_the_documents_are_there_and_lead_to_each_other(self):
        folder = self.prefix / "share" / "doc" / "terravox"
        for name in ("guide", "formats"):
            pages = sorted((ROOT / "docs" / name).glob("*.md"))
            self.assertTrue(pages)
            for page in pages:
                installed = folder / name / page.name
                self.assertEqual(installed.read_bytes(), page.read_bytes())
                local = (target for _, target in markdown.links(page) if "://" not in target)
                for target in local:
                    file = (page.parent / target.partition("#")[0]).resolve()
                    if file.is_relative_to(ROOT / "docs") and "gallery" not in file.parts:
                        there = folder / file.relative_to(ROOT / "docs")
                        self.assertTrue(there.exists(), f"{page.name}: {target}")

    def test_it_runs_through_a_symbolic_link(self):
        link = temporary_folder() / "tvx"
        link.symlink_to(self.terravox)
        other = temporary_folder() / "raytracer"
        other.symlink_to(self.prefix / "lib" / "terravox" / "terravox-raytracer")
        for words in ([link, "render"], [other, "render"]):
            picture = temporary_folder() / "linked.png"
            run = Run([*hidden(), *words, "generated:5", *PICTURE, "-o", picture])
            self.assertDone(run)
            self.assertTrue(picture.exists())

    def test_a_survey_is_made_checked_and_converted(self):
        made = self.folder / "made"
        self.assertDone(self.run_installed("survey", "--square-m", "64", "-o", made))
        square = next(made.glob("*.laz"))
        self.assertDone(self.run_installed("laz", "check", square))
        archive = self.folder / "made.tvx"
        words = [made, archive, "--quiet"]
        self.assertDone(self.run_installed("convert", *words))
        run = self.run_installed("world", "info", archive)
        self.assertDone(run)
        self.assertIn("voxel", run.out)
        if (self.prefix / "lib" / "terravox" / "terravox-vdb.so").exists():
            self.assertDone(self.run_installed("convert", made, self.folder / "made.vdb"))

    def test_a_minecraft_world_is_written_with_the_shipped_blocks(self):
        world = self.folder / "a world"
        self.assertDone(self.run_installed("convert", survey(), world, "--level", "2", "--quiet"))
        self.assertTrue((world / "level.dat").exists())

    def test_a_site_is_published(self):
        site = self.folder / "site"
        run = self.run_installed("publish", survey(), site, "--no-preview", "--quiet")
        self.assertDone(run)
        self.assertTrue((site / "index.html").exists())

    def test_a_server_answers(self):
        server = start(self.terravox, "serve", survey(), "--port", "0", "--cache", "none")
        try:
            line = server.stdout.readline()
            self.assertIn("listening on http://", line)
            with urllib.request.urlopen(f"{line.split()[-1]}/healthz", timeout=HANGS_S) as reply:
                self.assertEqual(reply.read(), b"ok\n")
            with urllib.request.urlopen(line.split()[-1], timeout=HANGS_S) as reply:
                self.assertIn(b"<html", reply.read())
        finally:
            server.terminate()
            server.stdout.close()
            self.assertEqual(server.wait(HANGS_S), 0)

    def test_every_command_explains_itself(self):
        listed = self.run_installed("help")
        self.assertDone(listed)
        for name, program, text in rows():
            with self.subTest(name):
                self.assertIn(f"\n  {name} ", listed.out)
                self.assertIn(text.split()[-1], listed.out)
                words = program.split()
                if (self.prefix / "lib" / "terravox" / words[0]).is_file():
                    run = self.run_installed(name.split()[0], "--help")
                    self.assertDone(run)
                    self.assertIn("--help", run.out)

    def test_a_newcomer_is_told_what_to_do_first(self):
        for run in (self.run_installed(), Run([ROOT / "terravox"])):
            self.assertDone(run)
            self.assertLessEqual(len(run.out.splitlines()), 12)
            for part in ("terravox render DATA", "terravox help lists all commands"):
                self.assertIn(part, run.out)
        self.assertIn("terravox demo", run.out)

    def test_help_explains_a_command(self):
        self.assertEqual(
            self.run_installed("help", "laz", "info").out,
            self.run_installed("laz", "info", "--help").out,
        )
        self.assertEqual(self.run_installed("help", "help").out, self.run_installed("help").out)
        self.assertRefused(self.run_installed("help", "paint"), 2, "unknown command 'paint'")

    def test_a_mistyped_command_is_told_what_was_meant(self):
        for typed, meant in {"Render": "render", "sreve": "serve", "grabb": "grab"}.items():
            with self.subTest(typed):
                self.assertRefused(self.run_installed(typed), 2, f"; did you mean {meant}? ")
                self.assertRefused(Run([ROOT / "terravox", typed]), 2, f"did you mean {meant}? ")
        self.assertRefused(Run([ROOT / "terravox", "biuld"]), 2, "did you mean build? ")
        self.assertRefused(self.run_installed("frobnicate"), 2, "'frobnicate'; terravox help lists")
        self.assertRefused(Run([ROOT / "terravox", "ox"]), 2, "'ox'; terravox help lists")

    def test_a_checkout_offers_the_same_commands_and_those_of_developers(self):
        checkout = Run([ROOT / "terravox", "help"])
        self.assertDone(checkout)
        installed = self.run_installed("help").out.splitlines()
        theirs = [line for line in installed if line.startswith("  ")]
        self.assertEqual([line for line in theirs if line not in checkout.out.splitlines()], [])
        for word in ("deps", "build", "test", "lint", "clean", "demo"):
            self.assertIn(f"\n  {word} ", checkout.out)
            self.assertNotIn(f"\n  {word} ", "\n".join(theirs))
            self.assertRefused(self.run_installed(word), 2, f"unknown command '{word}'")

    def test_the_version_is_that_of_the_checkout(self):
        ours = Run([ROOT / "terravox", "--version"])
        self.assertEqual(self.run_installed("--version").out, ours.out)

    def test_nothing_names_the_checkout(self):
        named = [
            str(file.relative_to(self.prefix))
            for file in self.prefix.rglob("*")
            if file.is_file() and str(ROOT).encode() + b"/" in file.read_bytes()
        ]
        self.assertEqual(named, [])

    def test_the_grabber_reads_the_shipped_configuration(self):
        node = node_folder()
        if node is None:
            self.skipTest("Node.js is in the checkout, which is hidden")
        environment = {"PATH": f"{node}:{os.environ['PATH']}"}
        run = self.run_installed("grab", "areas", environment=environment)
        self.assertDone(run)
        self.assertIn("bled", run.out)
        store = self.folder / "store"
        words = ["fetch", "--from", survey(), "--store", store, "--crs", "EPSG:3794"]
        words += ["--licence", "CC0", "--attribution", "A"]
        self.assertDone(self.run_installed("grab", *words, environment=environment))
        run = self.run_installed("grab", "status", "--store", store, environment=environment)
        self.assertDone(run)

    def run_with_node(self, *lines):
        """Runs the grabber where this script is the only node.

        @return the folder of the script, and the run
        """
        folder = temporary_folder()
        for name in ("bash", "dirname", "head", "readlink", "sed", "sort"):
            (folder / name).symlink_to(shutil.which(name))
        if lines:
            node = folder / "node"
            node.write_text("\n".join(["#!/bin/sh", *lines, ""]), encoding="utf-8")
            node.chmod(0o755)
        # Nothing of the checkout could be used: the command is found, and what it starts is ours.
        words = [self.terravox, "grab", "areas"]
        return folder, Run(words, environment={"PATH": str(folder)}, cwd=self.folder)

    def test_every_node_from_the_oldest_on_is_started(self):
        oldest = json.loads((ROOT / "grabber" / "package.json").read_text(encoding="utf-8"))
        version = oldest["engines"]["node"].removeprefix(">=")
        main = self.prefix / "lib" / "terravox" / "grabber" / "dist" / "main.js"
        for found in (version, "22.20.0", "100.0.0"):
            with self.subTest(found):
                answer = f'[ "$1" = --version ] && echo v{found} || echo "$@"'
                _, run = self.run_with_node(answer)
                self.assertDone(run)
                self.assertEqual(run.out, f"{main} areas\n")

    def test_no_node_or_one_that_is_too_old_is_refused_with_a_remedy(self):
        remedy = ("install 20.18.1 or newer", "nodejs of Debian 13", "https://nodejs.org")
        _, run = self.run_with_node()
        self.assertRefused(run, 1, "Node.js is not installed", *remedy)
        for found in ("20.18.0", "9.9.9"):
            with self.subTest(found):
                folder, run = self.run_with_node(f"echo v{found}")
                self.assertRefused(run, 1, f"{folder}/node is Node.js {found}", *remedy)
        folder, run = self.run_with_node("exit 1")
        self.assertRefused(run, 1, f"{folder}/node does not start", *remedy)


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
"""terravox fuzz: names, sources and targets agree; the exit code reports a finding."""

import re
import stat
import unittest

from support import ROOT, Case, Run, temporary_folder

TARGETS = ROOT / "tests" / "fuzz"
SHARED = {"entry", "fuzz", "file_corpora", "picture_corpora", "toml_parser"}

# The targets are scripts here, so that the test needs no clang.
WITH_OWN_TARGETS = """
set -euo pipefail
shopt -s inherit_errexit
ROOT=$1 LOGS=$2/logs VERBOSE=0 TERRAVOX_NO_BUILD=1
. "$ROOT/config/setup/say.sh"
. "$ROOT/config/setup/gallery.sh"
. "$ROOT/config/setup/fuzz.sh"
FUZZ_DIR=$2 FUZZ_DATA=$2/none
fuzz "${@:3}"
"""
CORPORA = """#!/bin/sh
mkdir -p "$1/nbt" && echo seed > "$1/nbt/seed"
"""
GOOD = """#!/bin/sh
echo '#2 INITED cov: 5 ft: 6 corp: 1/4b'
echo '#99 DONE   cov: 17 ft: 20 corp: 2/9b lim: 4 exec/s: 9 rss: 30Mb'
echo 'stat::number_of_executed_units: 99'
"""
BAD = """#!/bin/sh
echo '==7==ERROR: AddressSanitizer: heap-buffer-overflow on address 0x1'
for word; do case $word in -artifact_prefix=*) prefix=${word#*=} ;; esac; done
echo bad > "${prefix}crash-1"
echo "artifact_prefix='$prefix'; Test unit written to ${prefix}crash-1"
echo '#7 pulse  cov: 12 ft: 20'
echo 'stat::number_of_executed_units: 7'
exit 77
"""


def fuzz(*arguments):
    return Run([ROOT / "terravox", "fuzz", *arguments], environment={"TERRAVOX_NO_BUILD": "1"})


def fuzz_with(folder, target, *arguments, **others):
    """@param others  more targets: the text of each by its name"""
    (folder / "targets").mkdir(exist_ok=True)
    targets = {f"fuzz-{name}": text for name, text in others.items()}
    for name, text in {"fuzz-file-corpora": CORPORA, "fuzz-nbt": target, **targets}.items():
        program = folder / "targets" / name
        program.write_text(text)
        program.chmod(program.stat().st_mode | stat.S_IXUSR)
    return Run(["bash", "-c", WITH_OWN_TARGETS, "fuzz", ROOT, folder, *arguments])


class Fuzz(Case):
    def test_names_sources_and_targets_agree(self):
        run = fuzz("--list")
        self.assertEqual(run.code, 0, run)
        listed = {line.split()[0] for line in run.out.splitlines()}
        sources = {source.stem for source in TARGETS.glob("*.cpp")} - SHARED
        built = re.findall(
            r"^terravox_fuzz\((\w+)\s", (TARGETS / "CMakeLists.txt").read_text(), re.M
        )
        self.assertEqual(sorted(built), sorted(sources))
        self.assertEqual(listed, sources | {"grabber"})

    def test_wrong_words_are_answered_with_what_is_allowed(self):
        for arguments, said in (
            (["nope"], "no target is called 'nope'; allowed: animation"),
            (["--nope"], "unknown option '--nope'"),
            (["--seconds"], "--seconds lacks its value"),
            (["--seconds", "soon"], "--seconds 'soon'; allowed: 1 to 999999"),
            (["--jobs", "65"], "--jobs '65'; allowed: 1 to 64"),
        ):
            with self.subTest(arguments):
                run = fuzz(*arguments)
                self.assertEqual(run.code, 2, run)
                self.assertIn(said, run.err)

    def test_a_target_without_a_find_is_a_line_of_the_table(self):
        folder = temporary_folder()
        run = fuzz_with(folder, GOOD, "--seconds", "1", "nbt")
        self.assertEqual(run.code, 0, run)
        lines = [line.split() for line in run.out.splitlines()]
        self.assertEqual(lines[0], ["target", "executions", "edges", "corpus", "finds"])
        self.assertEqual(lines[1:], [["nbt", "99", "17", "0", "0"]])

    def test_a_find_is_an_exit_code_of_1_with_the_command_that_repeats_it(self):
        folder = temporary_folder()
        run = fuzz_with(folder, BAD, "--seconds", "1", "nbt")
        self.assertEqual(run.code, 1, run)
        self.assertEqual(run.out.splitlines()[1].split(), ["nbt", "7", "12", "0", "1"])
        self.assertIn("heap-buffer-overflow", run.err)
        find = folder / "finds" / "nbt" / "crash-1"
        self.assertTrue(find.exists())
        self.assertTrue(run.err.rstrip().endswith(f"{folder}/targets/fuzz-nbt {find}"), run.err)

    def test_targets_at_a_time_are_lines_each_and_a_find_of_one_is_reported(self):
        for good in ("box", "zip"):
            with self.subTest(good):
                folder = temporary_folder()
                texts = {name: GOOD if name == good else BAD for name in ("box", "nbt", "zip")}
                run = fuzz_with(
                    folder, texts.pop("nbt"), "--jobs", "2", "box", "nbt", "zip", **texts
                )
                self.assertEqual(run.code, 1, run)
                lines = sorted(line.split() for line in run.out.splitlines()[1:])
                finds = [[name, finds] for name, *_, finds in lines]
                self.assertEqual(
                    finds, [[n, "0" if n == good else "1"] for n in ("box", "nbt", "zip")]
                )

    def test_a_target_that_was_never_built_is_an_error(self):
        folder = temporary_folder()
        run = fuzz_with(folder, GOOD, "--seconds", "1", "las")
        self.assertEqual(run.code, 1, run)
        self.assertIn("fuzz-las was never built", run.err)


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
"""Man pages and the completion of command lines, as they are installed."""

import os
import pathlib
import re
import shlex
import shutil
import unittest

from installed import hidden, moved_prefix
from support import Case, Run

# Sources the completion and completes the words that follow; the last is unfinished.
COMPLETE = """
. "$0"
COMP_WORDS=("$@")
COMP_CWORD=$(($# - 1))
compopt() { echo files; }
_terravox
((${#COMPREPLY[@]} == 0)) || printf '%s\\n' "${COMPREPLY[@]}"
"""

# Types a line and Tab into a zsh in a terminal of its own, and prints what is offered. The function
# that takes offers is replaced by one that prints them. The terminal shows what is typed, too,
# which is not to be taken for an answer.
ZSH = r"""
zmodload zsh/zpty
zpty shell zsh -f -i
tell() { zpty -w shell "$1" }
tell 'PS1= PS2=; stty -echo; fpath=("'$1'" $fpath); autoload -Uz compinit; compinit -u -D'
tell 'compadd() {
    if [[ ${@[1,(i)(-|--)]} == *-(O|A|D)\ * ]]; then builtin compadd "$@"; return; fi
    local -a hits
    builtin compadd -A hits "$@"
    [[ -z $hits ]] || print -rl -- OFFER:${^hits}
}'
tell 'show() { zle complete-word; print E""ND; exit }'
tell 'zle -N show; bindkey "^I" show; print RE""ADY'
zpty -r shell out '*READY*'
zpty -w -n shell "$2"$'\t'
while zpty -r shell out; do
    print -r -- "$out"
    [[ $out != *END* ]] || break
done
"""


def plain(roff):
    """The text of a page without the marks of fonts and letters."""
    return re.sub(r"\\f[BIR]", "", roff).replace("\\-", "-").replace("\\(aq", "'")


class Manual(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.prefix = moved_prefix()
        cls.man = cls.prefix / "share" / "man" / "man1"
        cls.pages = {file.stem: file for file in cls.man.glob("*.1")}

    def help_of(self, page):
        words = page.split("-")[1:]
        # Commands of the grabber have hyphens in none of their names, and neither have the others.
        # Its help has one part.
        which = [] if words[:1] == ["grab"] else ["all"]
        return Run([*hidden(), self.prefix / "bin" / "terravox", *words, "--help", *which])

    def test_each_command_has_a_page(self):
        for page in ("render", "analyse-sky", "laz-index", "world-info", "cluster-slurm", "serve"):
            self.assertIn(f"terravox-{page}", self.pages)
        self.assertIn("terravox", self.pages)

    def test_each_option_of_help_stands_in_the_page(self):
        node = shutil.which("node")
        built_for = pathlib.Path(os.environ["TERRAVOX_NODE"])
        has_node = node is not None and built_for.samefile(node)
        for page, file in self.pages.items():
            if page == "terravox" or (page.startswith("terravox-grab") and not has_node):
                continue
            with self.subTest(page):
                run = self.help_of(page)
                self.assertDone(run)
                text = plain(file.read_text(encoding="utf-8"))
                lines = re.findall(r"^  +((?:-\w, ?)?--[a-z][\w,-]*)", run.out, flags=re.M)
                self.assertTrue(lines, run.out)
                options = [name for line in lines for name in re.split(r", ?", line)]
                missing = [name for name in options if not re.search(rf"{name}(?![\w-])", text)]
                self.assertEqual(missing, [])

    def test_pages_name_no_path_of_this_machine(self):
        for page, file in self.pages.items():
            self.assertNotRegex(file.read_text(encoding="utf-8"), r"/(root|home|tmp)/", page)

    def test_the_tools_for_pages_have_no_warnings(self):
        tools = {"mandoc": ["-Tlint", "-W", "warning"], "man": ["--warnings", "-l", "-Tutf8"]}
        for tool, words in tools.items():
            with self.subTest(tool):
                if shutil.which(tool) is None:
                    self.skipTest(f"{tool} is not installed")
            for page, file in self.pages.items() if shutil.which(tool) else ():
                with self.subTest(f"{tool} {page}"):
                    run = Run([tool, *words, file], environment={"MANWIDTH": "80"})
                    self.assertDone(run)
                    self.assertEqual(run.err, "")


class Completion(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.file = moved_prefix() / "share" / "bash-completion" / "completions" / "terravox"

    def complete(self, *words):
        run = Run(["bash", "--norc", "-c", COMPLETE, self.file, "terravox", *words])
        self.assertDone(run)
        self.assertEqual(run.err, "")
        return run.out.splitlines()

    def test_commands_options_values_and_files_are_offered(self):
        cases = (
            (("",), {"render", "laz", "help", "--version"}, {"build", "test"}),
            (("re",), {"render"}, {"serve"}),
            (("analyse", ""), {"terrain", "sky", "sun"}, {"render"}),
            (("analyse", "sky", "--surf"), {"--surface"}, {"--relief"}),
            (("render", "--out"), {"--output", "--output-size"}, {"--quiet"}),
            (("render", "x.laz", "--tone", ""), {"filmic", "agx"}, {"--tone"}),
            (("render", "x.laz", "--tone", "=", "fi"), {"filmic"}, {"agx"}),
            (("render", "--tone", "="), {"filmic", "agx"}, set()),
            (("render", "--log", "w"), {"warn"}, {"off"}),
            (("analyse", "terrain", "--relief", ""), {"dtm", "dsm"}, set()),
            (("convert", "--up", ""), {"y", "z"}, set()),
            (("render", ""), {"files"}, {"render"}),
            (("render", "--scene", ""), {"files"}, set()),
            # The value of an option is no command.
            (("laz", "info", "index", "--h"), {"--help"}, set()),
            (("farm", ""), {"certs", "status", "pause", "resume"}, set()),
        )
        for words, offered, others in cases:
            with self.subTest(shlex.join(words)):
                found = set(self.complete(*words))
                self.assertEqual(offered - found, set())
                self.assertEqual(others & found, set())

    def test_fish_reads_its_completion(self):
        if shutil.which("fish") is None:
            self.skipTest("fish is not installed")
        file = moved_prefix() / "share" / "fish" / "vendor_completions.d" / "terravox.fish"
        script = f"source {shlex.quote(str(file))}; complete --do-complete $argv"
        for line, wanted in (
            ("terravox ren", "render"),
            ("terravox analyse sk", "sky"),
            ("terravox render --ton", "--tone"),
            ("terravox render --tone fil", "filmic"),
        ):
            home = {"HOME": os.environ.get("TMPDIR", "/tmp"), "TERM": "dumb"}
            run = Run(["fish", "--no-config", "-c", script, line], environment=home)
            self.assertDone(run)
            found = [text.split("\t")[0] for text in run.out.splitlines()]
            self.assertIn(wanted, found, str(run))

    def test_zsh_reads_its_completion(self):
        if shutil.which("zsh") is None:
            self.skipTest("zsh is not installed")
        folder = moved_prefix() / "share" / "zsh" / "vendor-completions"
        for line, wanted, other in (
            ("terravox ren", "render", "serve"),
            ("terravox analyse sk", "sky", "terrain"),
            ("terravox render --ton", "--tone", "--camera"),
            ("terravox render --tone fil", "filmic", "agx"),
            ("terravox render --tone=fil", "filmic", "agx"),
            ("terravox laz info index --he", "--help", "--version"),
        ):
            with self.subTest(line):
                home = {"HOME": os.environ.get("TMPDIR", "/tmp"), "TERM": "dumb"}
                run = Run(["zsh", "-f", "-c", ZSH, "zsh", folder, line], environment=home)
                self.assertDone(run)
                found = re.findall(r"OFFER:(\S+)", run.out)
                self.assertIn(wanted, found, str(run))
                self.assertNotIn(other, found)


if __name__ == "__main__":
    unittest.main()

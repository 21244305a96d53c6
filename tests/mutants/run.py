#!/usr/bin/env python3
"""Mutation tests: seeded faults (tests/mutants/NAME.patch), each of which a test should find.

    ./terravox mutants                     all of them, with the entries of the default tier
    ./terravox mutants --tier all NAME...  these, with every entry
    ./terravox mutants --nearest           with the entries alone that a mutant names
    ./terravox mutants --list

Works in a copy of what git knows of the checkout, changes included: build/mutants/tree, which is
kept, as is its build. A mutant is applied and what its nearest entries run is built; then these
run, and, where none fails, all others of the tier that depend on the changed file. The first that
fails has found it. An entry that fails without the mutant, too, has found nothing: those that have
found something run once more at the end, on the sources as they are. The exit code is 1 where a
mutant survived, does not apply or does not compile.
"""

import argparse
import os
import re
import signal
import subprocess
import sys
import time

from mutants import ROOT, Nearest, all_mutants

sys.path.insert(0, str(ROOT / "tests"))
import tiers  # noqa: E402

HOME = ROOT / "build" / "mutants"
PRESET = "release"
LINKED = ("build/deps", "grabber/node_modules", "voxelserver/serve/page/node_modules")
SKIPPED = re.compile(r"\*\*\*Skipped")


class MutantError(Exception):
    """A mutant that says nothing of the tests: it does not apply, or does not compile."""


def run(command, cwd, log=None, limit_s=None):
    """@return the exit code; None: it did not end. Its output goes to the end of the file log."""
    out = log.open("ab") if log else None
    try:
        process = subprocess.Popen(
            command,
            cwd=cwd,
            stdin=subprocess.DEVNULL,
            stdout=out,
            stderr=subprocess.STDOUT if out else None,
            start_new_session=True,
        )
        try:
            return process.wait(timeout=limit_s)
        except subprocess.TimeoutExpired:
            return None
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()
    finally:
        if out:
            out.close()


def output_of(command, cwd):
    done = subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"mutants: failed: {' '.join(map(str, command))}\n{done.stderr.strip()}")
    return done.stdout


def git(tree, *words):
    return output_of(["git", "-C", tree, *words], tree).strip()


def make_tree():
    """Brings the copy to what git knows of the checkout. Files that do not differ keep their times,
    so that little is built again."""
    tree = HOME / "tree"
    state = git(ROOT, "stash", "create") or git(ROOT, "rev-parse", "HEAD")
    if not (tree / ".git").exists():
        HOME.mkdir(parents=True, exist_ok=True)
        git(ROOT, "clone", "--quiet", "--shared", "--no-checkout", ROOT, tree)
        with (tree / ".git/info/exclude").open("a") as exclude:
            exclude.write("node_modules\n/build\n")
    git(tree, "reset", "--quiet", "--hard", state)
    git(tree, "clean", "--quiet", "--force", "-d")
    for name in LINKED:
        if (ROOT / name).exists() and not (tree / name).exists():
            (tree / name).parent.mkdir(parents=True, exist_ok=True)
            (tree / name).symlink_to(ROOT / name)
    return tree


class Build:
    """The build folder of a tree: its entries, and what they depend on."""

    def __init__(self, tree):
        self.tree = tree
        self.folder = tree / "build" / PRESET
        log = HOME / "configure.log"
        # Again where it was before: entries come and go.
        if run(["cmake", "--preset", PRESET], tree, log) != 0:
            sys.exit(f"mutants: cmake failed; its output is in {log}")
        self.entries = {test.name: test for test in tiers.list_tests(self.folder)}

    def targets_of(self, name):
        """@return what Ninja has to build for an entry"""
        test = self.entries[name]
        targets = set()
        for value in [*test.words, *test.environment.values()]:
            if value.startswith(f"{self.folder}/bin/"):
                targets.add(os.path.relpath(value, self.folder))
        if f"{self.folder}/python" in test.environment.get("PYTHONPATH", ""):
            targets |= {"terravox_python", "terravox_python_sources"}
        if name.startswith("e2e_preview_test"):
            targets.add("bin/terravox-preview")
        return targets

    def is_script(self, name):
        """Whether it is no program with Catch2."""
        return any(word.endswith((".py", ".js", ".mjs")) for word in self.entries[name].words)

    def build(self, targets, log):
        """@return whether they could be built"""
        command = ["ninja", "-C", self.folder, *sorted(targets)]
        return not targets or run(command, self.tree, log) == 0

    def test(self, nearest, log, limit_s):
        """@return whether the entry failed, or did not end"""
        test = self.entries[nearest.entry]
        folder = test.folder or self.folder
        if nearest.part:
            # Of either tier.
            words = [word for word in test.words if word not in ("--tier", "default", "all")]
            return run([*words, nearest.part], folder, log, limit_s) != 0
        if not self.is_script(test.name):  # one failure is enough: a thousand take minutes to print
            return run([*test.words, "--abort"], folder, log, limit_s) != 0
        words = ["--tests-regex", f"^{re.escape(test.name)}$", "--output-on-failure"]
        return run(["ctest", "--test-dir", self.folder, *words], self.tree, log, limit_s) != 0

    def dependents(self, file):
        """@return the entries that the file is built into, or that name it"""
        # Of what was built last: Ninja then knows its headers.
        graph = tiers.Graph(self.folder, self.tree)
        users = [name for name, t in self.entries.items() if tiers.is_touched(t, {file}, graph)]
        return users or list(self.entries)


class Runner:
    def __init__(self, build, args):
        self.build = build
        self.args = args
        self.logs = HOME / "logs"
        self.logs.mkdir(parents=True, exist_ok=True)
        self.found = {}  # mutant: the entry, for those that were found

    def judge(self, mutant):
        """@return the entry that has found the mutant; None: it survived"""
        log = self.logs / f"{mutant.name}.log"
        log.unlink(missing_ok=True)
        words = ["git", "apply", "-p1"]
        if run([*words, mutant.patch], self.build.tree, log) != 0:
            raise MutantError("does not apply")
        try:
            return self._first_that_fails(mutant, log)
        finally:
            run([*words, "--reverse", mutant.patch], self.build.tree, log)

    def _first_that_fails(self, mutant, log):
        nearest = [n for n in mutant.nearest if self._is_of_tier(n.entry)]
        if not nearest and self.args.nearest:
            raise MutantError("none of its entries is in this build and tier")
        found = self._try(mutant, nearest, log)
        if found or self.args.nearest:
            return found
        whole = {n.entry for n in nearest if not n.part}
        others = [name for name in self.build.dependents(mutant.file) if self._is_of_tier(name)]
        others.sort(key=self.build.is_script)  # those of C++ are quicker
        return self._try(mutant, [Nearest(name) for name in others if name not in whole], log)

    def _is_of_tier(self, name):
        if name not in self.build.entries:
            return False  # this build lacks it
        return self.args.tier == "all" or self.build.entries[name].is_default

    def _try(self, mutant, candidates, log):
        for candidate in candidates:
            if not self.build.build(self.build.targets_of(candidate.entry), log):
                raise MutantError(f"does not compile; see {log}")
            is_compiled = mutant.file.startswith("grabber/") and not candidate.part
            grabber = self.build.tree / "grabber"
            if is_compiled and run(["npm", "run", "build"], grabber, log) != 0:
                raise MutantError(f"does not compile; see {log}")
            if self.build.test(candidate, log, self.args.limit_s):
                return candidate
        return None

    def fail_anyway(self, candidates):
        """@return those that fail on the sources as they are"""
        log = self.logs / "unchanged.log"
        log.unlink(missing_ok=True)
        targets = set().union(*(self.build.targets_of(c.entry) for c in candidates))
        if not self.build.build(targets, log):
            sys.exit(f"mutants: the sources as they are do not compile; see {log}")
        return {c for c in candidates if self.build.test(c, log, self.args.limit_s)}


def chosen_mutants(names):
    mutants = all_mutants()
    known = {m.name: m for m in mutants}
    for name in names:
        if name not in known:
            sys.exit(f"mutants: no mutant is called '{name}'; --list names them")
    return [known[name] for name in names] if names else mutants


def row(mutant, result, seconds):
    return f"{mutant.name:32} {mutant.wing:12} {result:40} {seconds:6.0f}"


def run_all(mutants, runner):
    """@return whether all were found"""
    print(f"{'mutant':32} {'wing':12} {'result':40} {'s':>6}", flush=True)
    sound = True
    for mutant in mutants:
        begun = time.monotonic()
        try:
            entry = runner.judge(mutant)
            result = f"found by {entry}" if entry else "survived"
            if entry:
                runner.found[mutant] = entry
        except MutantError as error:
            entry, result = None, f"ERROR: {error}"
        sound = sound and entry is not None
        print(row(mutant, result, time.monotonic() - begun), flush=True)
    wrong = runner.fail_anyway(set(runner.found.values()))
    for mutant, entry in runner.found.items():
        if entry in wrong:
            sound = False
            print(f"{mutant.name}: ERROR: {entry} fails without it, too")
    print(f"{len(runner.found)} of {len(mutants)} mutants were found")
    return sound


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help="mutants; all when none is named")
    parser.add_argument("--tier", choices=("default", "all"), default="default")
    parser.add_argument("--list", action="store_true", help="print the mutants and what they are")
    parser.add_argument("--nearest", action="store_true", help="run the nearest entries alone")
    parser.add_argument(
        "--in-place",
        action="store_true",
        help="in the checkout itself and its release build; it must have no changes",
    )
    parser.add_argument(
        "--limit-s", type=int, default=3600, help="an entry that takes longer hangs (default: 3600)"
    )
    args = parser.parse_args()
    mutants = chosen_mutants(args.names)
    if args.list:
        for m in mutants:
            print(f"{m.name:32} {m.wing:12} {m.fault}")
        return 0
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    HOME.mkdir(parents=True, exist_ok=True)
    if args.in_place and git(ROOT, "status", "--porcelain", "--untracked-files=no"):
        sys.exit("mutants: --in-place: the checkout has changes; allowed: none")
    runner = Runner(Build(ROOT if args.in_place else make_tree()), args)
    return 0 if run_all(mutants, runner) else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit(130)

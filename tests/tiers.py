#!/usr/bin/env python3
"""The tiers of the tests: which entries of CTest belong to one, and what they took.

    tests/tiers.py names default|all             the entries, a line each
    tests/tiers.py names changed [--base COMMIT] the default tier, and those of the others whose
                                                 programs, libraries or sources differ from COMMIT
    tests/tiers.py report FILE                   the dearest entries of a run, and those above their
                                                 budget; FILE: as tests/timed.py writes it

`./terravox test` calls it. Tiers and budgets are in tests/budget. What an entry depends on is read
from the build folder (CTest, Ninja) and from the sources of the test itself, not from a list.
"""

import argparse
import ast
import functools
import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
BUDGET = ROOT / "tests" / "budget"
SHOWN = 10
LINE = re.compile(r"([a-z][a-z0-9_]*) +(default|all) +(\d+)")
SUM = re.compile(r"(default|all) = (\d+)")


def read_budget(path=BUDGET):
    """@return seconds of processor time for each tier, and (tier, seconds) of each entry

    @throws ValueError for a line that is none
    """
    sums, entries = {}, {}
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        if not line or line.startswith("#"):
            continue
        if found := SUM.fullmatch(line):
            sums[found[1]] = int(found[2])
        elif found := LINE.fullmatch(line):
            if found[1] in entries:
                raise ValueError(f"{path}:{number}: {found[1]} stands twice")
            entries[found[1]] = found[2], int(found[3])
        else:
            raise ValueError(f"{path}:{number}: '{line}'; allowed: ENTRY default|all SECONDS")
    return sums, entries


# Which entries there are, and what they run.


class Test:
    """An entry of CTest."""

    def __init__(self, listed):
        self.name = listed["name"]
        properties = {p["name"]: p["value"] for p in listed.get("properties", [])}
        self.is_default = "default" in properties.get("LABELS", [])
        self.folder = properties.get("WORKING_DIRECTORY")
        words = listed.get("command", [])
        timed = [i for i, word in enumerate(words) if word.endswith("/tests/timed.py")]
        # What is measured comes behind the script that measures, and the name of the entry.
        self.words = words[timed[0] + 2 :] if timed else words
        self.environment = dict(
            line.split("=", 1) for line in properties.get("ENVIRONMENT", []) if "=" in line
        )


def list_tests(build):
    command = ["ctest", "--test-dir", build, "--show-only=json-v1"]
    listing = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return [Test(listed) for listed in json.loads(listing)["tests"]]


# What a build's targets are made from.


class Graph:
    """The files that the targets of a build folder depend on, as Ninja knows them."""

    def __init__(self, build, root=ROOT):
        self.build = build
        self.root = root
        self.headers = self.read_headers()
        self.known = {}

    def ninja(self, *words):
        command = ["ninja", "-C", self.build, "-t", *words]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout

    def read_headers(self):
        """@return object file -> what its compiler has read"""
        found, current = {}, []
        for line in self.ninja("deps").splitlines():
            if line.startswith(" "):
                current.append(line.strip())
            elif ": #deps" in line:
                current = found.setdefault(line.split(": #deps")[0], [])
        return found

    def sources(self, target):
        """@return paths in the sources that a file of the build folder is made from"""
        if target not in self.known:
            self.known[target] = self.read_sources(target)
        return self.known[target]

    def read_sources(self, target):
        paths = set()
        for path in self.ninja("inputs", target).splitlines():
            paths.update([path, *self.headers.get(path, [])])
        inside = set()
        for path in paths:
            full = (self.build / path).resolve()
            if full.is_relative_to(self.root) and not full.is_relative_to(self.build):
                inside.add(str(full.relative_to(self.root)))
        return frozenset(inside)


# What a test in Python uses: the modules in its folder, and of these only what it names.


@functools.cache
def parse_module(path):
    """@return name at the top of a module -> the names and texts within its statement"""
    parts = {}
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        words = {n.id for n in ast.walk(node) if isinstance(n, ast.Name)}
        words |= {n.attr for n in ast.walk(node) if isinstance(n, ast.Attribute)}
        texts = {
            n.value
            for n in ast.walk(node)
            if isinstance(n, ast.Constant) and isinstance(n.value, str)
        }
        for name in defined_by(node):
            known = parts.setdefault(name, (set(), set()))
            known[0].update(words)
            known[1].update(texts)
    return parts


def defined_by(node):
    if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
        return [node.name]
    if isinstance(node, (ast.Import, ast.ImportFrom)):
        return []
    if isinstance(node, ast.Assign):
        return [n.id for n in ast.walk(node) if isinstance(n, ast.Name)]
    return [""]


def imports_of(path):
    """@return module file -> names that are taken from it, None: all of them"""
    found = {}
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            file = path.parent / f"{node.module}.py"
            if file.exists() and found.get(file, ()) is not None:
                found.setdefault(file, set()).update(alias.name for alias in node.names)
        elif isinstance(node, ast.Import):
            for alias in node.names:
                file = path.parent / f"{alias.name}.py"
                if file.exists():
                    found[file] = None
    return found


def used_by(path):
    """@return modules and texts that the tests of a file may use"""
    files, texts, seen = set(), set(), set()
    waiting = [(path, None)]
    while waiting:
        file, wanted = waiting.pop()
        files.add(file)
        parts = parse_module(file)
        # What stands at the top of a module happens whoever imports it.
        names = set(parts) if wanted is None else {"", *wanted} & set(parts)
        for name in names:
            if (file, name) in seen:
                continue
            seen.add((file, name))
            texts |= parts[name][1]
            waiting.append((file, parts[name][0]))
        for module, taken in imports_of(file).items():
            if taken is None:
                if (module, None) not in seen:
                    seen.add((module, None))
                    waiting.append((module, None))
            else:
                words = set().union(*(parts[name][0] for name in names), set())
                waiting += [
                    (module, {name}) for name in taken & words if (module, name) not in seen
                ]
    return files, texts


def is_touched(test, changed, graph):
    """@return the first reason why a change may alter what an entry finds, or none"""
    for word in test.words:
        path = pathlib.Path(word)
        if path.is_relative_to(graph.build):
            touched = graph.sources(str(path.relative_to(graph.build))) & changed
        elif path.is_relative_to(graph.root / "tests") and path.name != "run_unittest.py":
            touched = touched_sources(test, path, changed, graph)
        else:
            continue
        if touched:
            return min(touched)
    return None


def touched_sources(test, path, changed, graph):
    if path.suffix != ".py":
        return touched_folders(path, changed, graph.root)
    files, texts = used_by(path)
    touched = {str(file.relative_to(graph.root)) for file in files} & changed
    for name, value in test.environment.items():
        # binary("RAYTRACER") is the program that TERRAVOX_RAYTRACER names.
        if {name, name.removeprefix("TERRAVOX_")} & texts:
            program = pathlib.Path(value)
            if program.is_relative_to(graph.build) and program.is_file():
                touched |= graph.sources(str(program.relative_to(graph.build))) & changed
    # What is no source of a program is named by the test, or the folder that it is in.
    for name in changed:
        path = pathlib.PurePath(name)
        named = path.parts[1:] or path.parts
        if path.suffix in (".cpp", ".hpp", ".ts"):
            named = path.parts[:1] if path.parts[0] == "grabber" else ()
        if texts & set(named):
            touched.add(name)
    return touched


def touched_folders(script, changed, root):
    """Of a script that starts Node.js: its own folder, and those that it names."""
    folders = [script.parent]
    for found in re.findall(r"'(\.\./[\w./-]+)'", script.read_text(encoding="utf-8")):
        folders.append((script.parent / found).resolve())
    return {name for name in changed if any((root / name).is_relative_to(f) for f in folders)}


def list_changed(base):
    """@return paths that differ from a commit, or are new"""

    def git(*words):
        return subprocess.run(
            ["git", "-C", ROOT, *words], capture_output=True, text=True, check=False
        )

    if base is None:
        upstream = git("merge-base", "HEAD", "@{upstream}")
        base = upstream.stdout.strip() if upstream.returncode == 0 else "HEAD"
    differing = git("diff", "--name-only", base, "--")
    if differing.returncode != 0:
        sys.exit(
            f"test --changed: '{base}' is no commit of this checkout ({differing.stderr.strip()})"
        )
    fresh = git("ls-files", "--others", "--exclude-standard")
    return set(differing.stdout.split("\n") + fresh.stdout.split("\n")) - {""}


def choose(tests, tier, build, base=None):
    if tier == "all":
        return [test.name for test in tests]
    chosen = [test.name for test in tests if test.is_default]
    if tier == "changed":
        changed, graph = list_changed(base), Graph(build)
        for test in tests:
            if not test.is_default and (reason := is_touched(test, changed, graph)):
                print(f"{test.name}: {reason} differs", file=sys.stderr)
                chosen.append(test.name)
    return chosen


# What a run took.


def report(times, budget=None):
    """@return lines: the dearest entries, and those above their budget"""
    _, entries = read_budget() if budget is None else budget
    taken = {}
    for line in times.splitlines():
        name, seconds = line.split("\t")
        taken[name] = taken.get(name, 0) + float(seconds)
    lines = [f"Processor time of {len(taken)} entries: {sum(taken.values()):.0f} s. The dearest:"]
    for name in sorted(taken, key=taken.get, reverse=True)[:SHOWN]:
        allowed = f" of {entries[name][1]}" if name in entries else ""
        lines.append(f"  {taken[name]:7.1f}{allowed} s  {name}")
    above = [name for name in taken if name in entries and taken[name] > entries[name][1]]
    if above:
        lines.append("Above their budget (tests/budget):")
        for name in sorted(above):
            lines.append(f"  {taken[name]:7.1f} of {entries[name][1]} s  {name}")
    return lines


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    commands = parser.add_subparsers(dest="command", required=True)
    names = commands.add_parser("names")
    names.add_argument("tier", choices=("default", "all", "changed"))
    names.add_argument("--base")
    names.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release")
    commands.add_parser("report").add_argument("file", type=pathlib.Path)
    args = parser.parse_args()
    if args.command == "names":
        tests = list_tests(args.build)
        print("\n".join(choose(tests, args.tier, args.build, args.base)))
    elif args.file.exists():
        print("\n".join(report(args.file.read_text(encoding="utf-8"))))


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Which folder includes which, and what its namespace is: config/layers.toml says what is allowed.

Each include that is not allowed is named, each namespace that no folder of its file has, and each
library that links more or less than its sources include.

Each wing (a door of the house) has a budget of lines in the same file, and docs/architecture.md a
plan of wings, folders and lines, which is made here.

python3 tests/layers_test.py           # checks; exit code 1 and one line for each offence
python3 tests/layers_test.py --lines   # prints the lines of each folder and wing
python3 tests/layers_test.py --plan    # writes the plan in docs/architecture.md
"""

import argparse
import collections
import os
import pathlib
import re
import sys
import tempfile
import tomllib
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[1]
LAYERS = pathlib.Path("config", "layers.toml")
DOCUMENT = pathlib.Path("docs", "architecture.md")
PLAN = re.compile(r"(<!-- plan \(tests/layers_test.py --plan\) -->\n).*?(<!-- /plan -->)", re.S)
COUNTED = (".cpp", ".hpp", ".ts", ".css", ".glsl", ".html", ".js", ".mjs", ".py", ".sh")
NOT_COUNTED = {"node_modules", "dist", "dist-test", "__pycache__"}
OFF = 0.03  # of its lines a wing may grow or shrink before its plan is stale
# The one table of analyses, and where each has a source.
ANALYSES = ("common/voxel/analysis.hpp", "raytracer/analyse/evaluators/")
ANALYSIS = re.compile(r'\{AnalysisKind::(\w+),\s*"([a-z-]+)",\s*"[^"]')
TOP_FOLDERS = ("common", "voxelserver", "raytracer")  # each includes itself and those before it
LIBRARY = re.compile(r"\bterravox_library\(\s*(\w+)([^()]*)\)")
ADDED = re.compile(r"\badd_library\(terravox_(\w+) (?:STATIC|INTERFACE|SHARED|MODULE)([^()]*)\)")
INCLUDE = re.compile(r'^\s*#\s*include\s+(?:"([^"]+)"|<([^>]+)>)', re.MULTILINE)
NAMESPACE = re.compile(r"^(?:inline )?namespace (terravox[\w:]*) \{$(?P<body>.*?)^\}", re.M | re.S)
DECLARATIONS = re.compile(r"(\s*(class|struct|enum class) [^;{]*;)+\s*")
# Headers that open a connection to another machine, or name one.
NETWORK = re.compile(r"(sys/socket|netinet/|arpa/|netdb|curl/|grpc|openssl/ssl|civetweb)")


class Code:
    """The sources of the three top folders: what each file includes of the others."""

    def __init__(self, root):
        self.root = root
        self.files = {}
        self.system = {}
        self.namespaces = {}
        for top in TOP_FOLDERS:
            for file in sorted((root / top).rglob("*")):
                if file.suffix in (".hpp", ".cpp") and "node_modules" not in file.parts:
                    self._take(file)

    def _take(self, file):
        name = file.relative_to(self.root).as_posix()
        text = file.read_text(encoding="utf-8")
        found = INCLUDE.findall(text)
        self.files[name] = [own for own, _ in found if own.split("/")[0] in TOP_FOLDERS]
        self.system[name] = [system for _, system in found if system]
        # What is only declared stays where it is at home.
        self.namespaces[name] = [
            block[1]
            for block in NAMESPACE.finditer(text)
            if not DECLARATIONS.fullmatch(block["body"])
        ]

    def folders(self):
        return sorted({folder_of(name) for name in self.files})


def folder_of(file):
    return file.rpartition("/")[0]


class Libraries:
    """The libraries that the lists of the wings define, and what each folder links.

    A library is of the folder in which its sources lie, one without sources of the folder with its
    name. The libraries of one folder are taken together; programs, and libraries that are not made
    by terravox_library(), are not looked at.
    """

    def __init__(self, root):
        self.folder_of_library = {}
        self.sources = {}  # of a library, in the order of its list
        self.linked = {}  # of a folder: {"PUBLIC": names, "PRIVATE": names}
        for top in TOP_FOLDERS:
            for file in sorted((root / top).rglob("CMakeLists.txt")):
                if "node_modules" not in file.parts:
                    text = re.sub("#.*", "", file.read_text(encoding="utf-8"))
                    self._take(file.parent.relative_to(root).as_posix(), text)

    def _take(self, folder, text):
        for target, sources in ADDED.findall(text):
            source = (sources.split() or [""])[-1]
            self.folder_of_library[target] = folder_of(f"{folder}/{source}")
        for name, arguments in LIBRARY.findall(text):
            words = {"PUBLIC": [], "PRIVATE": [], "SOURCES": []}
            keyword = None
            for word in arguments.split():
                if word in words:
                    keyword = word
                elif keyword:
                    words[keyword].append(word)
            own = (
                folder_of(f"{folder}/{words['SOURCES'][0]}")
                if words["SOURCES"]
                else (f"{folder}/{name}")
            )
            self.folder_of_library[name] = own
            self.sources[name] = words["SOURCES"]
            linked = self.linked.setdefault(own, {"PUBLIC": set(), "PRIVATE": set()})
            for keyword, found in linked.items():
                found |= {
                    w.removeprefix("terravox::")
                    for w in words[keyword]
                    if w.startswith("terravox::")
                }

    def folders(self, folder, keyword):
        names = self.linked[folder][keyword]
        return {self.folder_of_library.get(name, f"terravox::{name}") for name in names} - {folder}


def wrong_includes(code, layers):
    """One line for each include that is not allowed, and for each folder without a row."""
    wrong = [
        f"{folder}: {LAYERS} does not name it" for folder in code.folders() if folder not in layers
    ]
    for file, included in code.files.items():
        own = folder_of(file)
        allowed = layers.get(own, [])
        names = ", ".join(allowed) or "nothing"
        for name in included:
            if folder_of(name) not in (own, *allowed):
                wrong.append(f"{file}: includes {name}; {own} may include: {names}")
    return wrong


def wrong_rows(code, layers):
    """What is wrong with the table: what nothing needs, arrows upwards, cycles."""
    needed = collections.defaultdict(set)
    for file, included in code.files.items():
        needed[folder_of(file)] |= {folder_of(name) for name in included} - {folder_of(file)}
    wrong = [
        f"{LAYERS}: {folder} is no folder with sources"
        for folder in layers
        if folder not in code.folders()
    ]
    for folder, allowed in layers.items():
        for other in allowed:
            if other not in needed[folder]:
                wrong.append(f"{LAYERS}: {folder} includes nothing of {other}")
            if TOP_FOLDERS.index(other.split("/")[0]) > TOP_FOLDERS.index(folder.split("/")[0]):
                wrong.append(f"{LAYERS}: {folder} is below {other} and may not include it")
    return wrong + [
        f"{LAYERS}: a cycle of folders: {' -> '.join(cycle)}" for cycle in cycles(layers)
    ]


def cycles(graph):
    """The first cycle on each way through a graph; a list that ends as it begins."""
    found, done = [], set()

    def walk(node, path):
        if node in path:
            found.append([*path[path.index(node) :], node])
            return
        if node in done:
            return
        for other in graph.get(node, []):
            walk(other, [*path, node])
        done.add(node)

    for node in graph:
        walk(node, [])
    return found


def cycles_of_files(code):
    return [f"a cycle of includes: {' -> '.join(cycle)}" for cycle in cycles(code.files)]


def network_in_common(code):
    return [
        f"{file}: includes <{name}>; common/ knows no network"
        for file, names in code.system.items()
        if file.startswith("common/")
        for name in names
        if NETWORK.match(name)
    ]


def not_alone(code, table):
    """One line for each system header that another source than its own includes, or none does.

    @param table {header: source}
    """
    wrong = [
        f"{file}: includes <{name}>; {table[name]} alone may"
        for file, names in code.system.items()
        for name in names
        if table.get(name, file) != file
    ]
    return wrong + [
        f"{LAYERS}: {file} does not include <{name}>"
        for name, file in table.items()
        if name not in code.system.get(file, [])
    ]


def wrong_namespaces(code, more):
    """One line for each namespace that is not named like a folder on the way to its file.

    @param more {folder: names} of namespaces with other names
    """
    wrong = []
    for file, namespaces in code.namespaces.items():
        folder = folder_of(file)
        allowed = [*folder.split("/")[1:], *more.get(folder, [])]
        for namespace in namespaces:
            first = namespace.removeprefix("terravox").removeprefix("::").split("::")[0]
            if first not in allowed:
                names = " or ".join(f"terravox::{name}" for name in allowed)
                wrong.append(f"{file}: namespace {namespace}; {folder} may have: {names}")
    return wrong


def wings_that_are_not_alone(code, wings):
    """One line for each include of another wing of the same top folder by a wing that is alone.

    @param wings {wing: its row}
    """

    def find_wing(file):
        return max((wing for wing in wings if file.startswith(wing + "/")), key=len, default="")

    return [
        f"{file}: includes {name} of the wing {find_wing(name)}; {wing} is alone in {LAYERS}"
        for file, names in code.files.items()
        for wing in [find_wing(file)]
        if wings.get(wing, {}).get("alone")
        for name in names
        if name.split("/")[0] == wing.split("/")[0] and find_wing(name) not in ("", wing)
    ]


def lists_of_analyses(root):
    """Files that name three analyses of the table close to each other, as a list of them does."""
    table = root / ANALYSES[0]
    rows = ANALYSIS.findall(table.read_text(encoding="utf-8")) if table.exists() else []
    kinds = {spelled: name for row in rows for spelled, name in (row, (row[1], row[1]))}
    words = "|".join(kinds)
    named = re.compile(rf"""["'`]({words})["'`]|::({words})\b|^\s*({words}):""", re.MULTILINE)
    wrong = []
    for file in sorted(file for top in TOP_FOLDERS for file in (root / top).rglob("*")):
        name = file.relative_to(root).as_posix()
        if not name.endswith(COUNTED) or NOT_COUNTED & set(file.parts) or not rows:
            continue
        found = list(named.finditer(file.read_text(encoding="utf-8")))
        for first in found if not name.startswith(ANALYSES) else ():
            near = {kinds[m[m.lastindex]] for m in found if 0 <= m.end() - first.start() < 200}
            if len(near) > 2:
                wrong.append(f"{name}: lists {', '.join(sorted(near))}; {ANALYSES[0]} alone may")
                break
    return wrong


def problems(root):
    code = Code(root)
    layers = tomllib.loads((root / LAYERS).read_text(encoding="utf-8"))
    namespaces = layers.pop("namespaces", {})
    alone = layers.pop("alone", {})
    wings = layers.pop("wings", {})
    libraries = Libraries(root)
    return [
        *wrong_includes(code, layers),
        *wrong_rows(code, layers),
        *cycles_of_files(code),
        *network_in_common(code),
        *not_alone(code, alone),
        *wings_that_are_not_alone(code, wings),
        *wrong_namespaces(code, namespaces),
        *wrong_links(code, libraries),
        *unsorted_sources(libraries),
        *includes_of_tests(root),
        *lists_of_analyses(root),
        *problems_of_wings(root),
    ]


def wrong_links(code, libraries):
    """One line for each folder that a library includes but does not link, links but does not
    include, or links as PRIVATE (PUBLIC) though a header (only a source) includes it."""
    included = {folder: (set(), set()) for folder in libraries.linked}  # by headers, by sources
    for file, names in code.files.items():
        own = folder_of(file)
        if own in included:
            by_header, by_source = included[own]
            (by_header if file.endswith(".hpp") else by_source).update(
                folder_of(name) for name in names if folder_of(name) != own
            )
    wrong = []
    for folder, (by_header, by_source) in included.items():
        public, private = (libraries.folders(folder, k) for k in ("PUBLIC", "PRIVATE"))
        own = f"the libraries of {folder}:"
        wanted = by_header | by_source
        wrong += [f"{own} does not link {f}" for f in sorted(wanted - public - private)]
        wrong += [f"{own} links {f}, which is not included" for f in sorted(public - wanted)]
        wrong += [f"{own} links {f}, which is not included" for f in sorted(private - wanted)]
        wrong += [f"{own} {f} is PUBLIC: a header includes it" for f in sorted(private & by_header)]
        wrong += [
            f"{own} {f} is PRIVATE: no header includes it"
            for f in sorted(public & (wanted - by_header))
        ]
    return wrong


def unsorted_sources(libraries):
    """One line for each library whose list of sources is not sorted."""
    return [
        f"{libraries.folder_of_library[name]}: the sources of {name} are not sorted"
        for name, sources in libraries.sources.items()
        if sources != sorted(sources)
    ]


def includes_of_tests(root):
    """What tests of a top folder may not include: those that build on it."""
    wrong = []
    for i, top in enumerate(TOP_FOLDERS):
        for file in sorted((root / "tests" / top).rglob("*.[ch]pp")):
            for own, _ in INCLUDE.findall(file.read_text(encoding="utf-8")):
                parts = own.removeprefix("tests/").split("/")
                if parts[0] in TOP_FOLDERS[i + 1 :]:
                    name = file.relative_to(root).as_posix()
                    wrong.append(f"{name}: includes {own}; tests of {top} may not")
    return wrong


class Wings:
    """The doors of the house: the lines of each, without those of wings inside of it."""

    def __init__(self, root, table):
        self.table = table
        self.lines = collections.Counter()
        self.folders = collections.defaultdict(set)
        self.all_lines = collections.Counter()  # by folder
        for top in sorted({name.split("/")[0] for name in table}):
            for path, folders, files in os.walk(root / top):
                folders[:] = sorted(set(folders) - NOT_COUNTED)
                for file in files:
                    if file.endswith(COUNTED):
                        self._take(pathlib.Path(path, file), root)

    def _take(self, file, root):
        name = file.relative_to(root).as_posix()
        own = [wing for wing in self.table if name.startswith(wing + "/")]
        if own:
            wing = max(own, key=len)
            count = len(file.read_text(encoding="utf-8").splitlines())
            self.lines[wing] += count
            self.all_lines[folder_of(name)] += count
            rest = folder_of(name).removeprefix(wing).strip("/")
            self.folders[wing].add(rest.split("/")[0])

    def over_budget(self):
        """One line for each wing that has more lines than its budget."""
        return [
            f"{wing}: {self.lines[wing]} lines, and its budget in {LAYERS} is {row['at_most']}; "
            "take something away, or raise it there and say why"
            for wing, row in self.table.items()
            if self.lines[wing] > row["at_most"]
        ]

    def plan(self):
        rows = [
            "",
            "| wing | lines | at most | what is in it | folders |",
            "|---|---:|---:|---|---|",
        ]
        for wing, row in self.table.items():
            lines = f"{round(self.lines[wing], -2):,}"
            folders = (
                ", ".join(sorted(self.folders[wing] - {""})) if row.get("folders", True) else ""
            )
            rows.append(f"| {wing} | {lines} | {row['at_most']:,} | {row['holds']} | {folders} |")
        return "\n".join([*rows, "", ""])

    def wrong_plan(self, document):
        """What is stale in a document with a plan."""
        found = PLAN.search(document)
        if not found:
            return [f"{DOCUMENT}: it has no plan of the wings"]
        written = {}
        for line in found[0].splitlines():
            cells = [cell.strip() for cell in line.strip("|").split("|")]
            if len(cells) == 5:
                written[cells[0]] = cells[1:]
        wrong = []
        for line in self.plan().splitlines()[3:]:
            if line:
                wing, lines, *rest = (cell.strip() for cell in line.strip("|").split("|"))
                then, *old = written.get(wing, ["0"])
                now, then = (int(number.replace(",", "") or 0) for number in (lines, then))
                if old != rest or abs(now - then) > max(OFF * now, 100):
                    wrong.append(f"{DOCUMENT}: the row of {wing} is stale")
        return wrong + [
            f"{DOCUMENT}: {wing} is no wing"
            for wing in written.keys() - self.table.keys() - {"wing", "---"}
        ]


def problems_of_wings(root):
    table = tomllib.loads((root / LAYERS).read_text(encoding="utf-8")).get("wings", {})
    wings = Wings(root, table)
    wrong = wings.over_budget()
    document = root / DOCUMENT
    if table and document.exists():
        stale = wings.wrong_plan(document.read_text(encoding="utf-8"))
        wrong += stale
        if stale:
            wrong.append("to write it anew: python3 tests/layers_test.py --plan")
    return wrong


def print_lines(root):
    wings = Wings(root, tomllib.loads((root / LAYERS).read_text(encoding="utf-8"))["wings"])
    for wing, row in wings.table.items():
        print(f"{wing:42} {wings.lines[wing]:7} of {row['at_most']:7}")
        for folder, lines in sorted(wings.all_lines.items()):
            if max((w for w in wings.table if f"{folder}/".startswith(w + "/")), key=len) == wing:
                print(f"  {folder:40} {lines:7}")


def write_plan(root):
    wings = Wings(root, tomllib.loads((root / LAYERS).read_text(encoding="utf-8"))["wings"])
    document = root / DOCUMENT
    text = document.read_text(encoding="utf-8")
    document.write_text(PLAN.sub(lambda m: m[1] + wings.plan() + m[2], text), encoding="utf-8")


class Layers(unittest.TestCase):
    def test_every_include_is_allowed(self):
        self.assertEqual(problems(ROOT), [])


class TheCheckItself(unittest.TestCase):
    """Each rule, on a small tree that breaks it."""

    def tree(self, files, layers):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        root = pathlib.Path(folder.name)
        for name, text in {LAYERS.as_posix(): layers, **files}.items():
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            (root / name).write_text(text, encoding="utf-8")
        return problems(root)

    def test_offences_are_named(self):
        a, b, c = "common/a/a.hpp", "voxelserver/b/b.hpp", "common/c/c.hpp"
        own = '"common/a" = []\n'
        good = own + '"voxelserver/b" = ["common/a"]\n'
        list_a, list_b = "common/CMakeLists.txt", "voxelserver/CMakeLists.txt"
        of_a = f'#include "{a}"\n'
        elsewhere = "namespace terravox::c {\nint x;\n}\n"
        libraries = {list_a: "terravox_library(a)\n"}
        analyses = {
            ANALYSES[0]: "".join(
                f'{{AnalysisKind::k{kind}, "{kind.lower()}", "{said}"}},\n'
                for kind, said in (("Fog", "How"), ("Rain", "How"), ("Snow", "How"), ("Hail", ""))
            )
        }
        wing = '[wings]\n"common/a" = {{ at_most = {}, holds = "base" }}\n'
        alone = '"common/c" = { at_most = 1, holds = "c", alone = true }\n'
        plan = (
            "<!-- plan (tests/layers_test.py --plan) -->\n| common/a | 0 | 1 | base |  |\n"
            "<!-- /plan -->\n"
        )
        for said, files, layers in (
            ("", {a: "", b: of_a}, good),
            (f"{b}: includes {a}", {a: "", b: of_a}, own + '"voxelserver/b" = []\n'),
            ("voxelserver/b: config/layers.toml does not name it", {a: "", b: ""}, own),
            ("voxelserver/b is no folder", {a: ""}, good),
            ("includes nothing of common/a", {a: "", b: ""}, good),
            (
                "may not include it",
                {a: f'#include "{b}"\n', b: ""},
                '"common/a" = ["voxelserver/b"]\n"voxelserver/b" = []\n',
            ),
            (f"{a}: namespace terravox::c; common/a may have: terravox::a", {a: elsewhere}, own),
            (f"{a}: namespace terravox; ", {a: "namespace terravox {\nint x;\n}\n"}, own),
            ("", {a: elsewhere}, own + '[namespaces]\n"common/a" = ["c"]\n'),
            ("", {a: "namespace terravox::c {\nclass X;\nstruct Y;\n}\n"}, own),
            (
                "common/a -> common/c -> common/a",
                {a: f'#include "{c}"\n', c: "", "common/c/d.hpp": of_a},
                '"common/a" = ["common/c"]\n"common/c" = ["common/a"]\n',
            ),
            (
                "a cycle of includes",
                {a: '#include "common/a/e.hpp"\n', "common/a/e.hpp": of_a},
                own,
            ),
            (
                "voxelserver/b: does not link common/a",
                {a: "", b: of_a, **libraries, list_b: "terravox_library(b)  # terravox::a\n"},
                good,
            ),
            (
                "common/a: links terravox::b, which is not included",
                {a: "", list_a: "terravox_library(a PUBLIC terravox::b)\n"},
                own,
            ),
            (
                "voxelserver/b: common/a is PUBLIC: a header includes it",
                {a: "", b: of_a, **libraries, list_b: "terravox_library(b PRIVATE terravox::a)\n"},
                good,
            ),
            (
                "voxelserver/b: common/a is PRIVATE: no header includes it",
                {
                    a: "",
                    b: "",
                    "voxelserver/b/b.cpp": of_a,
                    **libraries,
                    list_b: "terravox_library(b PUBLIC terravox::a)\n",
                },
                good,
            ),
            (
                "common/a: the sources of a are not sorted",
                {a: "", list_a: "terravox_library(a SOURCES a/b.cpp a/a.cpp)\n"},
                own,
            ),
            (
                f"tests/common/a/a_test.cpp: includes {b}; tests of common may not",
                {a: "", b: of_a, "tests/common/a/a_test.cpp": f'#include "{b}"\n'},
                good,
            ),
            ("knows no network", {a: "#include <sys/socket.h>\n"}, own),
            ("", {a: "#include <x.h>\n"}, own + f'[alone]\n"x.h" = "{a}"\n'),
            (
                f"common/a/b.hpp: includes <x.h>; {a} alone may",
                {a: "#include <x.h>\n", "common/a/b.hpp": "#include <x.h>\n"},
                own + f'[alone]\n"x.h" = "{a}"\n',
            ),
            (f"{a} does not include <x.h>", {a: ""}, own + f'[alone]\n"x.h" = "{a}"\n'),
            (
                f"{c}: includes {a} of the wing common/a; common/c is alone",
                {a: "", c: of_a},
                own + '"common/c" = ["common/a"]\n' + wing.format(1) + alone,
            ),
            (
                "",
                {a: "", b: of_a},
                good + wing.format(1) + alone.replace("common/c", "voxelserver/b"),
            ),
            (
                f"{a}: lists fog, rain, snow; {ANALYSES[0]} alone may",
                {a: "f({'fog', AnalysisKind::kRain,\n  snow: 1});\n", **analyses},
                own + '"common/voxel" = []\n',
            ),
            (
                "",
                {a: "f({'fog', 'rain', 'hail'});\n", **analyses},
                own + '"common/voxel" = []\n',
            ),
            ("", {a: "\n"}, own + wing.format(1)),
            ("common/a: 2 lines, and its budget", {a: "\n\n"}, own + wing.format(1)),
            ("has no plan", {a: "", DOCUMENT.as_posix(): ""}, own + wing.format(1)),
            (
                "the row of common/a is stale",
                {a: "", DOCUMENT.as_posix(): plan},
                own + wing.format(2),
            ),
            ("", {a: "", DOCUMENT.as_posix(): plan}, own + wing.format(1)),
        ):
            with self.subTest(said):
                found = "\n".join(self.tree(files, layers))
                self.assertTrue(said in found if said else not found, found)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--lines", action="store_true")
    parser.add_argument("--plan", action="store_true")
    wanted, rest = parser.parse_known_args()
    if wanted.lines:
        print_lines(ROOT)
    elif wanted.plan:
        write_plan(ROOT)
    else:
        unittest.main(argv=[sys.argv[0], *rest])

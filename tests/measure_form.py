#!/usr/bin/env python3
"""Measures the form of the production code: how dense its lines are, and how long.

    tests/measure_form.py                                   both languages
    tests/measure_form.py --language C++ --worst 20         also the densest functions
    tests/measure_form.py --limit-tokens 14 --limit-branches 4.2 --limit-long-percent 12

Prints a row for each language:

  tokens/line         tokens of all functions divided by their lines
  branches/10 lines   cyclomatic complexity of all functions divided by tens of their lines
  over 100            share of all lines with more than 100 columns, in percent

Lines of functions are counted without blank lines and comments, and only functions of 5 lines and
more are counted. A function that is called x_of (xOf) is named: its name has no verb. The exit code
is 1 when there is one or a row is above a limit, and 2 when lizard is missing.
"""

import argparse
import dataclasses
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
LINTERS = ROOT / "build" / "deps" / "lint"
COLUMNS = 100
MIN_FUNCTION_LINES = 5
# Folders and file name extensions of each language.
SOURCES = {
    "C++": (("common", "voxelserver", "raytracer"), (".cpp", ".hpp")),
    "TypeScript": (("grabber/src", "voxelserver/serve/page/src"), (".ts",)),
}
NOT_OURS = {"node_modules", "dist"}
WITHOUT_A_VERB = re.compile(r"(?:_of|[a-z]Of)$")
PUBLISHED = {"block_of"}  # by the library's headers (raytracer/apps/library/terravox)


def import_lizard():
    """@return the module lizard: the pinned one where it is installed (config/setup/lint.sh)"""
    sys.path.insert(0, str(LINTERS))
    try:
        import lizard
    except ImportError:
        print(
            "measure_form.py: lizard is missing; ./terravox test installs it, as does\n"
            f"  pip install --require-hashes --target {LINTERS.relative_to(ROOT)}"
            " -r config/setup/python/lint.txt",
            file=sys.stderr,
        )
        sys.exit(2)
    return lizard


@dataclasses.dataclass
class Function:
    place: str
    lines: int
    tokens: int
    complexity: int

    @property
    def tokens_per_line(self):
        return self.tokens / self.lines


@dataclasses.dataclass
class Form:
    """The figures of one language."""

    files: int = 0
    lines: int = 0
    long_lines: int = 0
    functions: list[Function] = dataclasses.field(default_factory=list)
    misnamed: list[str] = dataclasses.field(default_factory=list)  # their places

    @property
    def function_lines(self):
        return sum(function.lines for function in self.functions)

    @property
    def tokens_per_line(self):
        tokens = sum(function.tokens for function in self.functions)
        return tokens / max(self.function_lines, 1)

    @property
    def branches_per_10_lines(self):
        complexity = sum(function.complexity for function in self.functions)
        return 10 * complexity / max(self.function_lines, 1)

    @property
    def long_percent(self):
        return 100 * self.long_lines / max(self.lines, 1)


def files_of(root, folders, extensions):
    return sorted(
        path
        for folder in folders
        for path in (root / folder).rglob("*")
        if path.suffix in extensions and NOT_OURS.isdisjoint(path.relative_to(root).parts)
    )


def measure(root, folders, extensions):
    """@return the Form of all files with these extensions in these folders below root"""
    lizard = import_lizard()
    form = Form()
    for path in files_of(root, folders, extensions):
        text = path.read_text(encoding="utf-8")
        name = str(path.relative_to(root))
        lines = text.splitlines()
        form.files += 1
        form.lines += len(lines)
        form.long_lines += sum(len(line) > COLUMNS for line in lines)
        for found in lizard.analyze_file.analyze_source_code(name, text).function_list:
            own_name = found.name.split("::")[-1]
            if WITHOUT_A_VERB.search(own_name) and own_name not in PUBLISHED:
                form.misnamed.append(f"{name}:{found.start_line} {own_name}")
            if found.nloc >= MIN_FUNCTION_LINES:
                form.functions.append(
                    Function(
                        place=f"{name}:{found.start_line} {found.name}",
                        lines=found.nloc,
                        tokens=found.token_count,
                        complexity=found.cyclomatic_complexity,
                    )
                )
    return form


def print_rows(forms):
    print(
        f"{'language':12} {'files':>6} {'lines':>7} {'functions':>9} {'tokens/line':>12}"
        f" {'branches/10 lines':>18} {'over 100':>9}"
    )
    for language, form in forms.items():
        print(
            f"{language:12} {form.files:6} {form.lines:7} {len(form.functions):9}"
            f" {form.tokens_per_line:12.1f} {form.branches_per_10_lines:18.1f}"
            f" {form.long_percent:7.1f} %"
        )


def print_densest(form, count):
    densest = sorted(form.functions, key=lambda function: function.tokens_per_line, reverse=True)
    for function in densest[:count]:
        print(f"  {function.tokens_per_line:5.1f} tokens/line  {function.place}")


def excesses(forms, limits):
    """@return a line for each figure above its limit

    @param limits {name of a property of Form: limit, or None for no limit}
    """
    return [
        f"{language}: {name} is {getattr(form, name):.2f}; allowed: {limit:g} or less"
        for language, form in forms.items()
        for name, limit in limits.items()
        if limit is not None and getattr(form, name) > limit
    ]


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--language", choices=SOURCES, help="this language alone")
    parser.add_argument("--worst", type=int, default=0, help="densest functions to list (0)")
    parser.add_argument("--limit-tokens", type=float, help="most tokens per line")
    parser.add_argument("--limit-branches", type=float, help="most branches per 10 lines")
    parser.add_argument("--limit-long-percent", type=float, help="most lines over 100 columns")
    args = parser.parse_args()
    languages = [args.language] if args.language else list(SOURCES)
    forms = {language: measure(ROOT, *SOURCES[language]) for language in languages}
    print_rows(forms)
    for form in forms.values():
        print_densest(form, args.worst)
    limits = {
        "tokens_per_line": args.limit_tokens,
        "branches_per_10_lines": args.limit_branches,
        "long_percent": args.limit_long_percent,
    }
    found = excesses(forms, limits)
    for form in forms.values():
        found += [
            f"{place}: name what it does: to_x and parse_x convert, find_x searches"
            for place in form.misnamed
        ]
    for line in found:
        print(f"measure_form.py: {line}", file=sys.stderr)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

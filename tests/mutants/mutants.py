"""The seeded faults of this folder: NAME.patch, a unified diff of one hunk below two lines, what
the fault is and the CTest entries that are nearest to it, most specific first.
"""

import dataclasses
import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDER = ROOT / "tests" / "mutants"
# The first folder that a file lies in names its wing.
WINGS = {
    "voxelserver/serve/page/": "page",
    "common/": "common",
    "config/": "config",
    "grabber/": "grabber",
    "raytracer/": "raytracer",
    "voxelserver/": "voxelserver",
}
ENTRIES = "Entries: "


@dataclasses.dataclass(frozen=True)
class Nearest:
    """A CTest entry; part: of its files, those that have this in their path."""

    entry: str
    part: str = ""

    def __str__(self):
        return self.entry + (f":{self.part}" if self.part else "")


@dataclasses.dataclass(frozen=True)
class Mutant:
    name: str
    fault: str
    nearest: tuple[Nearest, ...]
    file: str  # that is changed, from the root
    patch: pathlib.Path

    @property
    def wing(self):
        return next(wing for folder, wing in WINGS.items() if self.file.startswith(folder))


def read_mutant(patch):
    """@throws ValueError where the file has another form"""
    text = patch.read_text(encoding="utf-8")
    head, _, diff = text.partition("\ndiff --git ")
    lines = head.rstrip("\n").split("\n")
    files = re.findall(r"^\+\+\+ b/(.+)$", diff, re.MULTILINE)
    hunks = re.findall(r"^@@ ", diff, re.MULTILINE)
    if len(lines) != 2 or not lines[0] or not lines[1].startswith(ENTRIES):
        raise ValueError(f"{patch.name}: its head is no fault and '{ENTRIES}NAME...'")
    if len(files) != 1 or len(hunks) != 1:
        raise ValueError(f"{patch.name}: {len(files)} files, {len(hunks)} hunks; allowed: 1 and 1")
    if not any(files[0].startswith(folder) for folder in WINGS):
        raise ValueError(f"{patch.name}: {files[0]} is in none of {', '.join(WINGS)}")
    nearest = tuple(Nearest(*word.split(":", 1)) for word in lines[1].removeprefix(ENTRIES).split())
    if not nearest:
        raise ValueError(f"{patch.name}: no entries")
    return Mutant(patch.stem, lines[0], nearest, files[0], patch)


def all_mutants():
    return [read_mutant(patch) for patch in sorted(FOLDER.glob("*.patch"))]

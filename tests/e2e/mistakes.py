#!/usr/bin/env python3
"""Runs the mistakes of mistakes.txt, and prints those whose message lacks the remedy.

For a person, after a change of messages: all of them, with the programs of build/release. Those
with a star are tests (bad_input_test.py).
"""

import dataclasses
import os
import pathlib
import shlex
import sys
import zipfile

if __name__ == "__main__":
    PROGRAMS = pathlib.Path(__file__).resolve().parents[2] / "build" / "release" / "bin"
    for program in PROGRAMS.glob("terravox-*"):
        variable = "TERRAVOX_" + program.name.removeprefix("terravox-").upper()
        os.environ.setdefault(variable, str(program))

from support import ROOT, Run, binary, square, temporary_folder

TABLE = ROOT / "tests" / "e2e" / "mistakes.txt"
COMMANDS = ROOT / "config" / "setup" / "commands.txt"


@dataclasses.dataclass(frozen=True)
class Mistake:
    line: str  # the command line behind ./terravox
    code: int
    said: tuple
    is_test: bool


def read_mistakes():
    out = []
    for row in TABLE.read_text(encoding="utf-8").splitlines():
        if "=>" not in row or row.startswith("#"):
            continue
        line, said = row.split(" => ")
        is_test = line.startswith("* ")
        line = line.removeprefix("* ")
        code = 2
        if line.startswith("["):
            code, line = int(line[1]), line[4:]
        out.append(Mistake(line, code, tuple(said.split(" && ")), is_test))
    return out


def wrong_files():
    """@return a folder of files that are no worlds, or not as their names say"""
    folder = temporary_folder()
    for inner in ("empty", "images", "nested/deep/er", "squares"):
        (folder / inner).mkdir(parents=True)
    jpeg = b"\xff\xd8\xff\xe0" + bytes(100)
    for name, data in {
        "photo.png": b"\x89PNG\r\n\x1a\n" + bytes(100),
        "photo.jpg": jpeg,
        "images/photo.jpg": jpeg,
        "nested/deep/er/a.laz": b"LASF",
        "squares/a.laz": b"LASF",
        "a.e57": b"ASTM-E57" + bytes(100),
        "a.xyz": b"462000.5 101000.5 300.1\n462003.1 101001.7 300.2\n",
        "page": b"<!DOCTYPE html><title>Sign in</title>",
        "empty.laz": b"",
        "text.laz": b"no points here\n" * 50,
        "scene.toml": b"version = 1\n",
        "typo.toml": b"[camera]\nfvo_deg = 40\n",
    }.items():
        (folder / name).write_bytes(data)
    with zipfile.ZipFile(folder / "a.zip", "w") as archive:
        archive.writestr("squares/a.laz", b"LASF")
    return folder


def _programs():
    """@return the program and its first words of each command, where ctest names the program"""
    out = {}
    for row in COMMANDS.read_text(encoding="utf-8").splitlines():
        if row.startswith("#"):
            continue
        name, program, _ = row.split("|")
        program, *words = program.split()
        variable = program.removeprefix("terravox-").upper()
        if f"TERRAVOX_{variable}" in os.environ:
            out[name.split()[0]] = [binary(variable), *words]
    return out


def run(mistake, files, out):
    """@return the program that has ended, and the parts that its message lacks"""
    places = {"IN": str(files), "OUT": str(out), "SQUARE": ""}
    if "SQUARE" in mistake.line:
        places["SQUARE"] = str(square())

    def placed(text):
        for name, path in places.items():
            text = text.replace(name + "/", path + "/")
        return text

    words = [places.get(word, placed(word)) for word in shlex.split(mistake.line)]
    start = _programs().get(words[0])
    argv = [*start, *words[1:]] if start else [ROOT / "terravox", *words]
    ended = Run(argv, environment={"TERRAVOX_NO_BUILD": "1"}, timeout_s=120)
    text = ended.err.replace("\n", " ")
    return ended, [part for part in map(placed, mistake.said) if part not in text]


def main():
    failed = 0
    files, out = wrong_files(), temporary_folder()
    wanted = sys.argv[1:]
    mistakes = [m for m in read_mistakes() if all(word in m.line for word in wanted)]
    for mistake in mistakes:
        ended, missing = run(mistake, files, out)
        # The library of the grabber puts its guess into a second line.
        lines = 2 if mistake.line.startswith("grab ") else 1
        if missing or ended.code != mistake.code or len(ended.err.splitlines()) > lines:
            failed += 1
            print(f"terravox {mistake.line}\n  missing: {missing}, exit code {ended.code}")
            print("  " + "\n  ".join(ended.err.splitlines()[:4]))
    print(f"{len(mistakes) - failed} of {len(mistakes)} messages name the remedy")
    sys.exit(failed > 0)


if __name__ == "__main__":
    main()

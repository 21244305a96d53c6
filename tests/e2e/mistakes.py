#!/usr/bin/env python3
"""Runs the mistakes of mistakes.txt."""

import dataclasses
import os
import shlex
import zipfile

from support import ROOT, Run, binary, square, temporary_folder

TABLE = ROOT / "tests" / "e2e" / "mistakes.txt"
COMMANDS = ROOT / "config" / "setup" / "commands.txt"


@dataclasses.dataclass(frozen=True)
class Mistake:
    line: str  # the command line behind ./terravox
    said: tuple


def read_mistakes():
    rows = TABLE.read_text(encoding="utf-8").splitlines()
    pairs = [row.split(" => ") for row in rows if not row.startswith("#")]
    return [Mistake(line, tuple(said.split(" && "))) for line, said in pairs]


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

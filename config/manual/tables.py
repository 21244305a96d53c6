"""What the programs say of their commands and options: `PROGRAM --option-tables`."""

import dataclasses
import json
import pathlib
import subprocess


@dataclasses.dataclass(frozen=True)
class Option:
    """One row of a help: see common/util/command_line.hpp."""

    names: tuple
    positional: str
    group: str
    text: str
    default: str
    required: bool
    repeats: bool
    value: str
    words: tuple


@dataclasses.dataclass(frozen=True)
class Command:
    """@param words behind `terravox`: ("analyse", "sky"), () of itself"""

    words: tuple
    summary: str
    footer: str
    options: tuple
    commands: tuple

    @property
    def page(self):
        return "-".join(("terravox", *self.words))

    def everything(self):
        yield self
        for command in self.commands:
            yield from command.everything()


@dataclasses.dataclass(frozen=True)
class Starts:
    """How programs are started: their folder, the program Node.js, words before a program that is
    for another processor."""

    programs: pathlib.Path
    node: str
    emulator: tuple = ()


def _option(row):
    fields = {**row, "names": tuple(row["names"]), "words": tuple(row["words"])}
    return Option(**fields)


def _command(table, words, summary):
    return Command(
        words=words,
        summary=summary,
        footer=table["footer"].strip("\n"),
        options=tuple(map(_option, table["options"])),
        commands=tuple(
            _command(inner, (*words, inner["name"]), inner["description"])
            for inner in table["commands"]
        ),
    )


def rows_of(commands_file):
    """@return name, program with its first words, text of each command of commands.txt"""
    for line in commands_file.read_text(encoding="utf-8").splitlines():
        if line and not line.startswith("#"):
            yield [part.strip() for part in line.split("|")]


def _table_of(program_line, starts):
    """@return None where the package is built without this program"""
    name, *inner = program_line.split()
    if name == "grabber":
        argv = [starts.node, starts.programs / "grabber" / "dist" / "main.js"]
    else:
        argv = [*starts.emulator, starts.programs / name]
        if not argv[-1].exists():
            return None
    done = subprocess.run([*argv, "--option-tables"], capture_output=True, text=True, check=True)
    table = json.loads(done.stdout)
    for word in inner:
        table = next(each for each in table["commands"] if each["name"] == word)
    return table


def read_commands(commands_file, starts):
    """@return the command terravox, with all others"""
    commands = []
    for name, program, text in rows_of(commands_file):
        table = _table_of(program, starts)
        if table is not None:
            commands.append(_command(table, (name.split()[0],), text))
    return Command((), "real places as ray-traced voxel landscapes", "", (), tuple(commands))

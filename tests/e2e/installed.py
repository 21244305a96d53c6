"""An installed copy of the programs, away from the checkout."""

import functools
import os
import pathlib
import shutil
import subprocess

from support import HANGS_S, ROOT, Run, binary, temporary_folder

BUILD = pathlib.Path(binary("RAYTRACER")).parents[1]
COMMANDS = ROOT / "config" / "setup" / "commands.txt"


@functools.cache
def hidden(folder=ROOT):
    """@return a command that runs others where that folder is empty; [] where the system does not
    let it
    """
    empty = temporary_folder()
    script = 'mount --bind "$0" "$1" && cd / && shift && exec "$@"'
    users = [] if os.geteuid() == 0 else ["--user", "--map-root-user"]
    words = ["unshare", "--mount", *users, "sh", "-c", script, str(empty), str(folder)]
    if shutil.which("unshare") is None:
        return []
    run = Run([*words, "ls", "-A", folder])
    return words if run.code == 0 and run.out == "" else []


def install(prefix, *components):
    """@param components those of the programs, with their data, unless others are named"""
    for component in components or ("data", "preview", "programs"):
        words = ["cmake", "--install", BUILD, "--prefix", prefix, "--component", component]
        Run(words, timeout_s=HANGS_S).done()


def rows():
    """@return name, program with its first words, text of each command for users"""
    for line in COMMANDS.read_text(encoding="utf-8").splitlines():
        if not line.startswith("#"):
            yield [part.strip() for part in line.split("|")]


@functools.cache
def moved_prefix():
    """An installed prefix that was moved; its names have spaces."""
    first = temporary_folder() / "made here"
    install(first)
    moved = temporary_folder() / "and moved" / "Terra Vox"
    moved.parent.mkdir()
    shutil.move(first, moved)
    return moved


def start(program, *arguments, **options):
    """A program of the prefix that runs on, where the checkout is hidden."""
    return subprocess.Popen(
        [*hidden(), str(program), *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        **options,
    )

#!/usr/bin/env python3
"""Writes man pages and completions into an installed prefix, from what its programs say of their
options. Run by cmake --install (config/cmake/install_manual.cmake)."""

import argparse
import pathlib

from completion import bash, fish, zsh
from man_page import man_page
from tables import Starts, read_commands


def write(file, text):
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text, encoding="utf-8")


def write_pages(command, parent, folder, version, date):
    write(folder / f"{command.page}.1", man_page(command, parent, version, date))
    for inner in command.commands:
        write_pages(inner, command, folder, version, date)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("prefix", type=pathlib.Path, help="where the programs are installed")
    parser.add_argument("--node", required=True, help="the program Node.js")
    parser.add_argument("--emulator", default="", help="to start programs with; words with ;")
    parser.add_argument("--version", required=True, help="of Terravox")
    parser.add_argument("--date", required=True, help="of the pages, YYYY-MM-DD")
    args = parser.parse_args()
    share = args.prefix / "share"
    starts = Starts(
        programs=args.prefix / "lib" / "terravox",
        node=args.node,
        emulator=tuple(filter(None, args.emulator.split(";"))),
    )
    root = read_commands(share / "terravox" / "setup" / "commands.txt", starts)
    write_pages(root, None, share / "man" / "man1", args.version, args.date)
    write(share / "bash-completion" / "completions" / "terravox", bash(root))
    write(share / "fish" / "vendor_completions.d" / "terravox.fish", fish(root))
    write(share / "zsh" / "vendor-completions" / "_terravox", zsh(root))


if __name__ == "__main__":
    main()

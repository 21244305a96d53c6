#!/usr/bin/env python3
"""Readers of an archive that is patched while they read: what they met. Prints one line of JSON.

The readers are those of tests/e2e/archive_readers.py.
"""

import argparse
import asyncio
import shutil
import subprocess
import time

import serving  # noqa: F401, first: it makes the modules of tests/e2e known
from archive_readers import read_while
from archive_readers_test import Static
from front_test import Front
from serving import Server, binary, kept_folder, many_files, print_figures, temporary_folder

OPTIONS = ["--voxel", "0.5", "--cache", "none", "--quiet", "--steps=-material_guesses"]


def run(program, *words):
    command = [binary(program), *(str(word) for word in words)]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def make_states(squares):
    """@return the archive, the two changes that lead to and fro, and the bytes of both states"""
    folder = kept_folder("readers")
    flights = {density: folder / f"flight{density}" for density in (2, 3)}
    for density, flight in flights.items():
        words = ["--seed", "7", "--squares", squares, "--square-m", "256", "--density", density]
        run("SURVEY", *words, "-o", flight)
    names = sorted(file.stem for file in flights[2].glob("*.laz"))
    # Not a square with the lowest place of all: rock reaches down to it everywhere.
    name = names[len(names) // 5]
    first, second = folder / "first.tvx", folder / "second.tvx"
    changes = [folder / "to.tvx", folder / "back.tvx"]
    run("CONVERT", flights[2], first, *OPTIONS)
    run("CONVERT", flights[2], changes[1], *OPTIONS, "--squares", name)
    shutil.copy(flights[3] / f"{name}.laz", flights[2])
    run("CONVERT", flights[2], second, *OPTIONS)
    run("CONVERT", flights[2], changes[0], *OPTIONS, "--squares", name)
    return first, changes, [first.read_bytes(), second.read_bytes()]


class Measure:
    def __init__(self, arguments):
        self.readers = arguments.readers
        self.patches = arguments.patches
        self.first, self.changes, self.states = make_states(arguments.squares)
        folder = temporary_folder()
        folder.chmod(0o755)
        self.place = folder / "place.tvx"

    def restore(self):
        shutil.copy(self.first, self.place)
        self.place.chmod(0o644)

    def patch(self, counts):
        """Each reader opens each state once on average before the next one replaces it."""
        for n in range(self.patches):
            opened = counts.opened
            while counts.opened < opened + self.readers and not counts.errors:
                time.sleep(0.01)
            run("ARCHIVE", "patch", self.place, self.changes[n % 2], "--quiet")

    def read(self, port, path):
        begin = time.monotonic()
        counts = asyncio.run(
            read_while(self.patch, readers=self.readers, port=port, path=path, states=self.states)
        )
        seconds = time.monotonic() - begin
        return {
            "errors": len(counts.errors),
            "first_error": counts.errors[0] if counts.errors else "",
            "opened": counts.opened,
            "parts": counts.parts,
            "changed": counts.changed,
            "waits": counts.refused,
            "lost": counts.lost,
            "reconnected": counts.reconnected,
            "states": len(counts.states),
            "mb_per_s": counts.bytes / seconds / 1e6,
            "seconds": seconds,
        }

    def all(self):
        out = {"archive_mb": len(self.states[0]) / 1e6}
        self.restore()
        server = Server(self.place, "--cache", "none")
        try:
            out["server"] = self.read(server.port, "/v2/archive.tvx")
            self.restore()
            with Front(server.port) as front:
                out["front"] = self.read(front.port, "/v2/archive.tvx")
        finally:
            server.stop()
        self.restore()
        with Static(self.place.parent) as host:
            out["files"] = self.read(host.port, "/place.tvx")
        return out


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--readers", type=int, default=1000)
    arguments.add_argument("--patches", type=int, default=10)
    arguments.add_argument("--squares", default="6x6")
    many_files()
    print_figures(Measure(arguments.parse_args()).all())


if __name__ == "__main__":
    main()

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
from archive_readers import read_while, two_states
from nginx import Front, Static
from serving import (
    HANGS_S,
    Server,
    binary,
    kept_folder,
    many_files,
    print_figures,
    temporary_folder,
)


def run(program, *words):
    command = [binary(program), *(str(word) for word in words)]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


class Measure:
    def __init__(self, arguments):
        self.readers = arguments.readers
        self.patches = arguments.patches
        self.first, self.changes, self.states = two_states(
            kept_folder("readers"), run, squares=arguments.squares, square_m=256, number=7
        )
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
            deadline = time.monotonic() + HANGS_S
            while counts.opened < opened + self.readers and not counts.errors:
                if time.monotonic() > deadline:
                    raise SystemExit(f"no reader opened the archive within {HANGS_S} s")
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

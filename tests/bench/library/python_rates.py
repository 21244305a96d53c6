#!/usr/bin/env python3
"""How fast the Python package casts rays and reads surfaces, next to the C++ library.

`terravox bench library/python` runs it; its last line is JSON.
Python, C++ and two processes of C++ at the same time, which is the most that a second thread can
bring on this machine, are measured in turns. The best round of each counts.
"""

import argparse
import pathlib
import subprocess
import sys
import time

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "serve"))

from serving import (  # noqa: E402
    binary,
    print_figures,
    synthetic_survey,
    temporary_folder,
)


def archive_of_survey(folder):
    out = folder / "survey.tvx"
    survey = synthetic_survey(square_m=1000, density=6)
    subprocess.run([binary("CONVERT"), survey, out, "-q"], check=True, stdout=subprocess.DEVNULL)
    return out


def random_rays(world, count):
    """@return origins above all of a world, and directions downwards"""
    random = np.random.default_rng(1)
    west, south, east, north = world.bounds
    low = (west, south, world.heights[1] + 10)
    high = (east, north, world.heights[1] + 10)
    origins = random.uniform(low, high, (count, 3))
    directions = random.uniform((-1, -1, -1.1), (1, 1, -0.1), (count, 3))
    return origins, directions


class Library:
    """A process of library_rates."""

    def __init__(self, archive, rays):
        self.process = subprocess.Popen(
            [binary("LIBRARY_RATES"), archive, rays],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.measure("surface", 1)  # it is open when this is answered

    def start(self, what, threads):
        self.process.stdin.write(f"{what} {threads}\n")
        self.process.stdin.flush()

    def seconds(self):
        """@return the seconds that passed, and those of processors"""
        line = self.process.stdout.readline()
        if not line:
            sys.exit(f"library_rates: exit code {self.process.wait()}")
        return tuple(float(number) for number in line.split())

    def measure(self, what, threads):
        self.start(what, threads)
        return self.seconds()

    def close(self):
        self.process.stdin.close()
        if self.process.wait() != 0:
            sys.exit(f"library_rates: exit code {self.process.returncode}")


def seconds_of(call):
    """@return the seconds that passed, and those of processors"""
    processor = time.process_time()
    start = time.perf_counter()
    call()
    return time.perf_counter() - start, time.process_time() - processor


class Best:
    """The shortest of all rounds, and the least processor time, by what was measured."""

    def __init__(self):
        self.passed = {}
        self.processor = {}

    def add(self, name, seconds):
        for best, value in zip((self.passed, self.processor), seconds, strict=True):
            best[name] = min(value, best.get(name, value))


def measure_round(best, world, rays, libraries):
    for threads in (1, 2):
        library = libraries[0]
        best.add(f"library_cast_{threads}", library.measure("cast", threads))
        best.add(f"cast_{threads}", seconds_of(lambda t=threads: world.cast(*rays, threads=t)))
        best.add(f"library_surface_{threads}", library.measure("surface", threads))
        best.add(f"surface_{threads}", seconds_of(lambda t=threads: world.surface(threads=t)))
    for library in libraries:
        library.start("cast", 1)
    both = [library.seconds() for library in libraries]
    best.add("two_processes", tuple(max(values) for values in zip(*both, strict=True)))


def figures_of(best, rays):
    passed = best.passed
    out = {
        "opening_ms": 1000 * passed["opening"],
        "speedup": passed["cast_1"] / passed["cast_2"],
        "speedup_processor": 2 * best.processor["cast_1"] / best.processor["cast_2"],
        "speedup_library": passed["library_cast_1"] / passed["library_cast_2"],
        "speedup_processes": 2 * passed["library_cast_1"] / passed["two_processes"],
    }
    for threads in (1, 2):
        cast = passed[f"cast_{threads}"]
        surface = passed[f"surface_{threads}"]
        out[f"cast_{threads}_mrays"] = rays / cast / 1e6
        out[f"cast_{threads}_of_library"] = passed[f"library_cast_{threads}"] / cast
        out[f"surface_{threads}_ms"] = 1000 * surface
        out[f"surface_{threads}_of_library"] = passed[f"library_surface_{threads}"] / surface
    return out


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--archive", type=pathlib.Path, help="instead of a synthetic survey")
    parser.add_argument("--rays", type=int, default=1_000_000)
    parser.add_argument("--rounds", type=int, default=7)
    args = parser.parse_args()
    sys.path.insert(0, binary("PYTHON_PACKAGE"))
    import terravox  # noqa: PLC0415 - it is in the folder that was named

    folder = temporary_folder()
    archive = args.archive or archive_of_survey(folder)
    best = Best()
    for _ in range(args.rounds):
        world = terravox.open(archive)
        best.add("opening", seconds_of(world.surface))
    rays = random_rays(world, args.rays)
    np.concatenate(rays).tofile(folder / "rays")
    libraries = [Library(archive, folder / "rays") for _ in range(2)]
    for _ in range(args.rounds):
        measure_round(best, world, rays, libraries)
    for library in libraries:
        library.close()
    print_figures(figures_of(best, args.rays))


if __name__ == "__main__":
    main()

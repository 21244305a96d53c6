#!/usr/bin/env python3
"""How fast the Python package casts rays and reads surfaces, next to the C++ library.

python_rates.py ARCHIVE [--rays N] [--rounds N] [--build FOLDER]

Both are measured in turns, and the best round of each counts. Needs a build with the Python
package.
"""

import argparse
import pathlib
import subprocess
import sys
import time

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[3]
MULTIPLIER = 6364136223846793005
INCREMENT = 1442695040888963407


def numbers(count):
    """The same numbers as those of library_rates.cpp."""
    out = np.empty(count)
    state = 1
    for i in range(count):
        state = (state * MULTIPLIER + INCREMENT) & 0xFFFF_FFFF_FFFF_FFFF
        out[i] = (state >> 11) / 2**53
    return out


def rays(world, count):
    west, south, east, north = world.bounds
    five = numbers(5 * count).reshape(count, 5)
    origins = np.stack(
        [
            west + (east - west) * five[:, 0],
            south + (north - south) * five[:, 1],
            np.full(count, world.heights[1] + 10),
        ],
        axis=1,
    )
    directions = np.stack([2 * five[:, 2] - 1, 2 * five[:, 3] - 1, -0.1 - five[:, 4]], axis=1)
    return origins, directions


def seconds_of(call):
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("archive", type=pathlib.Path)
    parser.add_argument("--rays", type=int, default=1_000_000)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release")
    args = parser.parse_args()
    sys.path.insert(0, str(args.build / "python"))
    import terravox  # noqa: PLC0415 - it is in the folder that was given

    opening = []
    for _ in range(args.rounds):
        world = terravox.open(args.archive)
        opening.append(seconds_of(world.surface))
    origins, directions = rays(world, args.rays)
    program = args.build / "bin" / "library_rates"
    print(f"surface of an archive just opened: {1000 * min(opening):.1f} ms")
    for threads in (1, 2):
        best = {}
        for _ in range(args.rounds):
            command = [program, args.archive, str(args.rays), str(threads)]
            run = subprocess.run(command, capture_output=True, text=True, check=True)
            cast, surface = (float(line) for line in run.stdout.split())
            mine = (
                seconds_of(lambda t=threads: world.cast(origins, directions, threads=t)),
                seconds_of(lambda t=threads: world.surface(threads=t)),
            )
            for name, value in zip(
                ("cast C++", "surface C++", "cast", "surface"), (cast, surface, *mine), strict=True
            ):
                best[name] = min(value, best.get(name, value))
        print(
            f"{threads} threads: cast {args.rays / best['cast'] / 1e6:.2f} million rays a second, "
            f"{best['cast C++'] / best['cast']:.2f} of C++; surface {1000 * best['surface']:.1f} "
            f"ms, {best['surface C++'] / best['surface']:.2f} of C++"
        )


if __name__ == "__main__":
    main()

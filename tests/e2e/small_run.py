#!/usr/bin/env python3
"""small_run.py NAME PROGRAM ARGUMENT...: runs a program of Terravox with smaller numbers.

The documents test puts it in the place of the programs, so that commands of the pages take moments.
"""

import os
import sys

WIDTH_PX, SAMPLES, TIME_S = 64, 2, 0.1
SQUARE_M, DENSITY = 256, 2
# Of an analysis: its cells and voxels, rays to the sky, bins of the sun's way.
CELL_M, VOXEL_M, DIRECTIONS, BIN_DEG = 2, 0.5, 16, 15


def change(arguments, flag, smaller, otherwise=None):
    """Replaces the value of a flag, or adds the flag with `otherwise`."""
    if flag in arguments[:-1]:
        at = arguments.index(flag) + 1
        return [*arguments[:at], smaller(arguments[at]), *arguments[at + 1 :]]
    return arguments if otherwise is None else [*arguments, flag, otherwise]


def at_most(limit):
    return lambda number: str(min(int(number), limit))


def at_least(limit):
    return lambda number: str(max(float(number), limit))


def small_size(size):
    width, height = (int(number) for number in size.split("x"))
    return f"{WIDTH_PX}x{max(1, WIDTH_PX * height // width)}"


def small_picture(arguments):
    arguments = change(arguments, "--size", small_size, f"{WIDTH_PX}x36")
    arguments = change(arguments, "--samples", at_most(SAMPLES))
    return change(arguments, "--time", lambda s: str(min(float(s), TIME_S)))


def small_analysis(arguments):
    arguments = change(arguments, "--resolution", at_least(CELL_M), str(CELL_M))
    arguments = change(arguments, "--voxel", at_least(VOXEL_M))
    if arguments[1] in ("sky", "energy"):
        arguments = change(arguments, "--directions", at_most(DIRECTIONS), str(DIRECTIONS))
    if arguments[1] in ("sun", "energy"):
        arguments = change(arguments, "--bin-deg", at_least(BIN_DEG), str(BIN_DEG))
    return arguments


def small(name, arguments):
    if name == "terravox-raytracer" and arguments[:1] in (["render"], ["animate"]):
        return small_picture(arguments)
    if name == "terravox-raytracer" and arguments[:1] == ["analyse"]:
        return small_analysis(arguments)
    if name == "terravox-publish":
        # A picture of 1200 x 630 pixels, which publish_test.py looks at.
        return [*arguments, "--no-preview"]
    if name == "terravox-survey":
        for flag, most in (("--square-m", SQUARE_M), ("--density", DENSITY)):
            arguments = change(arguments, flag, at_most(most), str(most))
        return arguments
    if name == "terravox-voxelserver" and "--prepare-only" not in arguments:
        return change(arguments, "--port", lambda port: port, "0")
    return arguments


if __name__ == "__main__":
    name, program, *rest = sys.argv[1:]
    if not {"--help", "-h", "--version"} & set(rest):
        rest = small(name, rest)
    os.execv(program, [program, *rest])

#!/usr/bin/env python3
"""Repeats the measurements of figures 6 to 9 of the paper on the first system, and draws them.

    tests/bench/paper/figures.py --output FOLDER [--ortho FILE] [--rounds 3] [--runs 10]
                                 [--processor 'NAME=FLAGS' ...] [--box-sizes FILE]

Needs TERRAVOX_RAYTRACER and TERRAVOX_SURVEY (the programs), as `terravox bench paper/figures` sets
them. The world is the benchmark square of TERRAVOX_BENCH_DATA, or a synthetic survey of 1 km.
Writes figure-6-box-size.svg, figure-7-tile-size.svg, figure-8-processors.svg,
figure-9-steps.svg and figures.json; the last line is JSON, for programs.

Ref: Lunar, Bohak, Marolt, "Distributed ray tracing for rendering voxelized LIDAR geospatial data",
ERK 2016.

Figure 6 (time against the size of boxes, 16 to 256) comes from --box-sizes, which `terravox bench`
writes: boxes of the program are 64 x 256 x 64 by format, so a walker of the benchmark's own goes
through the same voxels in boxes of other sizes (box_sizes.hpp). Without it there is no figure 6.
"""

import argparse
import json
import os
import pathlib
import platform
import shutil
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "serve"))

from chart import bar_chart, line_chart, median  # noqa: E402
from serving import benchmark_square, binary, print_figures, temporary_folder  # noqa: E402

TILES_PX = (8, 16, 32, 64, 128, 256)
# Milliseconds of the paper for one box of 64 x 256 x 64, for the steps that both have (figure 9).
PAPER_MS = {
    "point load": 283,
    "orthophoto load": 0.167,
    "transformation": 4,
    "quantization": 1,
    "column init": 0.882,
    "building fill": 0.862,
    "ground fill": 16,
    "underground fill": 2,
    "specialization": 19,
    "serialization": 33,
    "water": 0.049,
    "whole box": 435,
}
# The camera of the paper: a bird's eye about 500 m above the town, 40 degrees, 1280 x 720.
SQUARE_CAMERA = ["--camera-position", "462500,101050,800", "--camera-target", "462500,101450,300"]
PAPER_PICTURE = ["--camera-fov-deg", "40", "--size", "1280x720", "--memory-mib", "700"]


class Bench:
    """Renders the world and reads the clocks."""

    def __init__(self, ortho):
        self.world = [str(word) for word in benchmark_square()]
        real = self.world[0].endswith(".laz")
        self.name = "the benchmark square" if real else "a synthetic survey of 1 km"
        self.view = PAPER_PICTURE + (SQUARE_CAMERA if real else [])
        if ortho and real:
            self.world += ["--ortho", ortho]
        self.folder = temporary_folder()

    def cache(self, kept_by):
        return self.folder / ("cache-" + kept_by.replace("/", "-"))

    def clear(self, kept_by="any"):
        """Nothing prepared is left on the disk; the LiDAR files stay in the system's memory."""
        shutil.rmtree(self.cache(kept_by), ignore_errors=True)

    def render(self, *flags, kept_by="any"):
        """Wall seconds of the program from start to end, and its report."""
        report = self.folder / "report.json"
        command = [binary("RAYTRACER"), "render", *self.world, *self.view, *flags]
        command += [
            "--cache",
            str(self.cache(kept_by)),
            "-q",
            "--report",
            str(report),
            "-o",
            str(self.folder / "picture.png"),
        ]
        began = time.monotonic()
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        seconds = time.monotonic() - began
        if done.returncode != 0:
            sys.exit(
                f"render {' '.join(flags)}: exit code {done.returncode}: "
                f"{done.stderr.strip()[-500:]}"
            )
        return seconds, json.loads(report.read_text())


def tile_sizes(bench, rounds):
    """Figure 7. All sizes take turns in each round: changes in the machine's speed affect all."""
    cold = {px: [] for px in TILES_PX}
    hot = {px: [] for px in TILES_PX}
    for _ in range(rounds):
        for px in TILES_PX:
            bench.clear()
            for times in (cold, hot):
                times[px].append(bench.render("--tile", str(px))[0])
    return {"cold": cold, "hot": hot}


def processors(bench, runs, kinds):
    """Figure 8: the first run of each processor starts with an empty cache.

    They take turns, each with a cache of its own.
    """
    times = {name: [] for name in kinds}
    for name in kinds:
        bench.clear(name)
    for _ in range(runs):
        for name, flags in kinds.items():
            times[name].append(bench.render(*flags, kept_by=name)[0])
    return times


def steps(bench):
    """Figure 9: milliseconds of each step for one box, slowest first.

    On one thread with empty caches.
    """
    bench.clear()
    stages = {stage["name"]: stage for stage in bench.render("--threads", "1")[1]["stages"]}
    boxes = stages["serialization"]["count"]
    making = {
        name: stage["seconds"] * 1e3 / boxes
        for name, stage in stages.items()
        if not name.endswith("(clock)")
        and name not in ("open files", "write pictures")
        and stage["seconds"] > 0
    }
    # The paper has one time for both.
    making["water"] = making.pop("water equalization", 0) + making.pop("water deepening", 0)
    making["whole box"] = sum(making.values())
    return dict(sorted(making.items(), key=lambda step: -step[1]))


def thread_kinds():
    cores = len(os.sched_getaffinity(0))
    counts = sorted({1, cores, *(2**power for power in range(1, 10) if 2**power < cores)})
    return {
        f"{count} thread{'s' if count > 1 else ''}": ["--threads", str(count)] for count in counts
    }


def machine():
    """Processor and count of cores, as the captions have them."""
    facts = pathlib.Path("/proc/cpuinfo")
    names = (
        [
            line.partition(":")[2].strip()
            for line in facts.read_text().splitlines()
            if line.startswith("model name")
        ]
        if facts.exists()
        else []
    )
    return f"{names[0] if names else platform.machine()}, {len(os.sched_getaffinity(0))} cores"


def box_size_chart(sizes, caption):
    """Figure 6.

    @param sizes [{"edge", "make_s": [seconds], "walk_s": [seconds]}]
    """
    return line_chart(
        "A picture's rays, by edge of the boxes",
        caption,
        "edge of a box, voxels",
        "seconds, one thread",
        [size["edge"] for size in sizes],
        {
            "trees made and walked": [
                [make + walk for make, walk in zip(size["make_s"], size["walk_s"], strict=True)]
                for size in sizes
            ],
            "walked": [size["walk_s"] for size in sizes],
        },
    )


def draw(figures, place):
    caption = f"{figures['world']}, 1280 x 720; {figures['machine']}"
    tiles = figures["tile_px"]
    kinds = figures["processors"]
    at_sizes = {name: [times[px] for px in TILES_PX] for name, times in tiles.items()}
    runs = range(1, 1 + max(len(times) for times in kinds.values()))
    charts = {
        "figure-7-tile-size.svg": line_chart(
            "A picture's time, by edge of its tiles",
            caption,
            "edge of a tile, pixels",
            "seconds",
            TILES_PX,
            at_sizes,
        ),
        "figure-8-processors.svg": line_chart(
            "A picture's time, by processor, run after run",
            caption,
            "run (nothing prepared before the first)",
            "seconds",
            runs,
            {name: [[seconds] for seconds in times] for name, times in kinds.items()},
        ),
        "figure-9-steps.svg": bar_chart(
            "Steps of making one box",
            caption,
            "milliseconds a box, one thread",
            figures["step_ms"],
            PAPER_MS,
            "paper, 64 x 256 x 64",
        ),
    }
    if figures["box_sizes"]:
        charts["figure-6-box-size.svg"] = box_size_chart(figures["box_sizes"], caption)
    place.mkdir(parents=True, exist_ok=True)
    for name, svg in charts.items():
        (place / name).write_text(svg)
    (place / "figures.json").write_text(json.dumps(figures, indent=2) + "\n")


def readings(figures):
    out = [
        [f"tile of {px} px, {name}", "s", median(times[px])]
        for name, times in figures["tile_px"].items()
        for px in TILES_PX
    ]
    for name, times in figures["processors"].items():
        out += [
            [f"{name}: first run", "s", times[0]],
            [f"{name}: runs after it", "s", median(times[1:])],
        ]
    for size in figures["box_sizes"]:
        name = f"boxes of {size['edge']}"
        out += [
            [f"{name}: trees made", "s", median(size["make_s"])],
            [f"{name}: walked", "s", median(size["walk_s"])],
        ]
    return out + [[f"step: {name}", "ms/box", value] for name, value in figures["step_ms"].items()]


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--output",
        type=pathlib.Path,
        required=True,
        help="folder for the drawings and figures.json",
    )
    parser.add_argument("--ortho", help="orthophoto of the benchmark square, with its place")
    parser.add_argument(
        "--rounds",
        type=int,
        default=3,
        help="pictures for each size of tile, cold and hot; at least 1",
    )
    parser.add_argument(
        "--runs", type=int, default=10, help="pictures for each processor; at least 2"
    )
    parser.add_argument(
        "--processor",
        action="append",
        default=[],
        metavar="NAME=FLAGS",
        help="instead of one for each count of threads",
    )
    parser.add_argument(
        "--box-sizes", type=pathlib.Path, help="figures of sizes of boxes, by `terravox bench`"
    )
    options = parser.parse_args()
    if options.rounds < 1 or options.runs < 2:
        parser.error("--rounds is at least 1, --runs at least 2")
    kinds = {
        name: flags.split()
        for name, _, flags in (text.partition("=") for text in options.processor)
    } or thread_kinds()

    bench = Bench(options.ortho)
    figures = {"world": bench.name, "machine": machine()}
    figures["box_sizes"] = json.loads(options.box_sizes.read_text()) if options.box_sizes else []
    figures["tile_px"] = tile_sizes(bench, options.rounds)
    figures["processors"] = processors(bench, options.runs, kinds)
    figures["step_ms"] = steps(bench)
    draw(figures, options.output)
    print_figures({"readings": readings(figures)})


if __name__ == "__main__":
    main()

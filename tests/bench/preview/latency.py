#!/usr/bin/env python3
"""The preview window at the demo scene, on a virtual display with OpenGL in software.

It is flown and turned by keys and mouse; its report at the end gives times of frames and first
pictures. Rendered with green threads alone, and with a thread. Prints one line of JSON.
"""

import argparse
import json
import pathlib
import re
import statistics
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "tests" / "e2e"), str(ROOT / "tests" / "bench")]
from desktop import Desktop  # noqa: E402
from support import Program, temporary_folder  # noqa: E402
from surveys import synthetic_survey  # noqa: E402


def hold(desktop, key, seconds):
    with desktop.held(key):
        time.sleep(seconds)


def fly(desktop, seconds):
    """Turns, drags and moves the camera for a while."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        hold(desktop, "Left", 1)
        desktop.drag(700, 350, 800, 360)
        hold(desktop, "Right", 1)
        hold(desktop, "w", 0.5)
        hold(desktop, "s", 0.5)


def resident_mib(pid):
    status = pathlib.Path(f"/proc/{pid}/status").read_text()
    return int(re.search(r"VmRSS:\s+(\d+)", status).group(1)) / 1024


def measure(desktop, world, threads, seconds):
    report = temporary_folder() / "report.json"
    size = [1280, 720]
    program = Program(
        "preview",
        world,
        "--ortho",
        world / "ortho",
        "--scene",
        ROOT / "config/scenes/demo.toml",
        "--window",
        f"{size[0]}x{size[1]}",
        "--log",
        "debug",
        "--report",
        report,
        "--threads",
        threads,
        environment=desktop.environment,
    )
    try:
        program.saw("first picture after", 300)
        desktop.do("mousemove", 800, 400)
        desktop.key("F2", "F3")  # the picture fills the window
        time.sleep(20)  # until all visible boxes are in memory
        warm = len(program.lines)
        fly(desktop, seconds)
        moved = [line for line in program.lines[warm:] if line]
        memory_mib = resident_mib(program.process.pid)
        desktop.key("ctrl+q")
        code = program.end(60)
        if code != 0:
            raise RuntimeError(f"preview: exit code {code}: {program.log()[-600:]}")
    finally:
        program.kill()
        program.process.stdout.close()
    firsts = sorted(
        float(m.group(1)) / 1e3
        for m in (re.search(r"first picture after ([\d.]+) ms", line) for line in moved)
        if m
    )
    results = json.loads(report.read_text())
    return {
        "pictures": len(firsts),
        "first_median_s": statistics.median(firsts),
        "first_p99_s": firsts[int(0.99 * (len(firsts) - 1))],
        "frame_median_s": results["frames"]["median_s"],
        "frame_p95_s": results["frames"]["p95_s"],
        "stop_p99_s": results["stops"]["p99_s"],
        "memory_mib": memory_mib,
    }


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--seconds", type=float, default=30)
    args = parser.parse_args()
    world = synthetic_survey()
    desktop = Desktop()
    try:
        figures = {
            f"{name}_{key}": value
            for name, threads in (("green", 0), ("thread", 1))
            for key, value in measure(desktop, world, threads, args.seconds).items()
        }
    finally:
        desktop.stop()
    print(json.dumps(figures))


if __name__ == "__main__":
    main()

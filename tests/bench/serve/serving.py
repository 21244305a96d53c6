"""Shared parts of the scripts behind `terravox bench serve/...`: served world, reporting."""

import json
import os
import pathlib
import resource
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "e2e"))

from support import (  # noqa: E402, F401, names that the scripts import from here
    HANGS_S,
    Server,
    binary,
    hold_port,
    server_has,
    temporary_folder,
    wait_until,
)


def synthetic_survey(squares="1x1", square_m=256, density=4):
    """@return a folder with a synthetic survey

    It is kept with others of this bench run in TERRAVOX_BENCH_SCRATCH, where that is set.
    """
    root = pathlib.Path(os.environ.get("TERRAVOX_BENCH_SCRATCH") or temporary_folder())
    folder = root / f"survey-{squares}-{square_m}-{density}"
    if not folder.exists():
        part = folder.with_suffix(".part")
        subprocess.run(
            [
                binary("SURVEY"),
                "--seed",
                "7",
                "--squares",
                squares,
                "--square-m",
                str(square_m),
                "--density",
                str(density),
                "-o",
                part,
            ],
            check=True,
            stdout=subprocess.DEVNULL,
        )
        part.rename(folder)
    return folder


def benchmark_square():
    """@return arguments for the real square of 1 km in the shared data, else for a synthetic one"""
    real = pathlib.Path(os.environ.get("TERRAVOX_BENCH_DATA", "")) / "bench" / "TM_462_101.laz"
    if real.is_file():
        return [real, "--classes", "si-lss", "--crs", "EPSG:3794"]
    return [synthetic_survey("1x1", 1000, 6)]


def kept_folder(name):
    """A folder that lasts as long as the bench."""
    root = os.environ.get("TERRAVOX_BENCH_SCRATCH")
    folder = pathlib.Path(root) / name if root else temporary_folder()
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def many_files():
    """Lets this process, and those it starts, have as many connections as the machine allows."""
    hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))


def percentile(values, share):
    values = sorted(values)
    return values[min(len(values) - 1, int(len(values) * share))]


def print_figures(figures):
    print(json.dumps(figures), flush=True)

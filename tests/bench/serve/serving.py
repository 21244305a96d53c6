"""Shared parts of the scripts behind `terravox bench serve/...`: served world, reporting."""

import json
import os
import pathlib
import sys

TESTS = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(TESTS / "e2e"), str(TESTS / "bench")]

from support import Server, binary, hold_port, temporary_folder  # noqa: E402, F401, for scripts
from surveys import synthetic_survey  # noqa: E402


def benchmark_square():
    """@return arguments for the real square of 1 km in the shared data, else for a synthetic one"""
    real = pathlib.Path(os.environ.get("TERRAVOX_BENCH_DATA", "")) / "bench" / "TM_462_101.laz"
    if real.is_file():
        return [real, "--classes", "si-lss", "--crs", "EPSG:3794"]
    return [synthetic_survey()]


def kept_folder(name):
    """A folder that lasts as long as the bench."""
    root = os.environ.get("TERRAVOX_BENCH_SCRATCH")
    folder = pathlib.Path(root) / name if root else temporary_folder()
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def print_figures(figures):
    print(json.dumps(figures), flush=True)

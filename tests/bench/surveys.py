"""Synthetic surveys for the scripts behind `terravox bench`."""

import os
import pathlib
import subprocess

from support import binary, temporary_folder


def synthetic_survey(square_m=1000, density=6):
    """@return a folder with a square of the synthetic survey; without arguments, the demo's

    It is kept with others of this bench run in TERRAVOX_BENCH_SCRATCH, where that is set.
    """
    root = pathlib.Path(os.environ.get("TERRAVOX_BENCH_SCRATCH") or temporary_folder())
    folder = root / f"survey-{square_m}-{density}"
    if not folder.exists():
        part = folder.with_suffix(".part")
        square = ["--squares", "1x1", "--square-m", str(square_m), "--density", str(density)]
        subprocess.run(
            [binary("SURVEY"), "--seed", "7", *square, "-o", part],
            check=True,
            stdout=subprocess.DEVNULL,
        )
        part.rename(folder)
    return folder

"""Shared parts of the scripts behind `terravox bench view/...`: sites, browsers, hosts."""

import gzip
import json
import os
import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests" / "e2e"))

import site_views  # noqa: E402
from static_host import StaticHost  # noqa: E402
from support import binary, render, temporary_folder  # noqa: E402

# Of a noise world: the part that is published, and where the camera stands, in voxels of a metre.
SEED = "generated:7"
HEIGHTS = "--heights=-100,300"
SIDES = {1: (0, 1024), 100: (-4608, 5632)}
POSITION = (150, 140, 150)
TARGET = (600, 20, 600)
LIMIT_S = 3600


def run(*command):
    subprocess.run(
        [str(word) for word in command], check=True, stdout=subprocess.DEVNULL, timeout=LIMIT_S
    )


def kept(name):
    """A path that lasts from run to run, or as long as the bench."""
    root = os.environ.get("TERRAVOX_BENCH_CACHE") or os.environ.get("TERRAVOX_BENCH_SCRATCH")
    folder = pathlib.Path(root or temporary_folder())
    folder.mkdir(parents=True, exist_ok=True)
    return folder / name


def once(path, make):
    """Makes a file or folder unless it is there. @param make gets the name to write to"""
    if not path.exists():
        # The ending is kept: programs choose the format by it.
        part = path.with_name("part-" + path.name)
        shutil.rmtree(part, ignore_errors=True)
        part.unlink(missing_ok=True)
        make(part)
        part.rename(path)
    return path


def demo_archive():
    """The demo's square kilometre, a synthetic survey."""

    def make(part):
        survey = temporary_folder() / "survey"
        demo = ["--seed", "7", "--squares", "1x1", "--square-m", "1000", "--density", "6"]
        run(binary("SURVEY"), *demo, "-o", survey)
        ortho = survey / "ortho"
        run(binary("CONVERT"), survey, "--ortho", ortho, part, "--quiet")

    return once(kept("view-demo.tvx"), make)


def noise_archive(km2):
    def make(part):
        low, high = SIDES[km2]
        area = f"--area={low},{low},{high},{high}"
        run(binary("CONVERT"), SEED, part, area, HEIGHTS, "--quiet")

    return once(kept(f"view-noise-{km2}.tvx"), make)


def site_of(archive, *camera):
    """A site that lasts as long as this process."""
    site = temporary_folder() / "site"
    run(binary("PUBLISH"), archive, site, "--no-preview", *camera, "--quiet")
    return site


def demo_site():
    scene = ROOT / "config" / "scenes" / "demo.toml"
    return site_of(demo_archive(), "--scene", scene)


def noise_site(km2):
    words = [",".join(map(str, at)) for at in (POSITION, TARGET)]
    camera = ["--camera-space", "voxel", "--camera-inside-rock", "yes", "--fov", "42"]
    return site_of(
        noise_archive(km2), *camera, f"--camera-position={words[0]}", f"--camera-target={words[1]}"
    )


def browse(site, width, height, **job):
    """Opens a site in a browser. @return what drive.mjs found, and the first picture's transfer"""
    host = StaticHost(site)
    try:
        found = subprocess.run(
            [
                os.environ.get("TERRAVOX_NODE") or "node",
                ROOT / "tests" / "bench" / "view" / "drive.mjs",
                json.dumps({"url": host.url, "width": width, "height": height, **job}),
            ],
            stdout=subprocess.PIPE,
            text=True,
            check=True,
            timeout=LIMIT_S,
        ).stdout
    finally:
        host.stop()
    figures = json.loads(found)
    assert figures["errors"] == [], figures["errors"]
    # The page counts what it reads of the archive until the first picture; all else comes before.
    own = [sent for name, _, _, sent in host.log if name != "place.tvx"]
    first = figures["first"]
    first["requests"] += len(own)
    first["bytes"] += sum(own)
    return figures


def script_bytes(site):
    """Of the page and its scripts, compressed as hosts do."""
    files = [site / "index.html", *(site / "viewer").glob("*.js"), *(site / "viewer").glob("*.css")]
    return sum(len(gzip.compress(file.read_bytes(), 6)) for file in files)


def slope(samples, key):
    """Of the line of least squares through the samples, bytes a minute."""
    n = len(samples)
    mean_s = sum(sample["s"] for sample in samples) / n
    mean = sum(sample[key] for sample in samples) / n
    above = sum((sample["s"] - mean_s) * (sample[key] - mean) for sample in samples)
    return 60 * above / sum((sample["s"] - mean_s) ** 2 for sample in samples)


__all__ = [
    "browse",
    "demo_site",
    "noise_site",
    "render",
    "script_bytes",
    "site_views",
    "slope",
    "temporary_folder",
]

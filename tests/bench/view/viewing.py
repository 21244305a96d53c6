"""Shared parts of the scripts behind `terravox bench view/...`: sites, browsers, hosts."""

import gzip
import json
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "tests" / "e2e"), str(ROOT / "tests" / "bench")]

import site_views  # noqa: E402
from static_host import StaticHost  # noqa: E402
from support import binary, render, temporary_folder  # noqa: E402
from surveys import synthetic_survey  # noqa: E402

LIMIT_S = 3600


def run(*command):
    subprocess.run(
        [str(word) for word in command], check=True, stdout=subprocess.DEVNULL, timeout=LIMIT_S
    )


def demo_site():
    """The demo's square kilometre, a synthetic survey: a site that lasts as long as this process.

    Its archive lasts as long as the bench.
    """
    kept = pathlib.Path(os.environ.get("TERRAVOX_BENCH_SCRATCH") or temporary_folder())
    archive = kept / "view-demo.tvx"
    if not archive.exists():
        survey = synthetic_survey()
        run(binary("CONVERT"), survey, "--ortho", survey / "ortho", archive, "--quiet")
    site = temporary_folder() / "site"
    scene = ROOT / "config" / "scenes" / "demo.toml"
    run(binary("PUBLISH"), archive, site, "--no-preview", "--scene", scene, "--quiet")
    return site


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


__all__ = [
    "browse",
    "demo_site",
    "render",
    "script_bytes",
    "site_views",
    "temporary_folder",
]

"""What package managers are told to fetch: manifests, lock files, lists with hashes."""

import json
import subprocess

from support import ROOT

PACKAGES = [ROOT / "grabber", ROOT / "voxelserver" / "serve" / "page"]
REQUIREMENTS = sorted((ROOT / "config" / "setup" / "python").glob("*.txt"))


def tracked(*patterns):
    done = subprocess.run(
        ["git", "-C", ROOT, "ls-files", "--", *patterns],
        capture_output=True,
        text=True,
        check=False,
    )
    return [ROOT / line for line in done.stdout.splitlines()]


def manifest(folder, name):
    return json.loads((folder / name).read_text(encoding="utf-8"))


def locked(folder):
    """Packages of a lock file by their place, without the project itself."""
    return {
        place: about
        for place, about in manifest(folder, "package-lock.json")["packages"].items()
        if place
    }


def name_of(place):
    return place.split("node_modules/")[-1]

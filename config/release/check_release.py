#!/usr/bin/env python3
"""Prints what stands in the way of a release, a line each; nothing when there is nothing. Run by
`./terravox release`."""

import argparse
import json
import pathlib
import re
import subprocess
import sys

VERSION = r"[0-9]+\.[0-9]+\.[0-9]+"
# Where else than in CMakeLists.txt the version is written, and how it is found there. Everything
# else reads it from CMakeLists.txt.
PLACES = (
    ("config/cluster/kubernetes/frames.yaml", rf"image: terravox:({VERSION})"),
    ("config/cluster/kubernetes/pool.yaml", rf"image: terravox:({VERSION})"),
    ("docs/guide/install.md", rf"terravox[a-z-]*_({VERSION})_"),
)
MANIFESTS = ("grabber", "voxelserver/page")


def text_of(root, name):
    return (root / name).read_text(encoding="utf-8")


def project_version(root):
    found = re.search(
        rf"^project\(terravox VERSION ({VERSION})\s", text_of(root, "CMakeLists.txt"), re.M
    )
    if found is None:
        sys.exit("read the version: CMakeLists.txt has no project(terravox VERSION x.y.z")
    return found[1]


def other_versions(root):
    """@return place, version of all that have to agree"""
    for name, pattern in PLACES:
        for version in re.findall(pattern, text_of(root, name)) or ["none"]:
            yield name, version
    for folder in MANIFESTS:
        name = f"{folder}/package.json"
        yield name, json.loads(text_of(root, name))["version"]
        name = f"{folder}/package-lock.json"
        lock = json.loads(text_of(root, name))
        yield name, lock["version"]
        yield name, lock["packages"][""]["version"]


def wrong_versions(root, version):
    for place, found in other_versions(root):
        if found != version:
            yield f"{place} has version {found}; CMakeLists.txt has {version}"
    project = text_of(root, "raytracer/python/pyproject.toml")
    if 'dynamic = ["version"]' not in project or 'input = "../../CMakeLists.txt"' not in project:
        yield "raytracer/python/pyproject.toml does not read its version from CMakeLists.txt"
    control = text_of(root, "config/debian/control")
    if re.search(rf"{VERSION}(?!\S)", re.sub(r"(?m)^Standards-Version:.*$", "", control)):
        yield "config/debian/control names a version; it comes from CMakeLists.txt"


def wrong_changes(root, version):
    heading = re.search(r"(?m)^## (.*)$", text_of(root, "CHANGELOG.md"))
    found = heading[1] if heading else "nothing"
    if not re.fullmatch(rf"{re.escape(version)}, \d{{4}}-\d\d-\d\d", found):
        yield f"CHANGELOG.md begins with '{found}'; a release wants '{version}, YYYY-MM-DD'"


def changed_files(root):
    command = ["git", "-C", root, "status", "--porcelain"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    for line in done.stdout.splitlines():
        yield f"not committed: {line[3:]}"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("root", type=pathlib.Path, help="of the sources, a checkout of git")
    root = parser.parse_args().root
    version = project_version(root)
    for problem in (
        *wrong_versions(root, version),
        *wrong_changes(root, version),
        *changed_files(root),
    ):
        print(problem)


if __name__ == "__main__":
    main()

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
# How files of a release and the image are named, wherever that is written.
NAMES = (
    # terravox-data_0.1.0_all.deb, terravox-0.1.0.spdx.json, terravox:0.1.0
    re.compile(rf"\bterravox[a-z-]*[_:-]v?({VERSION})"),
    # In a manifest of Kubernetes; a tag that is no version, and none, would be the newest image.
    re.compile(r"(?m)^[ -]*image: *[\"']?(?:[^\s\"']*/)?terravox(?::([\w.-]*)|(?=[\s\"'@]|$))"),
)
# The library and its package have the first two numbers: libterravox0.1, libterravox.so.0.1
LIBRARY = re.compile(r"\blibterravox(?:\.so\.)?([0-9]+\.[0-9]+)\b")
# The changelog names what earlier versions were, and tests make versions up.
WITHOUT = ("CHANGELOG.md", "tests/")
MANIFESTS = ("grabber", "voxelserver/serve/page")


def text_of(root, name):
    return (root / name).read_text(encoding="utf-8")


def project_version(root):
    found = re.search(
        rf"^project\(terravox VERSION ({VERSION})\s", text_of(root, "CMakeLists.txt"), re.M
    )
    if found is None:
        sys.exit("read the version: CMakeLists.txt has no project(terravox VERSION x.y.z")
    return found[1]


def tracked(root):
    command = ["git", "-C", root, "ls-files", "-z"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return [name for name in done.stdout.split("\0") if name and (root / name).is_file()]


def versions_in(text):
    """@return the versions that a text names, by what each has to be: the whole version, or the
    first two numbers"""
    whole = {found for pattern in NAMES for found in pattern.findall(text)}
    return whole, set(LIBRARY.findall(text))


def wrong_names(root, version):
    minor = version.rpartition(".")[0]
    for name in tracked(root):
        if name.startswith(WITHOUT):
            continue
        try:
            whole, library = versions_in(text_of(root, name))
        except UnicodeDecodeError:
            continue
        for found in sorted((whole - {version}) | (library - {minor})):
            yield f"{name} has version {found or 'none'}; CMakeLists.txt has {version}"


def manifest_versions(root):
    """@return place, version of all that have to agree"""
    for folder in MANIFESTS:
        name = f"{folder}/package.json"
        yield name, json.loads(text_of(root, name))["version"]
        name = f"{folder}/package-lock.json"
        lock = json.loads(text_of(root, name))
        yield name, lock["version"]
        yield name, lock["packages"][""]["version"]


def wrong_versions(root, version):
    yield from wrong_names(root, version)
    for place, found in manifest_versions(root):
        if found != version:
            yield f"{place} has version {found}; CMakeLists.txt has {version}"
    project = text_of(root, "raytracer/apps/python/pyproject.toml")
    if 'dynamic = ["version"]' not in project or 'input = "../../../CMakeLists.txt"' not in project:
        yield "raytracer/apps/python/pyproject.toml does not read its version from CMakeLists.txt"
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

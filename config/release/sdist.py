#!/usr/bin/env python3
"""Writes the source archive of the Python package: what `pip` builds a wheel of where there is
none. Run by `./terravox package sdist`.

The Python package is one folder of this project and is compiled with the rest, so the archive is
made of the checkout: its pyproject.toml comes to the top, and the sources of LASzip come along,
which Debian does not have.
"""

import argparse
import gzip
import io
import pathlib
import subprocess
import tarfile
import tomllib

# Of what git knows.
SOURCES = (
    "CHANGELOG.md",
    "CMakeLists.txt",
    "LICENSE",
    "THIRD_PARTY.md",
    "common",
    "config",
    "raytracer",
    "voxelserver",
)
# Has no part in a wheel, and needs Node.js: its list for CMake says what there is instead. Others
# include its headers.
PAGE = "voxelserver/serve/page"
OF_PAGE = (".hpp", "/CMakeLists.txt")
LASZIP = "build/deps/laszip"
PROJECT = "raytracer/apps/python/pyproject.toml"
# What pyproject.toml says of the places of others, there and at the top.
PLACES = (
    ('cmake.source-dir = "../../.."', 'cmake.source-dir = "."'),
    ('wheel.packages = ["terravox"]', 'wheel.packages = ["raytracer/apps/python/terravox"]'),
    ('input = "../../../CMakeLists.txt"', 'input = "CMakeLists.txt"'),
)


def tracked(root):
    command = ["git", "-C", root, "ls-files", "-z", "--", *SOURCES]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    names = done.stdout.split("\0")
    return [name for name in names if is_packed(name) and (root / name).is_file()]


def is_packed(name):
    if name.startswith(f"{PAGE}/"):
        return name.endswith(OF_PAGE)
    return name not in ("", PROJECT)


def project_at_top(root):
    text = (root / PROJECT).read_text(encoding="utf-8")
    for there, here in PLACES:
        if text.count(there) != 1:
            raise SystemExit(f"write the source archive: {PROJECT} has not one line '{there}'")
        text = text.replace(there, here)
    return text


def metadata(project, version):
    """Ref: "Core metadata specifications", Python Packaging User Guide."""
    about = tomllib.loads(project)["project"]
    lines = [
        "Metadata-Version: 2.1",
        f"Name: {about['name']}",
        f"Version: {version}",
        f"Summary: {about['description']}",
        f"License: {about['license']['text']}",
        f"Requires-Python: {about['requires-python']}",
        *(f"Classifier: {each}" for each in about["classifiers"]),
        *(f"Requires-Dist: {each}" for each in about["dependencies"]),
    ]
    return "\n".join(lines) + "\n"


def contents(root, version):
    """@return the bytes of each file by its name"""
    names = tracked(root)
    names += [str(file.relative_to(root)) for file in (root / LASZIP).rglob("*") if file.is_file()]
    found = {name: (root / name).read_bytes() for name in names}
    project = project_at_top(root)
    found["pyproject.toml"] = project.encode()
    found["PKG-INFO"] = metadata(project, version).encode()
    return found


def write(file, folder, files, time):
    with (
        file.open("wb") as raw,
        gzip.GzipFile("", "wb", 9, raw, mtime=0) as packed,
        tarfile.TarFile(mode="w", fileobj=packed, format=tarfile.PAX_FORMAT) as archive,
    ):
        for name, data in sorted(files.items()):
            entry = tarfile.TarInfo(f"{folder}/{name}")
            entry.size = len(data)
            entry.mode = 0o644
            entry.mtime = time
            archive.addfile(entry, io.BytesIO(data))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("root", type=pathlib.Path, help="of the sources, a checkout of git")
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True)
    parser.add_argument("--version", required=True)
    parser.add_argument("--time", type=int, required=True, help="seconds since 1970")
    args = parser.parse_args()
    write(args.output, f"terravox-{args.version}", contents(args.root, args.version), args.time)


if __name__ == "__main__":
    main()

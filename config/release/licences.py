#!/usr/bin/env python3
"""Writes one file with the licences of all that is in the files of a release: THIRD_PARTY.md, the
lists that packages bring, and what Debian says of the libraries in wheels. Run by `./terravox
release`."""

import argparse
import pathlib
import re
import subprocess
import sys

import contents


def copyright_of(library):
    """@param library libzip-0a1b2c3d.so.5.5 @return name of the Debian package here, its file of
    copyrights"""
    name = re.sub(r"-[0-9a-f]{8}(?=\.so)", "", library)
    done = subprocess.run(
        ["dpkg-query", "--search", f"*/{name}"], capture_output=True, text=True, check=False
    )
    packages = {line.partition(":")[0] for line in done.stdout.splitlines()}
    if not packages:
        sys.exit(f"write licences: no Debian package of this machine has {name}")
    package = min(packages)
    file = pathlib.Path("/usr/share/doc") / package / "copyright"
    return package, file.read_text(encoding="utf-8")


def parts(files):
    """@return heading, text of each part but the first"""
    found = {}
    for file in files:
        if file.suffix == ".deb":
            for name, text in contents.deb_files(
                file, ("/licences.txt", "/licences-page.txt")
            ).items():
                found[name.removeprefix(".")] = text.decode()
        elif file.suffix == ".whl":
            for library in contents.wheel_libraries(file):
                package, text = copyright_of(library)
                found[f"{package} (Debian's copyright file), in wheels"] = text
    return sorted(found.items())


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", type=pathlib.Path, nargs="+", help="of the release")
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True)
    parser.add_argument("--third-party", type=pathlib.Path, required=True, help="THIRD_PARTY.md")
    args = parser.parse_args()
    texts = [args.third_party.read_text(encoding="utf-8")]
    for heading, text in parts(args.files):
        texts.append(f"\n{'=' * 78}\n{heading}\n{'=' * 78}\n\n{text.rstrip()}\n")
    args.output.write_text("".join(texts), encoding="utf-8")


if __name__ == "__main__":
    main()

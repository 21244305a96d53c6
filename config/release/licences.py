#!/usr/bin/env python3
"""Writes one file with the licences of all that is in the files of a release: THIRD_PARTY.md, the
lists that packages bring, the texts of what is compiled in, and what Debian says of the libraries
in wheels. Run by `./terravox release`."""

import argparse
import pathlib
import re
import subprocess
import sys

import contents

# What each Debian package has as its file `copyright`: of some of what is compiled in, Debian's own
# files name no licence (the font in Dear ImGui).
COPYRIGHT = pathlib.Path(__file__).resolve().parents[1] / "debian" / "copyright"
# Where the build has what Debian has no package of: files in the folder of --deps, and the part of
# each that is the licence. What others have written has its licence in a comment of the sources.
ALL = r".*"
FETCHED = {
    "LASzip": (
        ("laszip/AUTHORS.txt", ALL),
        ("laszip/COPYING.txt", ALL),
        (
            "laszip/src/arithmeticdecoder.cpp",
            r"// Copyright \(c\) \d+ by Amir Said.*?SUCH DAMAGE\.",
        ),
    ),
    "nanobind": (
        ("nanobind/nanobind-*.dist-info/licenses/LICENSE", ALL),
        ("nanobind/nanobind/ext/robin_map/include/tsl/robin_map.h", r"\A/\*.*?\*/"),
    ),
}


def copyright_file(package):
    """@return Debian's file of copyrights"""
    file = pathlib.Path("/usr/share/doc") / package / "copyright"
    if not file.is_file():
        sys.exit(f"write licences: {file} is missing; ./terravox deps installs {package}")
    return file.read_text(encoding="utf-8")


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
    return package, copyright_file(package)


def fetched_licence(name, folder):
    """@param folder build/deps @return what the sources say that were fetched there"""
    texts = []
    for place, part in FETCHED[name]:
        found = sorted(folder.glob(place))
        if len(found) != 1:
            sys.exit(
                f"write licences: {folder / place} of {name}: {len(found)} files; allowed: one "
                "(./terravox deps fetches it)"
            )
        licence = re.search(part, found[0].read_text(encoding="utf-8"), re.S)
        if licence is None:
            sys.exit(f"write licences: {found[0]} of {name} has no licence where it was")
        texts.append(licence[0].strip("\n"))
    return "\n\n".join(texts)


def compiled_in(tables, files, folder):
    """@return heading, text of each part that is compiled into one of the files"""
    programs = set().union(*map(contents.programs_in, files))
    rows = [(row[0], row[3]) for row in contents.compiled_in(tables, programs)]
    if any(file.suffix == ".whl" for file in files):
        rows += [(row[0], row[3]) for row in contents.compiled_into_wheels(tables)]
    for name, package in rows:
        if package:
            yield f"{name} (Debian's copyright file), compiled in", copyright_file(package)
        else:
            text = fetched_licence(name.partition(", ")[0], folder)
            yield f"{name} (its sources), compiled in", text


def brought(files):
    """@return heading, text of each part that packages and wheels bring as files"""
    if any(file.suffix == ".deb" for file in files):
        yield "copyright, in Debian packages", COPYRIGHT.read_text(encoding="utf-8")
    for file in files:
        if file.suffix == ".deb":
            endings = ("/licences.txt", "/licences-page.txt")
            for name, text in contents.deb_files(file, endings).items():
                yield name.removeprefix("."), text.decode()
        elif file.suffix == ".whl":
            for library in contents.wheel_libraries(file):
                package, text = copyright_of(library)
                yield f"{package} (Debian's copyright file), in wheels", text


def text_of(files, third_party, deps):
    """@param third_party THIRD_PARTY.md @param deps sources that were fetched: build/deps"""
    texts = [third_party.read_text(encoding="utf-8")]
    tables = contents.third_party(texts[0])
    parts = dict(compiled_in(tables, files, deps)) | dict(brought(files))
    for heading, text in sorted(parts.items()):
        texts.append(f"\n{'=' * 78}\n{heading}\n{'=' * 78}\n\n{text.rstrip()}\n")
    return "".join(texts)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", type=pathlib.Path, nargs="+", help="of the release")
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True)
    parser.add_argument("--third-party", type=pathlib.Path, required=True, help="THIRD_PARTY.md")
    parser.add_argument(
        "--deps", type=pathlib.Path, required=True, help="sources that were fetched: build/deps"
    )
    args = parser.parse_args()
    text = text_of(args.files, args.third_party, args.deps)
    args.output.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()

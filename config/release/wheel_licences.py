#!/usr/bin/env python3
"""Puts the licences of all that is in a wheel into it, since whoever gets it must get them, too.
Run by `./terravox package wheel`."""

import argparse
import base64
import hashlib
import pathlib
import zipfile

import licences

PLACE = "terravox/licences/third-party.txt"


def record_line(name, data):
    """Ref: "Recording installed projects" (PyPA)."""
    digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
    return f"{name},sha256={digest},{len(data)}\n"


def add_file(wheel, to, name, data):
    """Writes a copy of a wheel with one more file, of the time of the wheel's own list."""
    with zipfile.ZipFile(wheel) as old, zipfile.ZipFile(to, "w", zipfile.ZIP_DEFLATED) as new:
        (record,) = (each for each in old.infolist() if each.filename.endswith("/RECORD"))
        for each in old.infolist():
            if each is not record:
                new.writestr(each, old.read(each))
        about = zipfile.ZipInfo(name, record.date_time)
        about.external_attr = record.external_attr
        about.compress_type = zipfile.ZIP_DEFLATED
        new.writestr(about, data)
        # Its own line is the last one.
        lines = old.read(record).decode()
        new.writestr(record, record_line(name, data) + lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("wheel", type=pathlib.Path)
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True, help="folder")
    parser.add_argument("--third-party", type=pathlib.Path, required=True, help="THIRD_PARTY.md")
    parser.add_argument(
        "--deps", type=pathlib.Path, required=True, help="sources that were fetched: build/deps"
    )
    args = parser.parse_args()
    text = licences.text_of([args.wheel], args.third_party, args.deps)
    part = args.output / f".{args.wheel.name}.part"
    add_file(args.wheel, part, PLACE, text.encode())
    part.rename(args.output / args.wheel.name)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Writes what the files of a release are made of, as SPDX 2.3 (JSON). Run by `./terravox release`.

It reads what is in them: the dependencies of Debian packages, the packages of npm whose licences
they bring, the libraries in wheels, the Debian packages in an image. THIRD_PARTY.md names what was
compiled in."""

import argparse
import datetime
import pathlib
import re
import urllib.parse

import contents
from spdx import Document


def purl(kind, name, version, **qualifiers):
    """Ref: "Package URL specification" (purl-spec), ECMA-427."""
    text = f"pkg:{kind}/{urllib.parse.quote(name)}@{urllib.parse.quote(version)}"
    return text + ("?" + urllib.parse.urlencode(qualifiers) if qualifiers else "")


class Release:
    def __init__(self, version, created, third_party):
        self.document = Document(f"terravox-{version}", created)
        self._version = version
        self._tables = third_party
        self._project = self.document.add("terravox", version, licence="Apache-2.0")

    def add(self, path):
        """A file of the release, with all that is in it."""
        key = self.document.add(
            path.name, self._version, licence="Apache-2.0", file=path.read_bytes()
        )
        self.document.describe(key)
        self.document.relate(key, "GENERATED_FROM", self._project)
        if path.suffix == ".deb":
            self._add_deb(key, path)
        elif path.suffix == ".whl":
            self._add_wheel(key, path)
        elif path.name.endswith(".oci.tar"):
            self._add_image(key, path)

    def _add_compiled(self, key, path):
        programs = contents.programs_in(path)
        for name, licence, version, *_ in contents.compiled_in(self._tables, programs):
            part = self.document.add(name, version, licence=licence)
            self.document.relate(key, "STATIC_LINK", part)

    def _add_deb(self, key, path):
        for name, version in contents.deb_depends(path):
            part = self.document.add(name, comment=f"version {version}" if version else "")
            self.document.relate(key, "DEPENDS_ON", part)
        self._add_compiled(key, path)
        for text in contents.deb_files(path, ("/licences.txt", "/licences-page.txt")).values():
            for name, version, licence in contents.bundled(text.decode()):
                part = self.document.add(
                    name, version, licence=licence, purl=purl("npm", name, version)
                )
                self.document.relate(key, "CONTAINS", part)

    def _add_wheel(self, key, path):
        self._add_compiled(key, path)
        for name, licence, *_ in contents.compiled_into_wheels(self._tables):
            part = self.document.add(name, licence=licence)
            self.document.relate(key, "STATIC_LINK", part)
        for name, data in sorted(contents.wheel_libraries(path).items()):
            part = self.document.add(name, licence=self._licence_of(name), file=data)
            self.document.relate(key, "CONTAINS", part)

    def _licence_of(self, library):
        """@param library libzip-0a1b2c3d.so.5.5, with a hash that auditwheel has put in"""
        stem = re.sub(r"(-[0-9a-f]{8})?\.so.*", "", library)
        for name, _, licence, *_ in self._tables["Shared libraries"]:
            if stem == name or stem.startswith(name + "-"):
                return licence
        return ""

    def _add_image(self, key, path):
        for fields in contents.image_packages(path):
            name, version = fields["Package"], fields["Version"]
            locator = purl("deb", f"debian/{name}", version, arch=fields["Architecture"])
            part = self.document.add(name, version, purl=locator)
            self.document.relate(key, "CONTAINS", part)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", type=pathlib.Path, nargs="+", help="of the release")
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True)
    parser.add_argument("--version", required=True)
    parser.add_argument("--time", type=int, required=True, help="seconds since 1970")
    parser.add_argument("--third-party", type=pathlib.Path, required=True, help="THIRD_PARTY.md")
    args = parser.parse_args()
    created = datetime.datetime.fromtimestamp(args.time, datetime.UTC)
    rows = contents.third_party(args.third_party.read_text(encoding="utf-8"))
    release = Release(args.version, created.strftime("%Y-%m-%dT%H:%M:%SZ"), rows)
    for file in sorted(args.files):
        release.add(file)
    args.output.write_text(release.document.text(), encoding="utf-8")


if __name__ == "__main__":
    main()

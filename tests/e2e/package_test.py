#!/usr/bin/env python3
"""Packages for Debian, and the services in them.

With --long a package is made twice, checked by lintian, and installed, used, upgraded and purged in
a fresh Debian (debootstrap; needs root and the network that apt has).
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

from support import ROOT, Case, Run, binary, survey, temporary_folder

LONG = "--long" in sys.argv
UNITS = sorted((ROOT / "config" / "systemd").glob("*.service"))
MAX_EXPOSURE = 3.0
APT = pathlib.Path("/etc/apt")
INSTALL_S = 3000
PICTURE = ("--size", "64x36", "--samples", "1", "--cache", "none", "--quiet")
MAINTAINER = {"DEBFULLNAME": "Terravox", "DEBEMAIL": "packages@example.org"}


class Services(Case):
    def test_they_are_confined(self):
        if shutil.which("systemd-analyze") is None:
            print("left out: systemd-analyze is not installed", file=sys.stderr)
            return
        self.assertEqual(
            [unit.name for unit in UNITS], ["terravox-serve.service", "terravox-worker.service"]
        )
        for unit in UNITS:
            with self.subTest(unit.name):
                run = Run(["systemd-analyze", "security", "--offline=true", unit])
                self.assertDone(run)
                exposure = re.search(r"exposure level for \S+ ([0-9.]+)", run.out)
                self.assertLessEqual(float(exposure[1]), MAX_EXPOSURE)

    def test_they_start_the_installed_command(self):
        for unit in UNITS:
            text = unit.read_text(encoding="utf-8")
            self.assertRegex(text, r"(?m)^ExecStart=/usr/bin/terravox (serve|worker) ")


class Usage(Case):
    def package(self, *arguments):
        environment = {"TERRAVOX_NO_BUILD": "1"}
        return Run([ROOT / "terravox", "package", *arguments], environment=environment)

    def test_what_it_does_not_know_is_refused(self):
        self.assertRefused(self.package(), 2, "''", "deb")
        self.assertRefused(self.package("rpm", "-o", "x"), 2, "'rpm'", "deb")
        self.assertRefused(self.package("deb"), 2, "-o FOLDER")
        self.assertRefused(self.package("deb", "-o", "x", "y"), 2, "'y'")
        self.assertDone(self.package("--help"))


def make_package(epoch=None):
    environment = {"TERRAVOX_NO_BUILD": "1", **MAINTAINER}
    if epoch is not None:
        environment["SOURCE_DATE_EPOCH"] = epoch
    folder = temporary_folder() / "packages"
    run = Run(
        [ROOT / "terravox", "package", "deb", "-o", folder],
        environment=environment,
        timeout_s=INSTALL_S,
    )
    assert run.code == 0, run
    return pathlib.Path(run.out.strip())


def mirror():
    """@return the first address that apt has packages from, and the name of the release"""
    run = Run(["apt-get", "indextargets", "--format", "$(SITE) $(RELEASE)"])
    site, release = next(line.split() for line in run.out.splitlines() if line.strip())
    return site, release


class Root:
    """A fresh Debian with the host's settings of apt."""

    def __init__(self):
        self.folder = temporary_folder() / "root"
        site, release = mirror()
        words = ["debootstrap", "--variant=minbase", release, self.folder, site]
        run = Run(words, timeout_s=INSTALL_S)
        assert run.code == 0, run
        for name in ("sources.list", "sources.list.d", "apt.conf.d", "trusted.gpg.d"):
            self._copy(APT / name)
        for name in ("/usr/share/keyrings", "/etc/hosts", "/etc/resolv.conf"):
            self._copy(pathlib.Path(name))
        # Sources of others than Debian need what is not in this root.
        for file in (self.folder / "etc/apt/sources.list.d").iterdir():
            if site not in file.read_text(encoding="utf-8"):
                file.unlink()

    def _copy(self, path):
        to = self.folder / path.relative_to("/")
        if path.is_dir():
            shutil.copytree(path, to, dirs_exist_ok=True)
        elif path.exists():
            shutil.copy(path, to)

    def run(self, *words):
        proc = f"--mount-proc={self.folder}/proc"
        command = ["unshare", "--mount", "--pid", "--fork", proc, "chroot", self.folder]
        environment = {"DEBIAN_FRONTEND": "noninteractive", "HOME": "/root"}
        return Run([*command, *words], environment=environment, timeout_s=INSTALL_S)

    def files(self):
        """What is installed anywhere but in the records of packages."""
        left_out = (
            "proc",
            "sys",
            "dev",
            "var/lib/dpkg",
            "var/lib/apt",
            "var/cache/apt",
            "var/log",
            "tmp",
        )
        found = set()
        for path in self.folder.rglob("*"):
            name = str(path.relative_to(self.folder))
            if "terravox" in name and not name.startswith(left_out):
                found.add(name)
        return found


@unittest.skipUnless(LONG, "with --long")
class Package(Case):
    def test_the_same_commit_makes_the_same_bytes(self):
        first = make_package().read_bytes()
        self.assertEqual(first, make_package().read_bytes())
        self.assertNotEqual(first, make_package(epoch="1000000000").read_bytes())

    def test_lintian_has_no_errors(self):
        if shutil.which("lintian") is None:
            print("left out: lintian is not installed", file=sys.stderr)
            return
        run = Run(["lintian", "--allow-root", "--fail-on", "error", make_package()])
        self.assertDone(run)

    def test_it_is_installed_used_upgraded_and_purged(self):
        if shutil.which("debootstrap") is None or os.geteuid() != 0:
            print("left out: debootstrap is not installed, or not root", file=sys.stderr)
            return
        root = Root()
        before = root.files()
        package = make_package()
        shutil.copy(package, root.folder / "tmp" / "terravox.deb")
        shutil.copytree(survey(), root.folder / "tmp" / "survey")
        install = ["apt-get", "--yes", "--no-install-recommends", "install", "/tmp/terravox.deb"]
        self.assertDone(root.run("apt-get", "update"))
        self.assertDone(root.run(*install))
        words = ["/tmp/survey", "--ortho", "/tmp/survey/ortho", *PICTURE, "-o", "/tmp/p.png"]
        self.assertDone(root.run("terravox", "render", *words))
        ours = temporary_folder() / "p.png"
        words = [survey(), "--ortho", survey() / "ortho", *PICTURE, "-o", ours]
        self.assertDone(Run([binary("RAYTRACER"), "render", *words]))
        self.assertEqual(ours.read_bytes(), (root.folder / "tmp" / "p.png").read_bytes())
        self.check_upgrade(root, package)
        self.assertDone(root.run("apt-get", "--yes", "purge", "terravox"))
        self.assertEqual(root.files() - before, set())

    def check_upgrade(self, root, package):
        """A setting of the user stays when a newer version comes."""
        settings = root.folder / "etc" / "terravox" / "serve.env"
        settings.write_text('TERRAVOX_SERVE="generated:7"\n', encoding="utf-8")
        (root.folder / "etc" / "terravox" / "token").write_text("secret\n", encoding="utf-8")
        work = temporary_folder() / "newer"
        subprocess.run(["dpkg-deb", "--raw-extract", package, work], check=True)
        control = work / "DEBIAN" / "control"
        text = control.read_text(encoding="utf-8")
        control.write_text(re.sub(r"(?m)^Version: .*", "Version: 99", text), encoding="utf-8")
        newer = root.folder / "tmp" / "newer.deb"
        subprocess.run(["dpkg-deb", "--root-owner-group", "--build", work, newer], check=True)
        self.assertDone(root.run("dpkg", "--install", "/tmp/newer.deb"))
        self.assertIn("generated:7", settings.read_text(encoding="utf-8"))
        self.assertDone(root.run("terravox", "help"))


if __name__ == "__main__":
    unittest.main(argv=[a for a in sys.argv if a != "--long"])

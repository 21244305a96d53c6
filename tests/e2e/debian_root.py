"""A fresh Debian in a folder, to install packages in. Needs root, and the network that apt has."""

import os
import pathlib
import shutil

from support import Run, temporary_folder

APT = pathlib.Path("/etc/apt")
INSTALL_S = 3000
# What the kernel starts programs of 64-bit ARM with, if it is another processor's.
BINFMT_ARM64 = pathlib.Path("/proc/sys/fs/binfmt_misc/qemu-aarch64")


def missing(architecture=""):
    """@param architecture as Debian names it, if not that of this machine
    @return what this machine lacks to make one, or nothing"""
    if shutil.which("debootstrap") is None:
        return "debootstrap is not installed"
    if architecture == "arm64" and not BINFMT_ARM64.exists():
        return f"{BINFMT_ARM64} is missing (Debian packages qemu-user-static, binfmt-support)"
    return "" if os.geteuid() == 0 else "not root"


def mirror():
    """@return the first address that apt has packages from, and the name of the release"""
    run = Run(["apt-get", "indextargets", "--format", "$(SITE) $(RELEASE)"])
    site, release = next(line.split() for line in run.out.splitlines() if line.strip())
    return site, release


class Root:
    """A fresh Debian with the host's settings of apt."""

    def __init__(self, architecture=""):
        """@param architecture as Debian names it, if not that of this machine"""
        self.folder = temporary_folder() / "root"
        site, release = mirror()
        words = ["debootstrap", "--variant=minbase", release, self.folder, site]
        if architecture:
            words.insert(1, f"--arch={architecture}")
        Run(words, timeout_s=INSTALL_S).done()
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

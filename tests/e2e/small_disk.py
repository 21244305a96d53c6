"""A disk of a few pages: a tmpfs of limited size, in a mount namespace of its own.

It needs no root and ends with the test.
"""

import os
import pathlib
import subprocess

from support import HANGS_S, temporary_folder

PAGE_BYTES = os.sysconf("SC_PAGE_SIZE")  # which tmpfs counts in
# The second as root where user namespaces are forbidden, as in many containers.
_WAYS = ((["--user", "--map-root-user"], ["--user", "--preserve-credentials"]), ([], []))
_HOLD = 'mount -t tmpfs -o size="$1" none "$2" && echo mounted && exec cat'


def why_not():
    """Why there can be no such disk here; empty: there can."""
    try:
        with SmallDisk(1):
            return ""
    except OSError as e:
        return str(e)


class SmallDisk:
    """A folder on a disk of its own, for as long as the block lasts.

    `folder` is the path for programs that are started with the command `within`; this process sees
    the same files below `seen`.
    """

    def __init__(self, free_pages):
        """@throws OSError where no namespace is allowed"""
        self._mounted = temporary_folder()
        said = []
        for unshare, nsenter in _WAYS:  # noqa: B007, nsenter is used after the loop
            size = str((free_pages + 1) * PAGE_BYTES)
            shell = ["sh", "-c", _HOLD, "sh", size, self._mounted]
            command = ["unshare", *unshare, "--mount", *shell]
            pipe = subprocess.PIPE
            self._holder = subprocess.Popen(
                command, stdin=pipe, stdout=pipe, stderr=pipe, text=True
            )
            if self._holder.stdout.readline() == "mounted\n":
                break
            said.append(self._end())
        else:
            raise OSError("no mount namespace: " + "; ".join(said))
        self.within = ["nsenter", "--target", str(self._holder.pid), *nsenter, "--mount"]
        self.folder = self._mounted / "out"
        self.seen = pathlib.Path(f"/proc/{self._holder.pid}/root") / self.folder.relative_to("/")
        self.seen.mkdir()
        # One page is always taken: a limit of 0 would be none.
        (self.seen.parent / "taken").write_bytes(bytes(PAGE_BYTES))

    def leave(self, free_pages):
        """From now on so much is free; it takes no memory before it is filled."""
        was = os.statvfs(self.seen)
        limit = was.f_blocks - was.f_bfree + free_pages
        options = f"remount,size={limit * PAGE_BYTES}"
        command = ["mount", "-t", "tmpfs", "-o", options, "none", self._mounted]
        subprocess.run([*self.within, *command], check=True, timeout=HANGS_S)

    def _end(self):
        self._holder.kill()
        return self._holder.communicate()[1].strip()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._end()

"""Stops one thread of a process while all others go on: a hung render thread, seen from outside."""

import ctypes
import os
import pathlib
import time

_LIBC = ctypes.CDLL(None, use_errno=True)
_LIBC.ptrace.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]
_SEIZE = 0x4206
_INTERRUPT = 0x4207
_DETACH = 17
_WALL = 0x40000000


def busiest_thread(pid, seconds=0.5):
    """@return the thread of a process with the most CPU time for a while: one that traces"""

    def ticks():
        out = {}
        for thread in pathlib.Path(f"/proc/{pid}/task").iterdir():
            fields = (thread / "stat").read_text().rsplit(")", 1)[1].split()
            out[int(thread.name)] = int(fields[11]) + int(fields[12])
        return out

    before = ticks()
    time.sleep(seconds)
    return max(((now - before.get(thread, 0), thread) for thread, now in ticks().items()))[1]


class Halted:
    """Halts a thread for as long as the block lasts.

    The block must be left on the thread that entered it: the kernel allows one tracer.
    """

    def __init__(self, thread):
        self._thread = thread

    def _ptrace(self, request):
        if _LIBC.ptrace(request, self._thread, None, None) != 0:
            raise OSError(
                ctypes.get_errno(),
                f"ptrace of thread {self._thread}: {os.strerror(ctypes.get_errno())}",
            )

    def __enter__(self):
        self._ptrace(_SEIZE)
        self._ptrace(_INTERRUPT)
        os.waitpid(self._thread, _WALL)
        return self

    def __exit__(self, *_):
        self._ptrace(_DETACH)

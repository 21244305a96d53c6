"""Events of a program of the farm with their times, and the fate of bands that a worker held.

Read from `render --log debug`.
"""

import bisect
import math
import re
import threading
import time
from typing import NamedTuple

_BAND = re.compile(
    r"(lease|answer): tile (\d+) rows (\d+) to (\d+) step (\d+) sample (\d+) (?:to|of) (\S.*)$"
)


class Watch:
    """Lines of a stream with the time of each, read as they come. Thread-safe."""

    def __init__(self, stream):
        self._stream = stream
        self._changed = threading.Condition()
        self._times = []
        self._lines = []
        self._ended = False
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def _read(self):
        for line in self._stream:
            now = time.monotonic()
            with self._changed:
                self._times.append(now)
                self._lines.append(line.rstrip("\n"))
                self._changed.notify_all()
        with self._changed:
            self._ended = True
            self._changed.notify_all()
        self._stream.close()

    def join(self):
        self._thread.join(30)

    def text(self):
        with self._changed:
            return "\n".join(line for line in self._lines if not _BAND.search(line))

    def look(self, pattern, after=0.0):
        """@return (when, match) of the first line since `after`, or None"""
        with self._changed:
            return self._look(re.compile(pattern), bisect.bisect_left(self._times, after))

    def _look(self, pattern, at):
        for i in range(at, len(self._lines)):
            found = pattern.search(self._lines[i])
            if found:
                return self._times[i], found
        return None

    def saw(self, pattern, timeout_s, after=0.0):
        """Waits for a line. @return (when, match) @throws RuntimeError"""
        return self.saw_times(pattern, 1, timeout_s, after)

    def saw_times(self, pattern, count, timeout_s, after=0.0):
        """Waits for the count-th line of that kind. @return (when, match) of it"""
        compiled = re.compile(pattern)
        end = time.monotonic() + timeout_s
        with self._changed:
            at = bisect.bisect_left(self._times, after)
            left = count
            while True:
                for i in range(at, len(self._lines)):
                    found = compiled.search(self._lines[i])
                    left -= found is not None
                    if left == 0:
                        return self._times[i], found
                at = len(self._lines)
                wait = end - time.monotonic()
                if self._ended or wait <= 0:
                    said = [line for line in self._lines if not _BAND.search(line)]
                    raise RuntimeError(
                        f"no line with {pattern!r} ({count - left} of {count}) "
                        f"within {timeout_s} s: {said[-8:]}"
                    )
                self._changed.wait(wait)

    def events(self):
        """Leases and answers so far, in order."""
        out = []
        with self._changed:
            lines = list(zip(self._times, self._lines))
        for when, line in lines:
            found = _BAND.search(line)
            if found:
                kind, *numbers, worker = found.groups()
                out.append(Event(when, kind, Band(*(int(n) for n in numbers)), worker))
        return out


class Band(NamedTuple):
    tile: int
    y0: int
    y1: int
    step: int
    sample: int

    def overlaps(self, other):
        return (
            (self.tile, self.step, self.sample) == (other.tile, other.step, other.sample)
            and self.y0 < other.y1
            and other.y0 < self.y1
        )


class Event(NamedTuple):
    when: float
    kind: str
    band: Band
    worker: str


CHECKS = "checks"  # of the coordinator itself, which makes some bands again


def held(events, worker, at):
    """@return bands that only `worker` had at that time, and that no worker had answered"""
    open_bands = {}
    for e in events:
        if e.when > at:
            break
        if e.worker == CHECKS:
            continue
        if e.kind == "lease":
            open_bands.setdefault(e.band, set()).add(e.worker)
        else:
            open_bands.pop(e.band, None)
    return [band for band, holders in open_bands.items() if holders == {worker}]


class Fate(NamedTuple):
    band: Band
    answered_s: float | None  # by its holder, all the same
    leased_s: float | None  # some of its rows, to another worker


def fates(events, worker, at):
    """@return the fate of the bands that `worker` held, in seconds since then"""
    out = []
    for band in held(events, worker, at):
        later = [e for e in events if e.when > at and e.worker != CHECKS and e.band.overlaps(band)]
        answered = next(
            (e.when - at for e in later if e.kind == "answer" and e.worker == worker), None
        )
        leased = next(
            (e.when - at for e in later if e.kind == "lease" and e.worker != worker), None
        )
        out.append(Fate(band, answered, leased))
    return out


def lease_delays_s(events, worker, at):
    """For each band lost with `worker`: seconds until rows of it were leased to another worker.

    A band that was never leased again: infinity.
    """
    out = []
    for fate in fates(events, worker, at):
        if fate.answered_s is not None and (
            fate.leased_s is None or fate.answered_s < fate.leased_s
        ):
            continue  # its answer was on the way
        out.append(float("inf") if fate.leased_s is None else fate.leased_s)
    return out


def quantile(values, share):
    """The smallest value that at least that share of them does not exceed."""
    return sorted(values)[max(0, math.ceil(share * len(values)) - 1)]

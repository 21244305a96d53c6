"""Many readers of a box archive over HTTP, which ask as ours do: by ranges, all of one state.

Each reader is a coroutine with a connection of its own. It opens the archive (its beginning, then
the root of the index), reads some parts, and starts again; ours end where the archive has changed.
Every part is compared with the bytes of the state that the beginning was of.
"""

import asyncio
import dataclasses
import random
import shutil
import struct

from support import HANGS_S, make, make_survey

HEAD_BYTES = 16 << 10
MAX_PART_BYTES = 64 << 10
PARTS = 8  # of an opened archive
# Addresses of this machine that readers take turns to come from: fronts limit those of one address.
SOURCES = 20
ATTEMPTS = 5
FIRST_WAIT_S = 0.25
OPTIONS = ["--voxel", "0.5", "--cache", "none", "--quiet", "--steps=-material_guesses"]


def two_states(folder, squares, square_m, number):
    """An archive of made-up squares, and the one after a square was flown again.

    @param number of the square: not the one with the lowest place of all, as rock reaches down to
    that everywhere
    @return the archive, the two changes that lead to and fro, and the bytes of both states
    """
    flights = {density: folder / f"flight{density}" for density in (2, 3)}
    for density, flight in flights.items():
        make_survey(flight, squares, square_m, density)
    name = sorted(file.stem for file in flights[2].glob("*.laz"))[number]
    first, second = folder / "first.tvx", folder / "second.tvx"
    changes = [folder / "to.tvx", folder / "back.tvx"]
    make("CONVERT", flights[2], first, *OPTIONS)
    make("CONVERT", flights[2], changes[1], *OPTIONS, "--squares", name)
    shutil.copy(flights[3] / f"{name}.laz", flights[2])
    make("CONVERT", flights[2], second, *OPTIONS)
    make("CONVERT", flights[2], changes[0], *OPTIONS, "--squares", name)
    return first, changes, [first.read_bytes(), second.read_bytes()]


@dataclasses.dataclass
class Counts:
    opened: int = 0  # the beginning and the root were read
    parts: int = 0
    changed: int = 0  # the archive was another one, and the reader started again
    refused: int = 0  # 429, 502, 503 or 504, and the reader waited as long as it was told to
    reconnected: int = 0  # a kept connection was closed between two requests
    lost: int = 0  # a connection was closed instead of a reply, and the reader waited
    bytes: int = 0
    states: set = dataclasses.field(default_factory=set)  # that were opened
    errors: list = dataclasses.field(default_factory=list)


class ChangedError(Exception):
    """The archive is another one than the one that was opened."""


class Reader:
    """One client. Kinds: how it makes sure that all bytes are of one state.

    if-match: the ray tracer, and the page from its own origin: another state is 412
    compare: the page from another origin, where the tag of each reply is compared
    if-range: a download that goes on: another state is sent whole, with 200
    """

    KINDS = ("if-match", "compare", "if-range")

    def __init__(self, number, port, path, states, counts):
        self.chance = random.Random(number)
        self.kind = self.KINDS[number % len(self.KINDS)]
        self.source = f"127.0.0.{2 + number % SOURCES}"
        self.port = port
        self.path = path
        self.states = states
        self.counts = counts
        self.stream = None

    async def read_until(self, stop):
        try:
            while not stop.is_set():
                try:
                    await self.read_once(stop)
                except ChangedError:
                    self.counts.changed += 1
        except Exception as e:  # noqa: BLE001, whatever it is, the test shows it
            self.counts.errors.append(f"{self.kind}: {type(e).__name__} {e}")
        finally:
            self.close()

    async def read_once(self, stop):
        status, headers, head = await self.request(0, HEAD_BYTES, None)
        found = [i for i, s in enumerate(self.states) if s.startswith(head)]
        if status != 206 or len(found) != 1:
            raise AssertionError(f"the beginning: {status}, {len(head)} bytes of {found}")
        state, etag = self.states[found[0]], headers["etag"]
        root, root_bytes = struct.unpack_from("<QQ", head, 32)
        await self.part(state, etag, root, root_bytes)
        self.counts.opened += 1
        self.counts.states.add(found[0])
        for _ in range(PARTS):
            if stop.is_set():
                return
            size = self.chance.randrange(1, MAX_PART_BYTES)
            at = self.chance.randrange(0, max(1, len(state) - size))
            await self.part(state, etag, at, min(size, len(state) - at))
            self.counts.parts += 1

    async def part(self, state, etag, at, size):
        status, headers, body = await self.request(at, size, etag)
        if status == 412 and self.kind == "if-match":
            raise ChangedError
        if self.kind != "if-match" and headers.get("etag") != etag:
            raise ChangedError
        if status != 206 or headers["content-range"] != f"bytes {at}-{at + size - 1}/{len(state)}":
            raise AssertionError(f"bytes {at} + {size}: {status} {headers}")
        if body != state[at : at + size]:
            raise AssertionError(f"bytes {at} + {size}: a mixture")

    async def request(self, at, size, etag):
        """Waits and tries again where the server asks for it. @return status, headers, body"""
        lines = [
            f"GET {self.path} HTTP/1.1",
            "Host: 127.0.0.1",
            f"Range: bytes={at}-{at + size - 1}",
        ]
        if etag and self.kind == "if-match":
            lines.append(f"If-Match: {etag}")
        if etag and self.kind == "if-range":
            lines.append(f"If-Range: {etag}")
        data = "\r\n".join([*lines, "", ""]).encode("latin-1")
        while True:
            status, headers, body = await self.exchange(data)
            if status not in (429, 502, 503, 504):
                return status, headers, body
            self.counts.refused += 1
            await asyncio.sleep(self.chance.uniform(0.5, 1) * float(headers["retry-after"]))

    async def exchange(self, data):
        """Our readers try five times where a connection is lost (docs/formats/http.md)."""
        lost = 0
        while True:
            is_kept = self.stream is not None
            try:
                return await asyncio.wait_for(self.once(data), HANGS_S)
            except (ConnectionError, asyncio.IncompleteReadError):
                self.close()
                if is_kept:  # at any time between two requests (RFC 9112, 9.3.1)
                    self.counts.reconnected += 1
                    continue
                lost += 1
                self.counts.lost += 1
                if lost == ATTEMPTS:
                    raise
                await asyncio.sleep(FIRST_WAIT_S * 2**lost * self.chance.uniform(0.5, 1))

    async def once(self, data):
        if self.stream is None:
            self.stream = await asyncio.open_connection(
                "127.0.0.1", self.port, local_addr=(self.source, 0)
            )
        read, write = self.stream
        write.write(data)
        await write.drain()
        head = (await read.readuntil(b"\r\n\r\n")).decode("latin-1").split("\r\n")
        headers = {n.lower(): v for n, _, v in (line.partition(": ") for line in head[1:] if line)}
        status = int(head[0].split()[1])
        if status == 200:  # all of a large file: what a reader of ranges does not want
            self.close()
            return status, headers, b""
        size = int(headers.get("content-length", "0"))
        body = await read.readexactly(size)
        self.counts.bytes += size
        if headers.get("connection", "").lower() == "close":
            self.close()
        return status, headers, body

    def close(self):
        if self.stream is not None:
            self.stream[1].close()
            self.stream = None


async def read_while(work, *, readers, port, path, states):
    """Reads until `work`, a function that is called on a thread of its own, has returned.

    @param states the bytes of each archive that the file may be meanwhile
    @return Counts
    """
    counts = Counts()
    stop = asyncio.Event()
    all_readers = [Reader(n, port, path, states, counts) for n in range(readers)]
    tasks = [asyncio.create_task(r.read_until(stop)) for r in all_readers]
    try:
        await asyncio.to_thread(work, counts)
    finally:
        stop.set()
        await asyncio.gather(*tasks)
    return counts

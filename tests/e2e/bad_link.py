"""A TCP link that is bad on purpose.

It is slow or narrow, has stalls, resets and silence, or passes writes in tiny pieces. For machines
whose kernel has no netem, and for tests without root. TCP turns lost packets into delays: to a
program a packet that is lost and sent again is a stall of about a second, and one that is lost for
good is a silent connection, or a reset.

When faults happen (after how many bytes), and how long they take, depends on the seed alone, for
each connection in the order of acceptance; how the bytes of several connections interleave in time
is up to the machine.
"""

import asyncio
import collections
import contextlib
import math
import random
import socket
import struct
import threading

RESET = "reset"
SILENT_FORTH = "silent forth"  # from the client to the server
SILENT_BACK = "silent back"
SILENT_BOTH = "silent both ways"
_QUEUED = 64  # reads on their way; beyond that the sender waits, as with a full window
_READ_BYTES = 16 << 10


class BadLink:
    """Listens at `port` of 127.0.0.1 and forwards to another local port, and back.

    It does so for as long as the block lasts.
    """

    def __init__(
        self,
        to_port,
        seed,
        *,
        delay_s=(0, 0),
        stall_every_bytes=0,
        stall_s=1.0,
        piece_bytes=None,
        bytes_per_s=0,
        fates=(),
        fate_bytes=(1, 1),
        silent_s=math.inf,
    ):
        """@param delay_s           from, to: of each read, each way; the order of bytes is kept
        @param stall_every_bytes average bytes of a connection and way between two stalls; 0: none
        @param stall_s           how long a stall lasts
        @param piece_bytes       from, to: writes are split into pieces of so many bytes; None:
                                 whole
        @param bytes_per_s       of each connection, each way; 0: no limit
        @param fates             RESET or SILENT_...: what happens to successive connections
        @param fate_bytes        from, to: how many bytes of both ways a fate takes
        @param silent_s          how long a silence lasts; nothing is lost by one that ends
        """
        self._to_port = to_port
        self._seed = seed
        self._delay_s = delay_s
        self._piece_bytes = piece_bytes
        self._bytes_per_s = bytes_per_s
        self._stall_every_bytes = stall_every_bytes
        self._stall_s = stall_s
        self._fates = collections.deque(fates)
        self._fate_bytes = fate_bytes
        self._silent_s = silent_s
        self._counts = collections.Counter()
        self._listening = socket.create_server(("127.0.0.1", 0), backlog=128)
        self._listening.setblocking(False)
        self.port = self._listening.getsockname()[1]
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._run, daemon=True)

    @property
    def counts(self):
        """What has really happened so far, by name.

        connections, bytes_forth, bytes_back, delayed (reads), stalls, pieces, and each fate.
        """
        return collections.Counter(self._counts)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._loop.call_soon_threadsafe(self._serving.cancel)
        self._thread.join()

    def _run(self):
        asyncio.set_event_loop(self._loop)
        self._serving = self._loop.create_task(self._serve())
        with contextlib.suppress(asyncio.CancelledError):
            self._loop.run_until_complete(self._serving)
        self._listening.close()
        self._loop.close()

    async def _serve(self):
        connections = set()
        try:
            while True:
                near, _ = await self._loop.sock_accept(self._listening)
                one = self._loop.create_task(
                    _Connection(self, self._counts["connections"]).carry(near)
                )
                self._counts["connections"] += 1
                connections.add(one)
                one.add_done_callback(connections.discard)
        finally:
            await _cancelled(list(connections))


class _Connection:
    """@param number of it; with the seed it determines what happens"""

    def __init__(self, link, number):
        self._link = link
        self._counts = link._counts
        self._numbers = random.Random(f"{link._seed} {number}")
        self._bytes_to_fate = self._numbers.randint(*link._fate_bytes)
        self._silent = set()  # ways that carry nothing now

    async def carry(self, near):
        loop = asyncio.get_running_loop()
        near.setblocking(False)
        far = socket.socket()
        far.setblocking(False)
        ways = []
        try:
            await loop.sock_connect(far, ("127.0.0.1", self._link._to_port))
            for end in (near, far):
                end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            ways = [
                loop.create_task(step)
                for name, source, to in (("forth", near, far), ("back", far, near))
                for step in self._way(name, source, to)
            ]
            await asyncio.gather(*ways)
        except OSError:  # one end has reset it, or a fate: so the other sees the same
            for end in (near, far):
                end.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        finally:
            await _cancelled(ways)
            near.close()
            far.close()

    def _way(self, name, source, to):
        """A reader and a writer with a queue between them: delayed bytes do not block reading."""
        queue = asyncio.Queue(_QUEUED)
        # One for each kind of fault: the number of pieces and reads depends on the machine, and
        # must not affect the others.
        delays, pieces, stalls = (random.Random(self._numbers.random()) for _ in range(3))
        return self._read(name, source, queue, delays), self._write(name, to, queue, pieces, stalls)

    async def _read(self, name, source, queue, delays):
        loop = asyncio.get_running_loop()
        last = 0.0
        low_s, high_s = self._link._delay_s
        while True:
            try:
                data = await loop.sock_recv(source, _READ_BYTES)
            except OSError:
                if name not in self._silent:
                    raise
                data = b""  # a silence hides it from both ends
            if high_s > 0:
                last = max(last, loop.time() + delays.uniform(low_s, high_s))
                self._counts["delayed"] += 1
            await queue.put((last, data))
            if not data:
                return

    async def _write(self, name, to, queue, pieces, stalls):
        loop = asyncio.get_running_loop()
        link = self._link
        carried = 0
        stall_at = self._next_stall(0, stalls)
        begun = loop.time()
        while True:
            due, data = await queue.get()
            await asyncio.sleep(due - loop.time())
            if not data:
                to.shutdown(socket.SHUT_WR)
                return
            while data:
                if name in self._silent:
                    await asyncio.sleep(link._silent_s)
                    self._silent.discard(name)
                most = min(len(data), stall_at - carried)
                if self._bytes_to_fate > 0:
                    most = min(most, self._bytes_to_fate)
                if link._piece_bytes:
                    most = min(most, pieces.randint(*link._piece_bytes))
                    self._counts["pieces"] += 1
                piece = data[:most]
                data = data[most:]
                meets_fate = most == self._bytes_to_fate
                self._bytes_to_fate -= most  # before it is sent: the other way sends meanwhile
                await loop.sock_sendall(to, piece)
                carried += most
                self._counts["bytes_" + name] += most
                if link._bytes_per_s:
                    await asyncio.sleep(begun + carried / link._bytes_per_s - loop.time())
                if meets_fate:
                    self._meet_fate()
                if carried == stall_at:
                    self._counts["stalls"] += 1
                    await asyncio.sleep(link._stall_s)
                    stall_at = self._next_stall(carried, stalls)

    def _next_stall(self, carried, stalls):
        every = self._link._stall_every_bytes
        return carried + max(1, round(stalls.expovariate(1 / every))) if every else math.inf

    def _meet_fate(self):
        if not self._link._fates:
            return
        fate = self._link._fates.popleft()
        self._counts[fate] += 1
        if fate == RESET:
            raise ConnectionResetError
        self._silent = {
            SILENT_FORTH: {"forth"},
            SILENT_BACK: {"back"},
            SILENT_BOTH: {"forth", "back"},
        }[fate]


async def _cancelled(tasks):
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)

"""A TCP link that is bad on purpose: slow, narrow, with stalls, resets and silence, and with writes that come in tiny pieces.

For machines whose kernel has no netem, and for tests without root. TCP hides lost packets behind time: what a program sees of a packet that is lost and
sent again is a stall of about a second, and of one that is lost for good a connection that says nothing any more, or a reset.

Where things happen (after how many bytes), and how long they take, is drawn from the seed alone, for each connection in the order in which they are
accepted; how the bytes of several connections fall together in time is up to the machine.
"""

import asyncio
import collections
import math
import random
import socket
import struct
import threading

RESET = "reset"
SILENT_FORTH = "silent forth"  # from who has dialled to who was dialled
SILENT_BACK = "silent back"
SILENT_BOTH = "silent both ways"
_QUEUED = 64  # reads on their way; beyond that the sender waits, as with a full window
_READ_BYTES = 16 << 10


class BadLink:
    """Listens at `port` of 127.0.0.1 and carries what comes there to another port of it, and back. For as long as the block lasts."""

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
        """
        @param delay_s           from, to: of each read, each way; what comes later never overtakes
        @param stall_every_bytes on average nothing goes on for stall_s after so many bytes of a connection and way; 0: never
        @param piece_bytes       from, to: writes are split into pieces of so many bytes; None: they are not
        @param bytes_per_s       of each connection, each way; 0: no limit
        @param fates             RESET or SILENT_...: what happens to one connection after the other that has carried enough bytes
        @param fate_bytes        from, to: how many of these that takes, of both ways together
        @param silent_s          how long a silence lasts; nothing is lost by one that ends
        """
        self._to_port, self._seed = to_port, seed
        self._delay_s, self._piece_bytes, self._bytes_per_s = delay_s, piece_bytes, bytes_per_s
        self._stall_every_bytes, self._stall_s = stall_every_bytes, stall_s
        self._fates, self._fate_bytes, self._silent_s = (
            collections.deque(fates),
            fate_bytes,
            silent_s,
        )
        self._counts = collections.Counter()
        self._listening = socket.create_server(("127.0.0.1", 0), backlog=128)
        self._listening.setblocking(False)
        self.port = self._listening.getsockname()[1]
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._run, daemon=True)

    @property
    def counts(self):
        """What has truly happened so far: connections, bytes_forth, bytes_back, delayed (reads), stalls, pieces, and each fate by its name."""
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
        try:
            self._loop.run_until_complete(self._serving)
        except asyncio.CancelledError:
            pass
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
    """@param number of it; with the seed it says what happens"""

    def __init__(self, link, number):
        self._link, self._counts = link, link._counts
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
        """What reads and what writes, with a queue between them: bytes that are delayed keep nobody from reading more."""
        queue = asyncio.Queue(_QUEUED)
        # One for each kind of fault: how many pieces and reads there are is up to the machine, and must not move the others.
        delays, pieces, stalls = (random.Random(self._numbers.random()) for _ in range(3))
        return self._read(name, source, queue, delays), self._write(name, to, queue, pieces, stalls)

    async def _read(self, name, source, queue, delays):
        loop, last, low_s, high_s = asyncio.get_running_loop(), 0.0, *self._link._delay_s
        while True:
            try:
                data = await loop.sock_recv(source, _READ_BYTES)
            except OSError:
                if name not in self._silent:
                    raise
                data = b""  # nobody is told of it through a silence
            if high_s > 0:
                last = max(last, loop.time() + delays.uniform(low_s, high_s))
                self._counts["delayed"] += 1
            await queue.put((last, data))
            if not data:
                return

    async def _write(self, name, to, queue, pieces, stalls):
        loop, link, carried = asyncio.get_running_loop(), self._link, 0
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
                piece, data = data[:most], data[most:]
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

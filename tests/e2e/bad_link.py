"""A TCP link that is bad on purpose: it has resets and silence.

For machines whose kernel has no netem, and for tests without root. TCP turns lost packets into
delays: to a program a packet that is lost for good is a silent connection, or a reset.

When faults happen (after how many bytes) depends on the seed alone, for each connection in the
order of acceptance; how the bytes of several connections interleave in time is up to the machine.
"""

import asyncio
import collections
import contextlib
import random
import socket
import struct
import threading

RESET = "reset"
SILENT_FORTH = "silent forth"  # from the client to the server
SILENT_BACK = "silent back"
SILENT_BOTH = "silent both ways"
_READ_BYTES = 16 << 10


class BadLink:
    """Listens at `port` of 127.0.0.1 and forwards to another local port, and back.

    It does so for as long as the block lasts.
    """

    def __init__(self, to_port, seed, *, fates=(), fate_bytes=(1, 1)):
        """@param fates RESET or SILENT_...: what happens to successive connections
        @param fate_bytes from, to: how many bytes of both ways a fate takes
        """
        self._to_port = to_port
        self._seed = seed
        self._fates = collections.deque(fates)
        self._fate_bytes = fate_bytes
        self._counts = collections.Counter()
        self._listening = socket.create_server(("127.0.0.1", 0), backlog=128)
        self._listening.setblocking(False)
        self.port = self._listening.getsockname()[1]
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._run, daemon=True)

    @property
    def counts(self):
        """What has really happened so far: connections, and each fate by its name."""
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
        chance = random.Random(f"{link._seed} {number}")
        self._bytes_to_fate = chance.randint(*link._fate_bytes)
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
                loop.create_task(self._way("forth", near, far)),
                loop.create_task(self._way("back", far, near)),
            ]
            await asyncio.gather(*ways)
        except OSError:  # one end has reset it, or a fate: so the other sees the same
            for end in (near, far):
                end.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        finally:
            await _cancelled(ways)
            near.close()
            far.close()

    async def _way(self, name, source, to):
        loop = asyncio.get_running_loop()
        while True:
            try:
                data = await loop.sock_recv(source, _READ_BYTES)
            except OSError:
                if name not in self._silent:
                    raise
                data = b""  # a silence hides it from both ends
            if not data:
                await self._end_in_silence(name)
                to.shutdown(socket.SHUT_WR)
                return
            while data:
                await self._end_in_silence(name)
                most = len(data)
                if self._bytes_to_fate > 0:
                    most = min(most, self._bytes_to_fate)
                piece = data[:most]
                data = data[most:]
                meets_fate = most == self._bytes_to_fate
                self._bytes_to_fate -= most  # before it is sent: the other way sends meanwhile
                await loop.sock_sendall(to, piece)
                if meets_fate:
                    self._meet_fate()

    async def _end_in_silence(self, name):
        if name in self._silent:
            await asyncio.Event().wait()

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

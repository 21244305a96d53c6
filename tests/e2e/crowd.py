"""A thousand misbehaving clients, on one thread."""

import select
import socket
import threading

from support import HANGS_S


class Crowd:
    """Misbehaving clients of several loopback addresses, each with more connections than its limit.

    One thread serves them all.
    """

    def __init__(self, port, count, behaviour):
        self._port = port
        self._behaviour = behaviour
        self._stop = threading.Event()
        self.steps = 0  #: times that all have behaved
        self.connections = [self._connect(i) for i in range(count)]
        self._thread = threading.Thread(target=self._work, daemon=True)

    def _connect(self, i):
        connection = socket.socket()
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        connection.bind((f"127.0.1.{i % 20 + 1}", 0))
        connection.settimeout(HANGS_S)
        connection.connect(("127.0.0.1", self._port))
        return connection

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._stop.set()
        self._thread.join()
        for connection in self.connections:
            connection.close()

    def _work(self):
        while not self._stop.wait(0.25):
            for i, connection in enumerate(self.connections):
                try:
                    self._behaviour(connection, self.steps)
                except OSError:  # shed, as it should be: another one comes
                    connection.close()
                    self.connections[i] = self._connect(i)
            self.steps += 1


def nothing(connection, step):
    if step == 0:
        return
    if select.select([connection], [], [], 0)[0]:
        raise ConnectionError  # closed by the server


def half_header(connection, step):
    if step == 0:
        connection.sendall(b"GET /v2/world HTTP/1.1\r\nHost: localhost\r\n")
    nothing(connection, step)


def slow_header(connection, step):
    connection.sendall(b"GET /v2/world HTTP/1.1\r\n" if step == 0 else b"A: b\r\n")


def slow_body(connection, step):
    connection.sendall(
        b"POST /v2/boxes HTTP/1.1\r\nHost: localhost\r\nContent-Length: 200000\r\n\r\n"
        if step == 0
        else b" "
    )

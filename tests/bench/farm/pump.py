"""Forwards a connection until it is stopped."""

import contextlib
import socket
import threading


class Pump:
    """Listens on a port of its own and forwards to a local port, and back.

    It does so for as long as the block lasts.
    """

    def __init__(self, to_port):
        self._to_port = to_port
        self._flows = threading.Event()
        self._flows.set()
        self._listening = socket.create_server(("127.0.0.1", 0))
        self.port = self._listening.getsockname()[1]
        self._open = []
        threading.Thread(target=self._accept, daemon=True).start()

    def hold_answers(self):
        """What comes from the far port waits, in order; nothing is lost."""
        self._flows.clear()

    def go_on(self):
        self._flows.set()

    def _accept(self):
        while True:
            try:
                near, _ = self._listening.accept()
            except OSError:
                return
            far = socket.create_connection(("127.0.0.1", self._to_port))
            self._open += [near, far]
            threading.Thread(target=self._pass, args=(near, far, None), daemon=True).start()
            threading.Thread(target=self._pass, args=(far, near, self._flows), daemon=True).start()

    @staticmethod
    def _pass(source, to, flows):
        try:
            while data := source.recv(1 << 16):
                if flows:
                    flows.wait()
                to.sendall(data)
        except OSError:
            pass
        for end in (source, to):
            with contextlib.suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.go_on()
        for end in (self._listening, *self._open):
            end.close()

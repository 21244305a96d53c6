"""Unauthorised peers: connections that send nothing, and very many short ones."""

import multiprocessing
import os
import resource
import selectors
import socket
import time

from farming import die_with_parent


def more_descriptors(count):
    """For this process. @return how many it may have"""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft < count:
        resource.setrlimit(
            resource.RLIMIT_NOFILE,
            (count if hard == resource.RLIM_INFINITY else min(count, hard), hard),
        )
    return resource.getrlimit(resource.RLIMIT_NOFILE)[0]


class Idle:
    """Holds many connections to a local port that send nothing, until the block ends.

    @param stubborn reconnects when the server closes a connection
    """

    def __init__(self, port, count, stubborn=False):
        self._port = port
        self.count = count
        self._stubborn = stubborn
        self.opened = 0
        self._end = multiprocessing.Event()
        self._there = multiprocessing.Value("i", 0)
        self._process = multiprocessing.Process(target=self._work, daemon=True)

    def _work(self):
        die_with_parent()()
        more_descriptors(self.count + 100)
        waiting = selectors.DefaultSelector()
        held = 0
        while not self._end.is_set():
            for _ in range(min(200, self.count - held)):
                one = socket.socket()
                one.setblocking(False)
                if one.connect_ex(("127.0.0.1", self._port)) not in (
                    0,
                    115,
                ):  # 115: it is under way
                    one.close()
                    break
                waiting.register(one, selectors.EVENT_READ)
                held += 1
                self._there.value += 1
            for key, _ in waiting.select(0.05):
                waiting.unregister(key.fileobj)
                key.fileobj.close()
                held -= self._stubborn

    def __enter__(self):
        self._process.start()
        end = time.monotonic() + 60
        while self._there.value < self.count:
            if time.monotonic() > end:
                raise RuntimeError(
                    f"idle connections: {self._there.value} of {self.count} within 60 s"
                )
            time.sleep(0.05)
        return self

    def __exit__(self, *_):
        self.opened = self._there.value
        self._end.set()
        self._process.join(30)
        if self._process.is_alive():
            self._process.kill()


def _come_and_go(port, until, seed, count):
    die_with_parent()()
    words = (
        b"",
        b"GET / HTTP/1.1\r\n\r\n",
        b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
        b"TVX-FARM\x01" + os.urandom(32) + os.urandom(32),
        os.urandom(200),
    )
    number = seed
    while time.monotonic() < until:
        one = socket.socket()
        one.settimeout(1)
        try:
            one.connect(("127.0.0.1", port))
            one.sendall(words[number % len(words)])
        except OSError:
            pass
        one.close()
        number += 1
    with count.get_lock():
        count.value += number - seed


def flood(port, seconds, processes=2):
    """@return connections that were tried"""
    count = multiprocessing.Value("q", 0)
    until = time.monotonic() + seconds
    workers = [
        multiprocessing.Process(target=_come_and_go, args=(port, until, i, count), daemon=True)
        for i in range(processes)
    ]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join(seconds + 30)
    return count.value

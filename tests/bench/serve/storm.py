#!/usr/bin/env python3
"""Many clients ask for one box that nobody made yet, all at once. One line of JSON."""

import argparse
import selectors
import socket
import time

from serving import Server, invented_survey, many_files, percentile, tell
from wire import Talk, get


def connected(port, count):
    """@return sockets that the server has had time to take"""
    out = []
    for i in range(count):
        out.append(socket.create_connection(("127.0.0.1", port), timeout=20))
        if i % 100 == 99:
            time.sleep(0.05)  # the kernel keeps 200 that are not yet taken
    time.sleep(0.3)
    return out


def ask_at_once(connections, path, most_s):
    """@return replies (None where none came whole) and the seconds after which each was there"""
    request = get(path, "Connection: close")
    selector, got, times = selectors.DefaultSelector(), {}, {}
    start = time.monotonic()
    for connection in connections:
        connection.sendall(request)
        connection.setblocking(False)
        selector.register(connection, selectors.EVENT_READ)
        got[connection] = b""
    left = len(connections)
    while left and time.monotonic() < start + most_s:
        for key, _ in selector.select(1):
            try:
                data = key.fileobj.recv(1 << 18)
            except ConnectionError:
                data = b""
            got[key.fileobj] += data
            if not data:
                selector.unregister(key.fileobj)
                times[key.fileobj] = time.monotonic() - start
                left -= 1
    selector.close()
    replies = []
    for connection in connections:
        said = Talk(got[connection], True)
        replies.append(said.replies[0] if len(said.replies) == 1 and not said.rest else None)
        connection.close()
    return replies, [times.get(c, most_s) for c in connections]


def made(server):
    stats = server.json("/v2/stats")
    return stats["making"]["made"]


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--clients", type=int, default=1000)
    arguments.add_argument("--most-s", type=float, default=60)
    a = arguments.parse_args()
    many_files()
    server = Server(
        invented_survey("1x1", 512, 6),
        "--cache",
        "none",
        "--no-ahead",
        "--request-threads",
        str(a.clients + 50),
    )
    try:
        bounds = server.json("/v2/world")["bounds"]
        middle = [(low + high) // 2 for low, high in zip(bounds["min"], bounds["max"])]
        column = server.json(f"/v2/columns/0/{middle[0] // 64}/{middle[2] // 64}")
        path = f"/v2/boxes/0/{middle[0] // 64}/{column['by_begin']}/{middle[2] // 64}"
        before, start, waiting, busy, bad, times, bodies = (
            made(server),
            time.monotonic(),
            a.clients,
            0,
            0,
            [],
            set(),
        )
        while waiting and time.monotonic() < start + a.most_s:
            connections = connected(server.port, waiting)
            if waiting == a.clients:
                start = time.monotonic()
            replies, took = ask_at_once(connections, path, a.most_s)
            again, wait_s = 0, 1.0
            for reply, seconds in zip(replies, took):
                if (
                    reply is not None
                    and reply.status == 503
                    and reply.headers.get("retry-after", "").isdigit()
                    and not reply.problem()
                ):
                    again, busy, wait_s = again + 1, busy + 1, float(reply.headers["retry-after"])
                elif reply is None or reply.status != 200:
                    bad += 1
                else:
                    bodies.add(reply.body)
                    times.append(seconds)
            waiting = again
            if waiting:
                time.sleep(wait_s)
        wall = time.monotonic() - start
        figures = {
            "made": made(server) - before,
            "errors": bad + waiting + (len(bodies) != 1),
            "busy": busy,
            "wall_s": wall,
            "first_s": min(times, default=0),
            "p99_s": percentile(times, 0.99) if times else 0,
            "served": len(times),
        }
    finally:
        server.stop()
    tell(figures)


if __name__ == "__main__":
    main()

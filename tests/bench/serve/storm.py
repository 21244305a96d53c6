#!/usr/bin/env python3
"""Many clients request one box that is not computed yet, all at once. One line of JSON."""

import argparse
import selectors
import socket
import time

from serving import Server, many_files, percentile, print_figures, synthetic_survey
from wire import Talk, get


def connected(port, count):
    """@return sockets, after a pause in which the server can accept them"""
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
    selector = selectors.DefaultSelector()
    got = {}
    times = {}
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


def middle_box(server):
    """@return the address of a box in the middle of the world"""
    bounds = server.json("/v2/world")["bounds"]
    x, _, z = ((low + high) // 2 for low, high in zip(bounds["min"], bounds["max"]))
    column = server.json(f"/v2/columns/0/{x // 64}/{z // 64}")
    return f"/v2/boxes/0/{x // 64}/{column['by_begin']}/{z // 64}"


def is_busy(reply):
    """@return whether the server sent 503 with Retry-After"""
    return (
        reply is not None
        and reply.status == 503
        and reply.headers.get("retry-after", "").isdigit()
        and not reply.problem()
    )


def ask_until_served(server, clients, most_s):
    """Clients request one box at the same time, and again while the server is busy.

    @return figures
    """
    path = middle_box(server)
    before = made(server)
    start = time.monotonic()
    waiting = clients
    busy = 0
    bad = 0
    times = []
    bodies = set()
    while waiting and time.monotonic() < start + most_s:
        connections = connected(server.port, waiting)
        if waiting == clients:
            start = time.monotonic()
        replies, took = ask_at_once(connections, path, most_s)
        again = 0
        wait_s = 1.0
        for reply, seconds in zip(replies, took):
            if is_busy(reply):
                again += 1
                wait_s = float(reply.headers["retry-after"])
            elif reply is None or reply.status != 200:
                bad += 1
            else:
                bodies.add(reply.body)
                times.append(seconds)
        busy += again
        waiting = again
        if waiting:
            time.sleep(wait_s)
    wall = time.monotonic() - start
    return {
        "made": made(server) - before,
        "errors": bad + waiting + (len(bodies) != 1),
        "busy": busy,
        "wall_s": wall,
        "first_s": min(times, default=0),
        "p99_s": percentile(times, 0.99) if times else 0,
        "served": len(times),
    }


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--clients", type=int, default=1000)
    arguments.add_argument("--most-s", type=float, default=60)
    a = arguments.parse_args()
    many_files()
    server = Server(
        synthetic_survey("1x1", 512, 6),
        "--cache",
        "none",
        "--no-ahead",
        "--request-threads",
        str(a.clients + 50),
    )
    try:
        figures = ask_until_served(server, a.clients, a.most_s)
    finally:
        server.stop()
    print_figures(figures)


if __name__ == "__main__":
    main()

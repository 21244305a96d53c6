#!/usr/bin/env python3
"""Mixed load for minutes on a world that is larger than the memory limit.

Prints memory, errors and times as one line of JSON.
"""

import argparse
import hashlib
import http.client
import json
import pathlib
import random
import threading
import time

from serving import Server, kept_folder, percentile, print_figures, synthetic_survey

BAD = [
    ("/v2/boxes/x/1/1/1", 400),
    ("/v2/boxes/99/1/1/1", 404),
    ("/nothing", 404),
    ("/v2/columns/0/1e5/2", 400),
    ("/../../etc/passwd", 404),
    ("/v2/boxes/0/1/1", 404),
]


class World:
    """Valid requests, and earlier replies: a box must always have the same bytes."""

    def __init__(self, server):
        info = server.json("/v2/world")
        self.levels = info["levels"]
        self.bounds = info["bounds"]
        self.map = info.get("map")
        self.batches = batches_are_served(server)
        self._lock = threading.Lock()
        self._seen = {}

    def key(self, numbers):
        level = numbers.randrange(self.levels)
        side = (64 << level, 256 << level, 64 << level)
        return (
            level,
            *(
                numbers.randrange(
                    self.bounds["min"][i] // side[i], (self.bounds["max"][i] - 1) // side[i] + 1
                )
                for i in range(3)
            ),
        )

    def tile(self, numbers):
        low, high = self.map["zooms"]
        zoom = numbers.randint(low, high)
        side = self.map["tile_px"] << (high - zoom)
        x, y = (
            numbers.randrange(
                self.bounds["min"][i] // side, (self.bounds["max"][i] - 1) // side + 1
            )
            for i in (0, 2)
        )
        return f"/map/{zoom}/{x}/{y}.png"

    def same_as_before(self, path, reply):
        with self._lock:
            return self._seen.setdefault(path, reply) == reply


def batches_are_served(server):
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=30)
    try:
        connection.request(
            "POST",
            "/v2/boxes",
            body=json.dumps({"boxes": []}),
            headers={"Content-Type": "application/json"},
        )
        return connection.getresponse().status not in (404, 405, 413)
    finally:
        connection.close()


class Client(threading.Thread):
    def __init__(self, server, world, seed, until):
        super().__init__(daemon=True)
        self._port = server.port
        self._world = world
        self._numbers = random.Random(seed)
        self._until = until
        self._connection = None
        self._tags = {}
        self.times = {}
        self.busy = 0
        self.errors = []

    def run(self):
        while time.monotonic() < self._until:
            kind, method, path, headers, body, allowed = self._choose()
            start = time.monotonic()
            try:
                status, said_headers, said = self._ask(method, path, headers, body)
            except (OSError, http.client.HTTPException) as error:
                self.errors.append(f"{path}: {error!r}")
                continue
            self.times.setdefault(kind, []).append(time.monotonic() - start)
            if status == 503 and said_headers.get("Retry-After"):
                self.busy += 1
                time.sleep(0.05)
            elif status not in allowed:
                self.errors.append(f"{path}: {status} {said[:80]}")
            elif kind == "box":
                if not self._world.same_as_before(path, (status, hashlib.sha1(said).digest())):
                    self.errors.append(f"{path}: other bytes than before")
                self._tags[path] = said_headers.get("ETag")

    def _choose(self):
        n = self._numbers
        draw = n.random()
        if draw < 0.15:
            level, bx, _, bz = self._world.key(n)
            return "column", "GET", f"/v2/columns/{level}/{bx}/{bz}", {}, None, (200,)
        if draw < 0.25 and self._world.map:
            return "map", "GET", self._world.tile(n), {}, None, (200, 204)
        if draw < 0.30 and self._world.batches:
            boxes = [list(self._world.key(n)) for _ in range(8)]
            return (
                "batch",
                "POST",
                "/v2/boxes",
                {"Content-Type": "application/json"},
                json.dumps({"boxes": boxes}),
                (200,),
            )
        if draw < 0.40 and self._tags:
            path = n.choice(list(self._tags))
            return "304", "GET", path, {"If-None-Match": self._tags[path]}, None, (304,)
        if draw < 0.45:
            path, status = n.choice(BAD)
            return "bad", "GET", path, {}, None, (status, 400)
        return (
            "box",
            "GET",
            "/v2/boxes/" + "/".join(map(str, self._world.key(n))),
            {},
            None,
            (200, 204),
        )

    def _ask(self, method, path, headers, body):
        """Sends on a kept connection, and again when the server has closed it meanwhile."""
        for attempt in range(2):
            fresh = self._connection is None
            if fresh:
                self._connection = http.client.HTTPConnection("127.0.0.1", self._port, timeout=120)
            try:
                self._connection.request(method, path, body=body, headers=headers)
                reply = self._connection.getresponse()
                said = reply.read()
                if reply.will_close:
                    self._connection.close()
                    self._connection = None
                return reply.status, reply.headers, said
            except (OSError, http.client.HTTPException):
                self._connection.close()
                self._connection = None
                if fresh or attempt == 1:
                    raise
        raise AssertionError("unreachable")


def prepare(server, world):
    """Requests all boxes of the coarsest level: every square is read once before the clock runs."""
    for path in server.box_paths(world.levels - 1):
        status = server.get(path, timeout_s=300)[0]
        if status not in (200, 204):
            raise SystemExit(f"{path}: {status}")


def descriptors(server):
    return len(list(pathlib.Path(f"/proc/{server.process.pid}/fd").iterdir()))


def run_clients(server, world, count, seconds):
    """Runs clients for a while. @return the clients, resident KiB and descriptors of the server"""
    rss = [server.memory_kib()]
    prepare(server, world)
    until = time.monotonic() + seconds
    clients = [Client(server, world, seed, until) for seed in range(count)]
    for client in clients:
        client.start()
    counted = []
    while time.monotonic() < until and server.process.poll() is None:
        time.sleep(0.2)
        rss.append(server.memory_kib())
        counted.append(descriptors(server))
    for client in clients:
        client.join()
    return clients, rss, counted


def times_of(clients):
    """@return {kind of request: seconds of each}"""
    times = {}
    for client in clients:
        for kind, of in client.times.items():
            times.setdefault(kind, []).extend(of)
    return times


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--minutes", type=float, default=10)
    arguments.add_argument("--memory-mib", type=int, default=256)
    arguments.add_argument("--squares", default="4x4")
    arguments.add_argument("--clients", type=int, default=6)
    a = arguments.parse_args()
    folder = pathlib.Path(synthetic_survey(a.squares, 512, 6))
    bytes_of_points = sum(f.stat().st_size for f in folder.glob("*.laz"))
    flags = ["--cache", kept_folder("soak"), "--memory-mib", a.memory_mib]
    server = Server(folder, "--ortho", folder / "ortho", *flags)
    try:
        clients, rss, counted = run_clients(server, World(server), a.clients, 60 * a.minutes)
        peak_kib = server.memory_kib("VmHWM")
        stats = server.json("/v2/stats")
    finally:
        code = server.stop()
    errors = [e for c in clients for e in c.errors]
    for line in [*errors[:20], *server.err.splitlines()[-20:]]:
        print(line)
    times = times_of(clients)
    half = max(1, len(rss) // 2)
    print_figures(
        {
            "rss_mib": max(rss) / 1024,
            "peak_mib": peak_kib / 1024,
            "rss_start_mib": rss[0] / 1024,
            "limit_mib": a.memory_mib,
            "points_mib": bytes_of_points / 2**20,
            "growth": max(rss[half:]) / max(rss[:half]),
            "errors": len(errors) + (code != 0),
            "busy": sum(c.busy for c in clients),
            "requests": sum(len(of) for of in times.values()),
            "p99_ms": {kind: percentile(of, 0.99) * 1e3 for kind, of in times.items()},
            "p50_ms": {kind: percentile(of, 0.5) * 1e3 for kind, of in times.items()},
            "descriptors": max(counted, default=0),
            "evictions": stats["cache"]["evictions"],
            "seconds": 60 * a.minutes,
        }
    )


if __name__ == "__main__":
    main()

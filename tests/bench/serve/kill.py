#!/usr/bin/env python3
"""kill -9 while boxes are computed and written: later replies are compared with the truth.

Prints one line of JSON.

A server is killed when something has happened, never after a time: it has just been started, it has
begun its file, it listens, it has served so many boxes, or it has written so many. The machine
decides which instruction the signal hits, and every outcome is checked.
"""

import argparse
import contextlib
import http.client
import json
import math
import random
import shutil
import subprocess
import threading
import time

from serving import (
    HANGS_S,
    Server,
    binary,
    print_figures,
    synthetic_survey,
    temporary_folder,
    wait_until,
)


def all_paths(server):
    return [
        p for level in range(server.json("/v2/world")["levels"]) for p in server.box_paths(level)
    ]


def truth_of(world):
    """What an uninterrupted server serves. @return {path: (status, bytes)}"""
    server = Server(*world, "--cache", "none")
    try:
        return {p: server.get(p)[::2] for p in all_paths(server)}
    finally:
        server.stop()


class Client(threading.Thread):
    """Requests boxes until the server is gone, and compares every reply that came whole."""

    def __init__(self, port, paths, truth):
        super().__init__(daemon=True)
        self._port = port
        self._paths = paths
        self._truth = truth
        self.replies = 0
        self.compared = 0
        self.corrupt = []

    def run(self):
        with contextlib.closing(
            http.client.HTTPConnection("127.0.0.1", self._port, timeout=HANGS_S)
        ) as connection:
            for path in self._paths:
                try:
                    connection.request("GET", path)
                    reply = connection.getresponse()
                    body = reply.read()
                except (OSError, http.client.HTTPException):
                    return
                self.replies += 1
                if reply.status == 503:
                    continue
                self.compared += 1
                if (reply.status, body) != self._truth[path]:
                    self.corrupt.append(path)


def clients(port, paths, truth, numbers, count):
    out = []
    for _ in range(count):
        mine = list(paths)
        numbers.shuffle(mine)
        out.append(Client(port, mine, truth))
        out[-1].start()
    return out


def written(port):
    """Boxes that the server has put on the disk so far; endless for one that keeps none there."""
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=HANGS_S)
    connection.request("GET", "/v2/stats")
    disk = json.loads(connection.getresponse().read()).get("disk")
    connection.close()
    return disk["entries"] if disk else math.inf


def start_and_kill(command, cache, truth, numbers):
    """Starts a server, requests everything, and kills it at some point of its work.

    @return the clients, joined
    """
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    )
    running = []
    when = numbers.choices(
        ("started", "begun its file", "listening", "served", "written"), (1, 2, 1, 4, 4)
    )[0]
    try:
        if when == "started":
            return running
        if when == "begun its file":
            wait_until(
                lambda: (
                    any(file.is_file() for file in cache.rglob("*")) or process.poll() is not None
                ),
                "a file of the cache",
            )
            return running
        line = process.stdout.readline()
        if not line.startswith("listening on "):
            raise RuntimeError(f"the server printed '{line}'")
        if when == "listening":
            return running
        port = int(line.rsplit(":", 1)[1])
        running = clients(port, list(truth), truth, numbers, 3)
        if when == "served":
            most = numbers.randrange(3 * len(truth))
            wait_until(
                lambda: (
                    sum(client.replies for client in running) >= most
                    or not any(client.is_alive() for client in running)
                ),
                f"{most} replies",
            )
        else:
            most = numbers.randint(1, len(truth) // 2)
            wait_until(
                lambda: written(port) >= most or not any(client.is_alive() for client in running),
                f"{most} boxes on the disk",
            )
        return running
    finally:
        process.kill()
        process.wait()
        process.stdout.close()
        for client in running:
            client.join()


def verify(world, cache, truth):
    """@return wrong boxes, and boxes read from disk: None for a server without a cache"""
    server = Server(*world, "--cache", cache)
    try:
        corrupt = [p for p, expected in truth.items() if server.get(p)[::2] != expected]
        disk = server.json("/v2/stats").get("disk")
        return corrupt, disk["hits"] if disk else None
    finally:
        server.kill()


def kill_often(kills, seed, world):
    """@return the figures; `corrupt` is the number of replies that were not the truth"""
    truth = truth_of(world)
    numbers = random.Random(seed)
    begin = time.monotonic()
    figures = {
        "kills": 0,
        "compared": 0,
        "corrupt": 0,
        "from_disk": 0,
        "keeps_boxes": False,
        "boxes": len(truth),
        "paths": [],
    }
    while figures["kills"] < kills:
        cache = temporary_folder()
        # From an empty folder; one in three is killed again while it recovers.
        for _ in range(1 if numbers.random() < 0.67 else 2):
            running = start_and_kill(
                [binary("VOXELSERVER"), *map(str, world), "--cache", str(cache), "--port", "0"],
                cache,
                truth,
                numbers,
            )
            figures["kills"] += 1
            figures["compared"] += sum(c.compared for c in running)
            figures["paths"] += [p for c in running for p in c.corrupt]
        corrupt, from_disk = verify(world, cache, truth)
        figures["compared"] += len(truth)
        figures["keeps_boxes"] |= from_disk is not None
        figures["from_disk"] += from_disk or 0
        figures["paths"] += corrupt
        shutil.rmtree(cache, ignore_errors=True)
    figures["corrupt"] = len(figures["paths"])
    figures["paths"] = figures["paths"][:10]
    figures["wall_s"] = time.monotonic() - begin
    return figures


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--kills", type=int, default=200)
    arguments.add_argument("--seed", type=int, default=9)
    a = arguments.parse_args()
    print_figures(kill_often(a.kills, a.seed, [synthetic_survey()]))


if __name__ == "__main__":
    main()

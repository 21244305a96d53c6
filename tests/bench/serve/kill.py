#!/usr/bin/env python3
"""kill -9 while boxes are made and written, again and again: what is served afterwards is compared with the truth. One line of JSON."""

import argparse
import http.client
import random
import shutil
import subprocess
import threading
import time

from serving import Server, binary, invented_survey, temporary_folder, tell


def all_paths(server):
    return [p for level in range(server.json("/v2/world")["levels"]) for p in server.box_paths(level)]


def truth_of(world):
    """What an uninterrupted server serves, and how long it takes to make it all. @return {path: (status, bytes)}, seconds"""
    server = Server(*world, "--cache", "none")
    try:
        paths = all_paths(server)
        start = time.monotonic()
        return {p: server.get(p)[::2] for p in paths}, time.monotonic() - start
    finally:
        server.stop()


class Client(threading.Thread):
    """Asks for boxes until the server is gone, and compares every reply that came whole."""

    def __init__(self, port, paths, truth):
        super().__init__(daemon=True)
        self._port, self._paths, self._truth = port, paths, truth
        self.compared, self.corrupt = 0, []

    def run(self):
        connection = http.client.HTTPConnection("127.0.0.1", self._port, timeout=30)
        for path in self._paths:
            try:
                connection.request("GET", path)
                reply = connection.getresponse()
                body = reply.read()
            except (OSError, http.client.HTTPException):
                return
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


def start_and_kill(command, truth, numbers, delay_s):
    """Starts a server, asks it for everything, and kills it some time after its start. @return the clients, joined"""
    start = time.monotonic()
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    killer = threading.Timer(delay_s, process.kill)
    killer.start()
    line = process.stdout.readline()
    asking = []
    if line.startswith("listening on "):
        asking = clients(int(line.rsplit(":", 1)[1]), list(truth), truth, numbers, 3)
    killer.join()
    process.wait()
    process.stdout.close()
    for client in asking:
        client.join()
    return asking, time.monotonic() - start


def verify(world, cache, truth):
    """@return boxes served otherwise, boxes read from disk; None for the latter from a server that keeps none there"""
    server = Server(*world, "--cache", cache)
    try:
        corrupt = [p for p, expected in truth.items() if server.get(p)[::2] != expected]
        disk = server.json("/v2/stats").get("disk")
        return corrupt, disk["hits"] if disk else None
    finally:
        server.kill()


def kill_often(kills, seed, world):
    """@return the figures; `corrupt` is the number of replies that were not the truth"""
    truth, making_s = truth_of(world)
    numbers = random.Random(seed)
    begin = time.monotonic()
    start_s = min(_start_s(world) for _ in range(3))
    figures = {"kills": 0, "compared": 0, "corrupt": 0, "from_disk": 0, "keeps_boxes": False, "boxes": len(truth), "paths": []}
    while figures["kills"] < kills:
        cache = temporary_folder()
        # From an empty folder; one in three is killed again while it recovers.
        for _ in range(1 if numbers.random() < 0.67 else 2):
            asking, _ = start_and_kill([binary("VOXELSERVER"), *map(str, world), "--cache", str(cache), "--port", "0"], truth, numbers,
                                       start_s + numbers.uniform(-0.3 * start_s, 1.3 * making_s))
            figures["kills"] += 1
            figures["compared"] += sum(c.compared for c in asking)
            figures["paths"] += [p for c in asking for p in c.corrupt]
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


def _start_s(world):
    start = time.monotonic()
    server = Server(*world, "--cache", "none")
    took = time.monotonic() - start
    server.kill()
    return took


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--kills", type=int, default=200)
    arguments.add_argument("--seed", type=int, default=9)
    a = arguments.parse_args()
    tell(kill_often(a.kills, a.seed, [invented_survey()]))


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Time from the start of the server to its first box from disk, as one line of JSON."""

import argparse
import statistics
import subprocess
import time

from serving import Server, benchmark_square, binary, kept_folder, print_figures


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--starts", type=int, default=20)
    a = arguments.parse_args()
    world = [*benchmark_square(), "--cache", kept_folder("restart")]
    server = Server(*world)
    path = server.box_paths()[len(server.box_paths()) // 2]
    status, _, body = server.get(path, timeout_s=60)
    if status != 200 or server.stop() != 0:
        raise SystemExit(f"{path}: {status}")
    version = []
    listening = []
    replied = []
    from_disk = 0
    other = 0
    for _ in range(a.starts):
        start = time.monotonic()
        subprocess.run([binary("VOXELSERVER"), "--version"], check=True, stdout=subprocess.DEVNULL)
        version.append((time.monotonic() - start) * 1e3)
        start = time.monotonic()
        server = Server(*world)
        listening.append((time.monotonic() - start) * 1e3)
        reply = server.get(path)
        replied.append((time.monotonic() - start) * 1e3)
        other += reply[0] != 200 or reply[2] != body
        from_disk += ((server.json("/v2/stats").get("disk") or {}).get("hits", 0)) > 0
        server.stop()
    print_figures(
        {
            "version_ms": statistics.median(version),
            "box_ms": statistics.median(r - s for r, s in zip(replied, listening)),
            "listening_ms": statistics.median(listening),
            "listening_worst_ms": max(listening),
            "reply_ms": statistics.median(replied),
            "reply_worst_ms": max(replied),
            "from_disk": from_disk,
            "starts": a.starts,
            "other_replies": other,
        }
    )


if __name__ == "__main__":
    main()

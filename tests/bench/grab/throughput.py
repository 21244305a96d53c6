#!/usr/bin/env python3
"""Compares the grabber with curl: the same list of files, the same concurrency, the same server.

    tests/bench/grab/throughput.py [--rounds 5] [--concurrency 4] [--rate BYTES_PER_S]

Needs the built grabber (npm run build && npm run build:test in grabber/) and curl. Prints one
result line per list: name, files, bytes, median seconds (and of processor time) of curl, of curl
and then `sync -d` of its files, and of the grabber, and their ratios (1.00 = as fast; the aim is
0.90 of curl). Rounds of both take turns, since machines are shared. The grabber hashes, checks and
records what it fetches, and waits until it is on the disk, which curl does not; so the second ratio
compares like with like. Its start, about half a second, is in its time: lists should take many
times that. The last line is JSON, for programs.
"""

import argparse
import json
import pathlib
import random
import resource
import shutil
import statistics
import struct
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[3]
PORTAL = ROOT / "grabber" / "dist-test" / "tests" / "grabber" / "portal" / "main.js"
GRABBER = ROOT / "grabber" / "dist" / "main.js"
LISTS = {"large": (24, 25_000_000), "middle": (150, 2_000_000), "small": (4000, 50_000)}


def laz(size, east_km, north_km, rng):
    """LAZ in form only: header, LASzip record, chunk table pointer, filling, chunk table."""
    header = bytearray(227)
    header[0:4] = b"LASF"
    header[24:26] = bytes([1, 2])
    data = max(0, size - 227 - 88 - 16)
    struct.pack_into("<HII", header, 94, 227, 227 + 88, 1)
    struct.pack_into("<BHI", header, 104, 0x81, 28, 10)
    struct.pack_into("<3d", header, 131, 0.01, 0.01, 0.01)
    for axis, low in enumerate((east_km * 1000.0, north_km * 1000.0, 280.0)):
        struct.pack_into("<2d", header, 179 + 16 * axis, low + 999, low)
    vlr = bytearray(88)
    vlr[2:16] = b"laszip encoded"
    struct.pack_into("<HH", vlr, 18, 22204, 34)
    struct.pack_into("<H", vlr, 54, 2)
    return (
        bytes(header)
        + bytes(vlr)
        + struct.pack("<q", 227 + 88 + 8 + data)
        + rng.randbytes(data)
        + struct.pack("<II", 0, 1)
    )


def make_files(folder, count, size):
    rng = random.Random(count)
    names = []
    for index in range(count):
        east = 400 + index % 100
        north = 50 + index // 100
        names.append(f"{east}_{north}")
        pathlib.Path(folder, f"TM_{east}_{north}.laz").write_bytes(laz(size, east, north, rng))
    return names


def start_portal(folder, rate=None):
    pace = ["--rate", str(rate)] if rate else []
    portal = subprocess.Popen(
        ["node", PORTAL, "--root", folder, *pace], stdout=subprocess.PIPE, text=True
    )
    return portal, portal.stdout.readline().strip()


def run_curl(base, names, target, concurrency):
    config = pathlib.Path(target, "list.txt")
    with config.open("w") as file:
        for name in names:
            file.write(f'url = "{base}/TM_{name}.laz"\noutput = "{target}/{name}.laz"\n')
    subprocess.run(
        ["curl", "-sS", "--fail", "--parallel", "--parallel-max", str(concurrency), "-K", config],
        check=True,
        stderr=subprocess.DEVNULL,
    )


def run_grabber(base, names, target, concurrency):
    command = [
        "node",
        GRABBER,
        "fetch",
        "--url-template",
        base + "/TM_{name}.laz",
        "--allow-private",
        "--squares",
        ",".join(names),
        "--store",
        target,
    ]
    command += ["--concurrency", str(concurrency)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"the grabber ended with {done.returncode}: {done.stderr[-2000:]}")


def processor_s():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def timed(action, *arguments):
    target = tempfile.mkdtemp(prefix="terravox-bench-")
    try:
        subprocess.run(["sync", "-f", target], check=True)
        began = time.monotonic()
        spent = processor_s()
        action(*arguments[:2], target, *arguments[2:])
        took_s = time.monotonic() - began
        spent_s = processor_s() - spent
        subprocess.run(["find", target, "-type", "f", "-exec", "sync", "-d", "{}", "+"], check=True)
        return took_s, spent_s, time.monotonic() - began
    finally:
        shutil.rmtree(target)


def compare(label, count, size, options):
    with tempfile.TemporaryDirectory(prefix="terravox-bench-") as folder:
        names = make_files(folder, count, size)
        portal, base = start_portal(folder, options.rate)
        try:
            times = {"curl": [], "grabber": []}
            for _ in range(options.rounds):
                times["curl"].append(timed(run_curl, base, names, options.concurrency))
                times["grabber"].append(timed(run_grabber, base, names, options.concurrency))
        finally:
            portal.terminate()
            portal.wait()
    curl, curl_spent, synced = (statistics.median(column) for column in zip(*times["curl"]))
    grabber, spent, _ = (statistics.median(column) for column in zip(*times["grabber"]))
    line = (
        f"{label}: {count} files of {size} bytes, {options.concurrency} at a time: "
        f"curl {curl:.2f} s ({curl_spent:.2f} s of processor), with sync {synced:.2f} s"
    )
    print(
        f"{line}, grabber {grabber:.2f} s ({spent:.2f}), "
        f"ratio {curl / grabber:.2f}, with sync {synced / grabber:.2f}",
        flush=True,
    )
    return {
        "curl_s": curl,
        "curl_sync_s": synced,
        "grabber_s": grabber,
        "ratio": curl / grabber,
        "ratio_sync": synced / grabber,
    }


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--concurrency", type=int, default=4)
    parser.add_argument("--lists", default=",".join(LISTS))
    parser.add_argument(
        "--rate",
        type=int,
        help="the server paces each body to so many bytes a second, as portals do",
    )
    options = parser.parse_args()
    print(
        json.dumps(
            {label: compare(label, *LISTS[label], options) for label in options.lists.split(",")}
        )
    )


if __name__ == "__main__":
    main()

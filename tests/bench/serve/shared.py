#!/usr/bin/env python3
"""One archive, served by one process and by two behind nginx: requests a second, by wrk.

Prints one line of JSON.
"""

import argparse
import json
import random
import subprocess

import serving  # noqa: F401, first: it makes the modules of tests/e2e known
from nginx import Front
from readers import OPTIONS, run
from serving import Server, kept_folder, many_files, print_figures, temporary_folder

BOXES = 64
RANGES = 256
RANGE_BYTES = 64 << 10
# What one address may ask for is not limited: here all requests come from one.
UNLIMITED = [
    ("        limit_conn terravox_connections 128;\n", ""),
    ("        limit_req zone=terravox_requests burst=2000 nodelay;\n", ""),
]
WRK = """
local requests, i = {}, 0
init = function()
    for n, one in ipairs(ASKED) do
        requests[n] = wrk.format("GET", one[1], {["Range"] = one[2], ["Accept-Encoding"] = "zstd"})
    end
end
request = function() i = i % #requests + 1 return requests[i] end
done = function(summary, latency)
    local e = summary.errors
    local errors = e.connect + e.read + e.write + e.status + e.timeout
    print(string.format('{"rate":%.3f,"mb_per_s":%.3f,"p99_ms":%.3f,"errors":%d}',
        summary.requests / summary.duration * 1e6, summary.bytes / summary.duration,
        latency:percentile(99) / 1000, errors))
end
"""


def make_archive():
    folder = kept_folder("shared")
    survey, out = folder / "survey", folder / "place.tvx"
    if not out.exists():
        words = ["--seed", "7", "--squares", "4x4", "--square-m", "256", "--density", "2"]
        run("SURVEY", *words, "-o", survey)
        run("CONVERT", survey, out, *OPTIONS)
    return out


def measure(port, asked, seconds):
    """@param asked pairs of a path and the header Range"""
    script = temporary_folder() / "requests.lua"
    table = ",".join(f"{{{json.dumps(path)},{json.dumps(part)}}}" for path, part in asked)
    script.write_text(WRK.replace("ASKED", "{" + table + "}"))
    command = ["wrk", "-t1", "-c64", f"-d{seconds}s", "-s", script, f"http://127.0.0.1:{port}"]
    said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return json.loads(said.splitlines()[-1])


def loads(server, archive):
    """What is asked for: boxes that are kept after the first time, and parts of the file."""
    chance = random.Random(7)
    solid = [path for path in server.box_paths() if server.get(path)[0] == 200]
    size = archive.stat().st_size
    starts = [chance.randrange(0, max(1, size - RANGE_BYTES)) for _ in range(RANGES)]
    return {
        "boxes": [(path, "") for path in chance.sample(solid, min(BOXES, len(solid)))],
        "parts": [("/v2/archive.tvx", f"bytes={a}-{a + RANGE_BYTES - 1}") for a in starts],
    }


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--seconds", type=int, default=5, help="of wrk, for each figure")
    seconds = arguments.parse_args().seconds
    many_files()
    archive = make_archive()
    servers = [Server(archive, "--cache", "none") for _ in range(2)]
    figures = {}
    try:
        asked = loads(servers[0], archive)
        for count in (1, 2, 1, 2):  # in turn: what else the machine does hits both
            ports = [server.port for server in servers[:count]]
            upstream = f"server 127.0.0.1:{ports[0]};"
            several = (upstream, " ".join(f"server 127.0.0.1:{port};" for port in ports))
            with Front(ports[0], [several, *UNLIMITED]) as front:
                for name, requests in asked.items():
                    measure(front.port, requests, 1)
                    figure = measure(front.port, requests, seconds)
                    figures.setdefault(f"{name} {count}", []).append(figure)
    finally:
        for server in servers:
            server.stop()
    print_figures(
        {
            name: {
                "rate": sum(one["rate"] for one in of) / len(of),
                "mb_per_s": sum(one["mb_per_s"] for one in of) / len(of),
                "p99_ms": max(one["p99_ms"] for one in of),
                "errors": sum(one["errors"] for one in of),
            }
            for name, of in figures.items()
        }
    )


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Cached boxes requested repeatedly with wrk: the voxel server, then nginx with the same bytes.

Prints one line of JSON.
"""

import argparse
import json
import shutil
import subprocess
import time

from serving import (
    Server,
    benchmark_square,
    hold_port,
    kept_folder,
    print_figures,
    temporary_folder,
)
from wire import get, talk

BOXES = 16
NGINX = """
pid nginx.pid; error_log error.log; worker_processes auto; worker_rlimit_nofile 4096;
events { worker_connections 2048; }
http {
    access_log off; sendfile on; tcp_nopush on; tcp_nodelay on;
    keepalive_timeout 60s; keepalive_requests 1000000000;
    open_file_cache max=1000 inactive=60s; open_file_cache_valid 60s;
    default_type application/vnd.terravox.box;
    client_body_temp_path body; proxy_temp_path proxy; fastcgi_temp_path fastcgi;
    uwsgi_temp_path uwsgi; scgi_temp_path scgi;
    server { listen 127.0.0.1:PORT reuseport; root root; }
}
"""
# The same script for both. It cycles through the addresses; requests are made once, so that wrk's
# own work is small.
WRK = """
local paths, tags, extra = PATHS, TAGS, EXTRA
local requests, i = {}, 0
init = function()
    for n, path in ipairs(paths) do
        local headers = {}
        for name, value in pairs(extra) do headers[name] = value end
        if tags[n] then headers["If-None-Match"] = tags[n] end
        requests[n] = wrk.format("GET", path, headers)
    end
end
request = function() i = i % #requests + 1 return requests[i] end
done = function(summary, latency)
    local e = summary.errors
    local format = '{"requests":%d,"seconds":%.6f,"p50_ms":%.4f,"p99_ms":%.4f,"errors":%d}'
    local errors = e.connect + e.read + e.write + e.status + e.timeout
    print(string.format(format, summary.requests, summary.duration / 1e6,
        latency:percentile(50) / 1000, latency:percentile(99) / 1000, errors))
end
"""


def lua(value):
    if isinstance(value, dict):
        return "{" + ",".join(f"[{json.dumps(k)}]={json.dumps(v)}" for k, v in value.items()) + "}"
    return "{" + ",".join(json.dumps(v) for v in value) + "}"


class Nginx:
    """Static files, as fast as nginx has them."""

    def __init__(self, files):
        self.folder = temporary_folder()
        self.folder.chmod(0o755)
        for path, body in files.items():
            file = self.folder / "root" / path.lstrip("/")
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(body)
        from nginx import NGINX as program

        self.port = hold_port()
        (self.folder / "nginx.conf").write_text(NGINX.replace("PORT", str(self.port)))
        self.process = subprocess.Popen(
            [
                program,
                "-p",
                self.folder,
                "-e",
                "error.log",
                "-c",
                self.folder / "nginx.conf",
                "-g",
                "daemon off;",
            ]
        )
        until = time.monotonic() + 10
        while True:
            try:
                talk(self.port, get("/", "Connection: close"))
                return
            except OSError:
                if time.monotonic() > until:
                    raise
                time.sleep(0.02)

    def stop(self):
        self.process.terminate()
        self.process.wait(10)


def fetch(port, paths, *headers):
    out = {}
    for path in paths:
        reply = talk(port, get(path, "Connection: close", *headers), quiet_s=5).replies[0]
        if reply.status != 200:
            raise SystemExit(f"{path}: {reply}")
        out[path] = reply
    return out


def measure(port, paths, tags, extra, seconds, connections):
    script = temporary_folder() / "requests.lua"
    script.write_text(
        WRK.replace("PATHS", lua(paths)).replace("TAGS", lua(tags)).replace("EXTRA", lua(extra))
    )
    command = [
        "wrk",
        "-t2",
        f"-c{connections}",
        f"-d{seconds}s",
        "-s",
        script,
        f"http://127.0.0.1:{port}",
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"wrk: {done.stderr}")
    return json.loads(done.stdout.splitlines()[-1])


def choose(server):
    """Boxes that are not air, spread over the world."""
    solid = [p for p in server.box_paths() if server.get(p, timeout_s=60)[0] == 200]
    return [solid[i * len(solid) // BOXES] for i in range(BOXES)]


def variant(server, paths, headers, want_304, seconds, connections):
    extra = dict(h.split(": ") for h in headers)
    ours = fetch(server.port, paths, *headers)
    nginx = Nginx({path: reply.body for path, reply in ours.items()})
    try:
        theirs = fetch(nginx.port, paths)
        if any(theirs[p].body != ours[p].body for p in paths):
            raise SystemExit("nginx serves other bytes")
        tags = [
            [replies[p].headers["etag"] for p in paths] if want_304 else []
            for replies in (ours, theirs)
        ]
        if want_304 and talk(
            server.port,
            get(paths[0], "If-None-Match: " + tags[0][0], "Connection: close", *headers),
        ).statuses() != [304]:
            raise SystemExit("no 304")
        half = max(1, seconds // 2)
        runs = {"server": [], "nginx": []}
        for _ in range(2):  # in turn: what else the machine does hits both
            runs["server"].append(measure(server.port, paths, tags[0], extra, half, connections))
            runs["nginx"].append(measure(nginx.port, paths, tags[1], extra, half, connections))
    finally:
        nginx.stop()
    out = {}
    for name, of in runs.items():
        out[name] = {
            "rate": sum(r["requests"] for r in of) / sum(r["seconds"] for r in of),
            "p99_ms": max(r["p99_ms"] for r in of),
            "errors": sum(r["errors"] for r in of),
        }
    out["bytes"] = sum(len(r.body) for r in ours.values()) / len(ours)
    return out


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument(
        "--seconds", type=int, default=4, help="of wrk for each server and variant"
    )
    arguments.add_argument("--connections", type=int, default=64)
    a = arguments.parse_args()
    server = Server(*benchmark_square(), "--cache", kept_folder("cached"), "--memory-mib", "2048")
    try:
        paths = choose(server)
        figures = {
            "boxes": variant(
                server, paths, ["Accept-Encoding: zstd"], False, a.seconds, a.connections
            ),
            "304": variant(
                server, paths, ["Accept-Encoding: zstd"], True, a.seconds, a.connections
            ),
            "identity": variant(
                server, paths, ["Accept-Encoding: identity"], False, a.seconds, a.connections
            ),
        }
    finally:
        server.stop()
    print_figures(figures)


if __name__ == "__main__":
    if not shutil.which("wrk"):
        raise SystemExit("wrk is not installed (Debian package wrk)")
    main()

"""Toxiproxy (Shopify): delays and resets on the way to a port.

It makes them where the kernel has no tc netem.
"""

import hashlib
import http.client
import json
import os
import pathlib
import re
import shutil
import subprocess
import threading
import time

from farming import ENVIRONMENT, die_with_parent
from support import hold_port

_PACKAGE = "github.com/Shopify/toxiproxy/v2/cmd/server"
_HERE = pathlib.Path(__file__).resolve()
_MODULE = _HERE.parent / "toxiproxy"  # its version, and the hashes of all of its sources
_HASH = hashlib.sha256((_MODULE / "go.sum").read_bytes()).hexdigest()[:16]
_BUILT = _HERE.parents[3] / "build" / "deps" / f"toxiproxy-{_HASH}" / "toxiproxy-server"
# Of the user's settings none may leave out the comparison with go.sum, or have Go fetch another Go,
# which go.sum has no hash of. The checksum database is not needed: go.sum is complete.
_BUILDING = {
    "GOENV": "off",
    "GOFLAGS": "",
    "GOSUMDB": "off",
    "GOTOOLCHAIN": "local",
    "GOWORK": "off",
}


def _program():
    return shutil.which("toxiproxy-server") or (str(_BUILT) if _BUILT.exists() else None)


def proxy_missing():
    """Why there is no proxy; empty: there is one, built by Go if it was not there."""
    if _program():
        return ""
    go = shutil.which("go") or shutil.which("go", path="/usr/local/go/bin")
    if go is None:
        return "no toxiproxy-server, and no go to build it (Debian: golang-go)"
    _BUILT.parent.mkdir(parents=True, exist_ok=True)
    done = subprocess.run(
        [go, "build", "-mod=readonly", "-o", _BUILT, _PACKAGE],
        cwd=_MODULE,
        env={**os.environ, **_BUILDING},
        capture_output=True,
        text=True,
        timeout=900,
        check=False,
    )
    return "" if _program() else f"go build {_PACKAGE}: {done.stderr.strip()[-500:]}"


class Proxy:
    """A proxy before a port of this machine, for as long as the block lasts."""

    def __init__(self, to_port):
        # It does not report the port that it has chosen, so one is chosen for it.
        self._api = hold_port()
        self._process = subprocess.Popen(
            [_program(), "-port", str(self._api)],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env=ENVIRONMENT,
            preexec_fn=die_with_parent(),
        )
        try:
            self._wait()
            said = self._ask(
                "POST",
                "/proxies",
                {
                    "name": "farm",
                    "listen": "127.0.0.1:0",
                    "upstream": f"127.0.0.1:{to_port}",
                    "enabled": True,
                },
            )
        except Exception:
            self._process.kill()
            raise
        self.port = int(re.search(r":(\d+)$", said["listen"]).group(1))
        self.resets = 0
        self._stop = threading.Event()

    def _wait(self):
        end = time.monotonic() + 30
        while True:
            try:
                return self._ask("GET", "/version")
            except OSError:
                if time.monotonic() > end or self._process.poll() is not None:
                    raise
                time.sleep(0.02)

    def _ask(self, method, path, body=None):
        connection = http.client.HTTPConnection("127.0.0.1", self._api, timeout=10)
        connection.request(
            method,
            path,
            body=json.dumps(body) if body is not None else None,
            headers={"Content-Type": "application/json"},
        )
        reply = connection.getresponse()
        text = reply.read()
        connection.close()
        if reply.status >= 300:
            raise RuntimeError(f"toxiproxy: {method} {path}: {reply.status} {text[:200]}")
        return json.loads(text) if text else None

    def delay(self, latency_ms, jitter_ms):
        """Each way."""
        for stream in ("upstream", "downstream"):
            self._ask(
                "POST",
                "/proxies/farm/toxics",
                {
                    "type": "latency",
                    "stream": stream,
                    "attributes": {"latency": latency_ms, "jitter": jitter_ms},
                },
            )

    def reset_every(self, seconds):
        """From now on all connections are reset now and then."""

        def work():
            while not self._stop.wait(seconds):
                self._ask(
                    "POST",
                    "/proxies/farm/toxics",
                    {
                        "name": "cut",
                        "type": "reset_peer",
                        "stream": "downstream",
                        "attributes": {"timeout": 0},
                    },
                )
                self._stop.wait(0.3)
                self._ask("DELETE", "/proxies/farm/toxics/cut")
                self.resets += 1

        self._thread = threading.Thread(target=work, daemon=True)
        self._thread.start()

    def calm(self):
        self._stop.set()
        self._thread.join()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._stop.set()
        self._process.kill()
        self._process.wait()

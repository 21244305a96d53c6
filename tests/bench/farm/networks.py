"""Networks that are bad on purpose.

A namespace behind a pair of interfaces, with little bandwidth, loss, or cut off. Needs root,
iproute2, util-linux and nftables. Namespaces and their interfaces end with the process that holds
them, and that one with the bench; the next bench removes the rules that a killed one left.
"""

import atexit
import json
import os
import pathlib
import re
import shutil
import subprocess
import time
from typing import NamedTuple

from farming import die_with_parent

_TOOLS = ("ip", "tc", "nft", "ss", "unshare", "nsenter")


def networks_missing():
    """Why there can be no namespaces here; empty: there can."""
    absent = [tool for tool in _TOOLS if shutil.which(tool) is None]
    if absent:
        return "not installed: " + ", ".join(absent)
    if os.geteuid() != 0:
        return "network namespaces need root"
    tried = subprocess.run(
        ["unshare", "-n", "nft", "add table inet t"], capture_output=True, text=True, check=False
    )
    return "" if tried.returncode == 0 else f"network namespaces: {tried.stderr.strip()[-200:]}"


def _run(*command, text=None):
    done = subprocess.run(
        [str(c) for c in command], input=text, capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(str(c) for c in command)}: {done.stderr.strip()[-300:]}")
    return done.stdout


def _sweep():
    """Rules here of a bench that was killed: they hold for interfaces that are gone."""
    for found in re.finditer(r"table inet (tvb(\d+)_\d+)", _run("nft", "list", "tables")):
        if not pathlib.Path("/proc", found.group(2)).exists():
            _run("nft", "delete", "table", "inet", found.group(1))


class Namespace:
    """A separate machine as far as the network is concerned.

    The bench is at `here`; programs that are run with `prefix` are at `there`.
    """

    _next = 0

    def __init__(self):
        Namespace._next += 1
        number = Namespace._next
        _sweep()
        self._holder = subprocess.Popen(
            ["unshare", "-n", "sleep", "infinity"], preexec_fn=die_with_parent()
        )
        atexit.register(self.remove)
        own = pathlib.Path("/proc/self/ns/net").readlink()
        end = time.monotonic() + 10
        theirs = pathlib.Path(f"/proc/{self._holder.pid}/ns/net")
        while theirs.readlink() == own:  # the namespace does not exist yet
            if time.monotonic() > end:
                raise RuntimeError("unshare -n: no namespace within 10 s")
            time.sleep(0.01)
        self.prefix = ("nsenter", "-t", str(self._holder.pid), "-n")
        # Of the net that is kept for benchmarks of networks (RFC 2544).
        process = os.getpid() % 250
        self.here = f"198.18.{process}.{4 * number + 1}"
        self.there = f"198.18.{process}.{4 * number + 2}"
        self._link = f"tvb{os.getpid()}-{number}"[:15]
        self._far_link = "tvb0"
        _run(
            "ip",
            "link",
            "add",
            self._link,
            "type",
            "veth",
            "peer",
            "name",
            self._far_link,
            "netns",
            self._holder.pid,
        )
        _run("ip", "address", "add", self.here + "/30", "dev", self._link)
        _run("ip", "link", "set", self._link, "up")
        self._inside("ip", "address", "add", self.there + "/30", "dev", self._far_link)
        self._inside("ip", "link", "set", self._far_link, "up")
        # A packet is one of the wire: otherwise the kernel would pass 64 KiB as one, and lose them
        # as one.
        _run("ip", "link", "set", "dev", self._link, "gso_max_segs", "1")
        self._inside("ip", "link", "set", "dev", self._far_link, "gso_max_segs", "1")
        self._inside("ip", "link", "set", "lo", "up")

    def _inside(self, *command, text=None):
        return _run(*self.prefix, *command, text=text)

    def remove(self):
        self._holder.kill()
        self._holder.wait()
        atexit.unregister(self.remove)

    def cut_off(self):
        """All packets are dropped silently, both ways."""
        self._filter("drop")

    def lose(self, percent):
        """So many packets of a hundred are dropped, each way; the link has counted them before."""
        self._filter(f"numgen random mod 100 < {percent} drop")

    def _filter(self, rule):
        # In the input hook: in the output hook the sender would get an error.
        self.heal()
        self._inside(
            "nft",
            "-f",
            "-",
            text=f"""table inet faults {{
            chain in {{ type filter hook input priority 0; iifname "{self._far_link}" {rule}; }}
        }}""",
        )
        _run(
            "nft",
            "-f",
            "-",
            text=f"""table inet {self._link.replace("-", "_")} {{
            chain in {{ type filter hook input priority 0; iifname "{self._link}" {rule}; }}
        }}""",
        )
        atexit.register(self.heal)

    def heal(self):
        for command in (
            (*self.prefix, "nft", "delete table inet faults"),
            ("nft", f"delete table inet {self._link.replace('-', '_')}"),
        ):
            subprocess.run(
                command, capture_output=True, check=False
            )  # where there is none it fails
        atexit.unregister(self.heal)

    def limit(self, mbit_per_s):
        """Bandwidth, each way."""
        for inside, link in ((False, self._link), (True, self._far_link)):
            command = (
                "tc",
                "qdisc",
                "replace",
                "dev",
                link,
                "root",
                "tbf",
                "rate",
                f"{mbit_per_s}mbit",
                "burst",
                "32kb",
                "latency",
                "100ms",
            )
            self._inside(*command) if inside else _run(*command)

    def link_bytes(self):
        """(from there to here, from here to there), headers and what is sent again included."""
        stats = json.loads(_run("ip", "-j", "-s", "link", "show", "dev", self._link))[0]["stats64"]
        return stats["rx"]["bytes"], stats["tx"]["bytes"]

    def payload(self, port):
        """Of the connections of a program there that listens at `port`."""
        out = Payload(0, 0, 0)
        for line in self._inside("ss", "-tinHO", f"sport = :{port}").splitlines():
            words = dict(w.split(":", 1) for w in line.split() if w.count(":") == 1)
            out = Payload(
                *(
                    sum(pair)
                    for pair in zip(
                        out,
                        (
                            int(words.get(w, 0))
                            for w in ("bytes_acked", "bytes_received", "bytes_retrans")
                        ),
                    )
                )
            )
        return out


class Payload(NamedTuple):
    """Bytes: each once, but those that are sent again."""

    confirmed: int  # of what it sent
    received: int
    again: int

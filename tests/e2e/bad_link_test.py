#!/usr/bin/env python3
"""Links that are slow, narrow, lossy, cut and silent, without root.

The farm, the box server and archives over HTTP make the same picture through them.
"""

import concurrent.futures
import contextlib
import json
import random
import re
import socket
import socketserver
import threading
import unittest
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

from bad_link import RESET, SILENT_BACK, SILENT_BOTH, SILENT_FORTH, BadLink
from support import (
    HANGS_S,
    Case,
    Program,
    Run,
    Server,
    binary,
    hold_port,
    survey,
    temporary_folder,
    wait_until,
)

TOKEN = "kv7r2mx9q4tz8wpd5hcnb3fj6gy1ks7a"
DEFAULTS = {"TERRAVOX_FARM_TOKEN": TOKEN, "TERRAVOX_FARM_TEST": "0"}
SHORT_TIMES = {"TERRAVOX_FARM_TOKEN": TOKEN, "TERRAVOX_FARM_TEST": "1"}


class Echo(socketserver.ThreadingTCPServer):
    """Sends back what comes."""

    daemon_threads = True

    class Handler(socketserver.BaseRequestHandler):
        def handle(self):
            with contextlib.suppress(ConnectionError):
                while data := self.request.recv(1 << 16):
                    self.request.sendall(data)

    def __init__(self):
        super().__init__(("127.0.0.1", 0), self.Handler)
        threading.Thread(target=self.serve_forever, daemon=True).start()

    @property
    def port(self):
        return self.server_address[1]


class TheLinkItself(Case):
    def setUp(self):
        self.echo = Echo()
        self.addCleanup(self.echo.server_close)
        self.addCleanup(self.echo.shutdown)

    def through(self, link, data):
        """@return what came back, and whether it ended with a reset"""
        got = bytearray()
        resets = []

        def send():
            try:
                connection.sendall(data)
                connection.shutdown(socket.SHUT_WR)
            except OSError as e:  # the kernel reports a reset once: here or below
                resets.append(e)

        try:
            connection = socket.create_connection(("127.0.0.1", link.port), timeout=HANGS_S)
        except ConnectionResetError:  # before this program knew that it was connected
            return b"", True
        with connection:
            sender = threading.Thread(target=send)
            sender.start()
            try:
                while more := connection.recv(1 << 16):
                    got += more
            except ConnectionResetError as e:
                resets.append(e)
            sender.join()
        return bytes(got), bool(resets)

    def test_bytes_stay_as_they_are_and_what_happens_follows_from_the_seed(self):
        data = random.Random(1).randbytes(20_000)
        seen = []
        for seed in (1, 1, 2):
            with BadLink(
                self.echo.port,
                seed,
                delay_s=(0.001, 0.005),
                stall_every_bytes=4000,
                stall_s=0.01,
                piece_bytes=(1, 7),
                bytes_per_s=200_000,
            ) as link:
                self.assertEqual(self.through(link, data), (data, False))
                seen.append(
                    {
                        name: link.counts[name]
                        for name in ("connections", "bytes_forth", "bytes_back", "stalls")
                    }
                )
                self.assertGreater(link.counts["pieces"], 2 * len(data) // 7)
                self.assertGreater(link.counts["delayed"], 0)
        self.assertEqual(seen[0], seen[1])
        self.assertNotEqual(seen[0]["stalls"], seen[2]["stalls"])
        self.assertEqual((seen[0]["bytes_forth"], seen[0]["bytes_back"]), (len(data), len(data)))

    def test_a_reset_is_one_and_comes_where_the_seed_says(self):
        data = bytes(50_000)
        with BadLink(self.echo.port, 5, fates=(RESET, RESET), fate_bytes=(100, 20_000)) as link:
            for _ in range(2):
                got, reset = self.through(link, data)
                self.assertTrue(reset)
                self.assertLess(len(got), len(data))
            self.assertEqual(self.through(link, data), (data, False))
            self.assertEqual(link.counts[RESET], 2)

    def test_a_silence_carries_nothing_one_way_and_what_was_held_comes_when_it_ends(self):
        data = bytes(50_000)
        for fate in (SILENT_FORTH, SILENT_BACK, SILENT_BOTH):
            with (
                self.subTest(fate),
                BadLink(
                    self.echo.port, 3, fates=(fate,), fate_bytes=(1000, 1000), silent_s=0.2
                ) as link,
            ):
                self.assertEqual(self.through(link, data), (data, False))
                self.assertEqual(link.counts[fate], 1)
            with (
                self.subTest(fate, lasts=True),
                BadLink(self.echo.port, 3, fates=(fate,), fate_bytes=(1000, 1000)) as link,
            ):
                with socket.create_connection(
                    ("127.0.0.1", link.port), timeout=HANGS_S
                ) as connection:
                    connection.sendall(data)
                    wait_until(lambda link=link, fate=fate: link.counts[fate] == 1, "the silence")
                    connection.settimeout(0.2)  # what has come before it
                    got = 0
                    with contextlib.suppress(TimeoutError):
                        while got < len(data):
                            got += len(connection.recv(1 << 16))
                self.assertLess(got, len(data))

    def test_nobody_at_the_far_end_is_a_reset(self):
        with BadLink(hold_port(), 1) as link:
            self.assertEqual(self.through(link, b"hello"), (b"", True))


class FileServer(ThreadingHTTPServer):
    """One file, whole or parts of it, as any web server has it."""

    daemon_threads = True

    def __init__(self, data):
        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def do_GET(self):
                requested = re.fullmatch(r"bytes=(\d+)-(\d+)", self.headers.get("Range", ""))
                begin, end = (
                    (int(requested[1]), min(int(requested[2]) + 1, len(data)))
                    if requested
                    else (0, len(data))
                )
                self.send_response(206 if requested else 200)
                if requested:
                    self.send_header("Content-Range", f"bytes {begin}-{end - 1}/{len(data)}")
                self.send_header("Content-Length", str(end - begin))
                self.end_headers()
                self.wfile.write(data[begin:end])

            def log_message(self, *_):
                pass

        super().__init__(("127.0.0.1", 0), Handler)
        threading.Thread(target=self.serve_forever, daemon=True).start()

    def handle_error(self, *_):
        pass  # connections that are reset: what they are here for


class Rendering(Case):
    @classmethod
    def setUpClass(cls):
        cls.out = temporary_folder()
        cls.wanted = cls.picture(survey(), "wanted.png")

    @classmethod
    def picture(cls, world, name, *arguments):
        run = Run(
            [
                binary("RAYTRACER"),
                "render",
                world,
                *cls.PICTURE,
                *arguments,
                "--quiet",
                "-o",
                cls.out / name,
            ]
        )
        if run.code != 0:
            raise AssertionError(str(run))
        return (cls.out / name).read_bytes()

    def assert_happened(self, link, **least):
        """A fault that has not happened has tried nothing."""
        for name, count in least.items():
            name = name.replace("_", " ") if name.startswith("silent") else name
            self.assertGreaterEqual(link.counts[name], count, f"{name}: {dict(link.counts)}")


class Farm(Rendering):
    PICTURE = ["--size", "96x54", "--tile", "16", "--samples", "2"]
    TILES = 6 * 4

    def program(self, *arguments, environment=DEFAULTS):
        program = Program(*arguments, environment=environment)
        self.addCleanup(program.process.stdout.close)
        self.addCleanup(program.kill)
        return program

    def coordinator(self, name, *arguments, **options):
        return self.program(
            "render",
            survey(),
            *self.PICTURE,
            "--threads",
            "0",
            "--report",
            self.out / f"{name}.json",
            "-o",
            self.out / f"{name}.png",
            *arguments,
            **options,
        )

    def by_worker(self, name, seed, environment=DEFAULTS, **faults):
        """A picture by one worker that is dialled through a link with these faults.

        @return the link after the picture, and the report
        """
        worker = self.program(
            "worker", "--listen", "127.0.0.1:0", "--threads", "1", environment=environment
        )
        port = int(worker.saw(r"on port (\d+)").group(1))
        with BadLink(port, seed, **faults) as link:
            coordinator = self.coordinator(
                name, "--worker", f"127.0.0.1:{link.port}", environment=environment
            )
            return link, self.check(coordinator, name)

    def check(self, coordinator, name):
        self.assertEqual(coordinator.end(), 0, coordinator.log())
        self.assertTrue(
            (self.out / f"{name}.png").read_bytes() == self.wanted,
            f"another picture\n{coordinator.log()}",
        )
        report = json.loads((self.out / f"{name}.json").read_text())
        self.assertEqual(
            (report["tiles"], report["tiles_missing"], report["holes"]), (self.TILES, 0, 0), report
        )
        return report

    def test_a_worker_behind_a_slow_link_that_stalls(self):
        link, _ = self.by_worker(
            "slow", 11, delay_s=(0.05, 0.15), stall_every_bytes=15_000, stall_s=1
        )
        self.assert_happened(link, delayed=10, stalls=2)

    def test_frames_that_come_in_pieces_of_some_bytes(self):
        link, _ = self.by_worker("pieces", 12, piece_bytes=(1, 7))
        self.assert_happened(link, pieces=10_000)

    def test_connections_that_are_reset_at_any_byte(self):
        # From the handshake, whose parts have a few dozen bytes, to the middle of the boxes and
        # tiles.
        for name, most in (("handshake", 300), ("picture", 12_000)):
            with self.subTest(name):
                link, _ = self.by_worker(
                    name, 13, environment=SHORT_TIMES, fates=[RESET] * 3, fate_bytes=(1, most)
                )
                self.assert_happened(link, reset=3, connections=4)

    def test_a_connection_that_falls_silent_is_given_up_and_made_again(self):
        link, report = self.by_worker(
            "silent",
            14,
            environment=SHORT_TIMES,
            fates=[SILENT_BACK, SILENT_FORTH, SILENT_BOTH],
            fate_bytes=(1000, 12_000),
        )
        self.assert_happened(link, silent_back=1, silent_forth=1, silent_both_ways=1, connections=4)
        self.assertGreaterEqual(report["farm"]["lost"], 1, report)

    def test_a_worker_that_joins_through_a_narrow_link_with_resets(self):
        coordinator = self.coordinator("join", "--listen", "127.0.0.1:0", environment=SHORT_TIMES)
        port = int(coordinator.saw(r"on port (\d+)").group(1))
        with BadLink(
            port, 15, bytes_per_s=100_000, fates=[RESET, RESET], fate_bytes=(1, 12_000)
        ) as link:
            self.program(
                "worker",
                "--join",
                f"127.0.0.1:{link.port}",
                "--threads",
                "1",
                environment=SHORT_TIMES,
            )
            self.check(coordinator, "join")
            self.assert_happened(link, reset=2, connections=3)


class Boxes(Rendering):
    PICTURE = ["--size", "320x180", "--samples", "1"]
    FAULTS = {
        "slow, with stalls": (
            {"delay_s": (0.05, 0.15), "stall_every_bytes": 40_000, "stall_s": 1},
            {"delayed": 10, "stalls": 1},
        ),
        "in pieces": ({"piece_bytes": (1, 7)}, {"pieces": 10_000}),
        "narrow": ({"bytes_per_s": 50_000}, {}),
        # Fewer than there are tries of a box, should all meet the same one.
        "reset": ({"fates": [RESET] * 3, "fate_bytes": (1, 4000)}, {"reset": 3}),
        "silent for a while": (
            {
                "fates": [SILENT_BACK, SILENT_FORTH, SILENT_BOTH],
                "fate_bytes": (1, 4000),
                "silent_s": 1,
            },
            {"silent_back": 1, "silent_forth": 1, "silent_both_ways": 1},
        ),
    }

    def through_each(self, port, path):
        def work(seed, faults):
            with BadLink(port, seed, **faults) as link:
                return link, self.picture(f"http://127.0.0.1:{link.port}{path}", f"far-{seed}.png")

        # At once, since they mostly wait.
        with concurrent.futures.ThreadPoolExecutor(len(self.FAULTS)) as pool:
            tried = {
                name: pool.submit(work, seed, faults)
                for seed, (name, (faults, _)) in enumerate(self.FAULTS.items())
            }
        for name, (_, happened) in self.FAULTS.items():
            with self.subTest(name):
                link, made = tried[name].result()
                self.assertTrue(made == self.wanted, "another picture")
                self.assert_happened(link, **happened)

    def test_from_a_voxel_server(self):
        server = Server(survey())
        self.addCleanup(server.stop)
        self.through_each(server.port, "")

    def test_from_an_archive_over_http(self):
        archive = self.out / "world.tvx"
        made = Run([binary("RAYTRACER"), "convert", survey(), archive])
        self.assertDone(made)
        server = FileServer(archive.read_bytes())
        self.addCleanup(server.server_close)
        self.addCleanup(server.shutdown)
        self.through_each(server.server_port, "/world.tvx")


if __name__ == "__main__":
    unittest.main()

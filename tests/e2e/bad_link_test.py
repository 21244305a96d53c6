#!/usr/bin/env python3
"""Links that are cut, silent, and pass some bytes at a time, without root.

The farm, the box server and archives over HTTP make the same picture through them.
"""

import concurrent.futures
import json
import unittest

from bad_link import RESET, SILENT_BACK, SILENT_BOTH, SILENT_FORTH, BadLink
from static_host import StaticHost
from support import (
    Case,
    Program,
    Run,
    Server,
    binary,
    survey,
    temporary_folder,
)

TOKEN = "kv7r2mx9q4tz8wpd5hcnb3fj6gy1ks7a"
DEFAULTS = {"TERRAVOX_FARM_TOKEN": TOKEN, "TERRAVOX_FARM_TEST": "0"}
SHORT_TIMES = {"TERRAVOX_FARM_TOKEN": TOKEN, "TERRAVOX_FARM_TEST": "1"}


class Rendering(Case):
    @classmethod
    def setUpClass(cls):
        cls.out = temporary_folder()
        cls.wanted = cls.picture(survey(), "wanted.png")

    @classmethod
    def picture(cls, world, name, *arguments):
        words = ["render", world, *cls.PICTURE, *arguments, "--quiet", "-o", cls.out / name]
        run = Run([binary("RAYTRACER"), *words])
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
        made = ["--report", self.out / f"{name}.json", "-o", self.out / f"{name}.png"]
        words = ["render", survey(), *self.PICTURE, "--threads", "0", *made, *arguments]
        return self.program(*words, **options)

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

    def test_a_worker_that_joins_through_a_link_with_resets(self):
        coordinator = self.coordinator("join", "--listen", "127.0.0.1:0", environment=SHORT_TIMES)
        port = int(coordinator.saw(r"on port (\d+)").group(1))
        with BadLink(port, 15, fates=[RESET, RESET], fate_bytes=(1, 12_000)) as link:
            words = ["worker", "--join", f"127.0.0.1:{link.port}", "--threads", "1"]
            self.program(*words, environment=SHORT_TIMES)
            self.check(coordinator, "join")
            self.assert_happened(link, reset=2, connections=3)


class Boxes(Rendering):
    PICTURE = ["--size", "320x180", "--samples", "1"]
    FAULTS = {
        "in pieces": ({"piece_bytes": (1, 7)}, {"pieces": 10_000}),
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
        host = StaticHost(self.out)
        self.addCleanup(host.stop)
        self.through_each(host.server.server_port, "/world.tvx")


if __name__ == "__main__":
    unittest.main()

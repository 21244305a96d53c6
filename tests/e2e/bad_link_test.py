#!/usr/bin/env python3
"""The farm makes the same picture through links that are cut and silent, without root.

Of boxes and archives over HTTP: tests/voxelserver/make/worlds/{remote,archive}.
"""

import json
import unittest

from bad_link import RESET, SILENT_BACK, SILENT_BOTH, SILENT_FORTH, BadLink
from support import FARM_TOKEN, Case, Program, make, survey, temporary_folder

SHORT_TIMES = {"TERRAVOX_FARM_TOKEN": FARM_TOKEN, "TERRAVOX_FARM_TEST": "1"}


class Farm(Case):
    PICTURE = ["--size", "96x54", "--tile", "16", "--samples", "2"]
    TILES = 6 * 4

    @classmethod
    def setUpClass(cls):
        cls.out = temporary_folder()
        file = cls.out / "wanted.png"
        make("RAYTRACER", "render", survey(), *cls.PICTURE, "--quiet", "-o", file)
        cls.wanted = file.read_bytes()

    def assert_happened(self, link, **least):
        """A fault that has not happened has tried nothing."""
        for name, count in least.items():
            name = name.replace("_", " ") if name.startswith("silent") else name
            self.assertGreaterEqual(link.counts[name], count, f"{name}: {dict(link.counts)}")

    def program(self, *arguments):
        return Program(*arguments, environment=SHORT_TIMES, test=self)

    def coordinator(self, name, *arguments):
        made = ["--report", self.out / f"{name}.json", "-o", self.out / f"{name}.png"]
        words = ["render", survey(), *self.PICTURE, "--threads", "0", *made, *arguments]
        return self.program(*words)

    def by_worker(self, name, seed, **faults):
        """A picture by one worker that is dialled through a link with these faults.

        @return the link after the picture, and the report
        """
        worker = self.program("worker", "--listen", "127.0.0.1:0", "--threads", "1")
        with BadLink(worker.port(), seed, **faults) as link:
            coordinator = self.coordinator(name, "--worker", f"127.0.0.1:{link.port}")
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

    def test_connections_that_are_reset_at_any_byte(self):
        # From the handshake, whose parts have a few dozen bytes, to the middle of the boxes and
        # tiles.
        for name, most in (("handshake", 300), ("picture", 12_000)):
            with self.subTest(name):
                link, _ = self.by_worker(name, 13, fates=[RESET] * 3, fate_bytes=(1, most))
                self.assert_happened(link, reset=3, connections=4)

    def test_a_connection_that_falls_silent_is_given_up_and_made_again(self):
        link, report = self.by_worker(
            "silent",
            14,
            fates=[SILENT_BACK, SILENT_FORTH, SILENT_BOTH],
            fate_bytes=(1000, 12_000),
        )
        self.assert_happened(link, silent_back=1, silent_forth=1, silent_both_ways=1, connections=4)
        self.assertGreaterEqual(report["farm"]["lost"], 1, report)

    def test_a_worker_that_joins_through_a_link_with_resets(self):
        coordinator = self.coordinator("join", "--listen", "127.0.0.1:0")
        port = coordinator.port()
        with BadLink(port, 15, fates=[RESET, RESET], fate_bytes=(1, 12_000)) as link:
            words = ["worker", "--join", f"127.0.0.1:{link.port}", "--threads", "1"]
            self.program(*words)
            self.check(coordinator, "join")
            self.assert_happened(link, reset=2, connections=3)


if __name__ == "__main__":
    unittest.main()

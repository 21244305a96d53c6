#!/usr/bin/env python3
"""Full disks (ENOSPC), not only files with a size limit.

For each writer, the cache of the server, and the store of the grabber. Required: exit code 1 and a
line that names the file, no partial file, and once there is room the next run continues to the same
bytes.
"""

import contextlib
import os
import shutil
import unittest

from small_disk import PAGE_BYTES, SmallDisk, why_not
from support import ROOT, Run, Server, make_survey, temporary_folder
from writers import WRITERS, Writers, ended

REASON = why_not()
NODE = shutil.which(os.environ.get("TERRAVOX_NODE") or "node")
GRABBER = ROOT / "grabber" / "dist" / "main.js"
GIB_PAGES = (1 << 30) // PAGE_BYTES


@unittest.skipIf(REASON, REASON)
class FullDisk(Writers):
    def test_each_writer_reports_it_and_leaves_nothing_half_written(self):
        for name in WRITERS:
            pages = self.whole_pages(name, PAGE_BYTES)
            for free in sorted({0, pages // 2, pages - 1}):
                with self.subTest(name, free_pages=free, of=pages), SmallDisk(free) as disk:
                    arguments, _ = self.writer(name, disk.folder)
                    run = ended(arguments, within=disk.within)
                    self.assertEqual(run.code, 1, str(run))
                    self.assert_told(run, name)
                    self.assertIn(str(disk.folder), run.last)
                    self.assert_nothing_half_written(name, run, disk.seen)
                    # A writer that leaves nothing begins anew, wherever it failed: once is enough.
                    if not WRITERS[name].left and free != pages // 2:
                        continue
                    disk.leave(GIB_PAGES)
                    again = ended(arguments, within=disk.within)
                    self.assertEqual(again.code, 0, f"once there is room: {again}")
                    self.assert_as_on_a_good_day(name, disk.seen)

    def test_a_server_serves_on_and_keeps_boxes_once_there_is_room(self):
        with contextlib.ExitStack() as stack:
            usual = Server(self.data, "--cache", "none")
            stack.callback(usual.stop)
            paths = usual.box_paths()
            boxes = {path: usual.get(path)[::2] for path in paths}
        for free in (0, 8, 64):
            with self.subTest(free_pages=free), SmallDisk(free) as disk:
                for room in (False, True):
                    if room:
                        disk.leave(GIB_PAGES)
                    with Server(self.data, "--cache", disk.folder, program=disk.within) as server:
                        self.assertEqual({path: server.get(path)[::2] for path in paths}, boxes)
                with Server(self.data, "--cache", disk.folder, program=disk.within) as again:
                    self.assertEqual({path: again.get(path)[::2] for path in paths}, boxes)
                    self.assertGreater(
                        again.json("/v2/stats")["disk"]["hits"],
                        0,
                        "nothing was kept though there was room",
                    )


@unittest.skipIf(REASON, REASON)
@unittest.skipUnless(NODE and GRABBER.exists(), f"no node, or no {GRABBER.relative_to(ROOT)}")
class FullDiskOfTheGrabber(Writers):
    @classmethod
    def setUpClass(cls):
        cls.survey = make_survey(temporary_folder() / "survey", "1x1", 1000, 0.1)
        cls.square = (cls.survey / "TM_462_101.laz").read_bytes()

    def fetch(self, disk, *arguments):
        run = Run(
            [*disk.within, NODE, GRABBER, "fetch", *arguments, "--store", disk.folder / "store"]
        )
        if run.code == 1:
            self.assertIn(str(disk.folder / "store"), run.err, str(run))
        return run

    def kept(self, disk):
        """Names and bytes of the squares that are there under their names."""
        return {path.name: path.read_bytes() for path in (disk.seen / "store").rglob("*.laz")}

    def test_a_disk_that_is_full_before_anything_is_fetched(self):
        for free in (0, 1, 12, 24, 60):
            with self.subTest(free_pages=free), SmallDisk(free) as disk:
                full = self.fetch(disk, "--from", self.survey)
                self.assertEqual(full.code, 1, str(full))
                self.assertEqual(self.kept(disk), {})
                disk.leave(GIB_PAGES)
                self.assertDone(self.fetch(disk, "--from", self.survey))
                self.assertEqual(self.kept(disk), {"TM_462_101.laz": self.square})


if __name__ == "__main__":
    unittest.main()

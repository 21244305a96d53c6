#!/usr/bin/env python3
"""Pictures that were cut off go on where they were; pictures of several coordinators become one."""

import json
import pathlib
import resource
import shutil
import signal
import struct
import subprocess
import time
import unittest

from pictures import Picture
from support import (
    HANGS_S,
    Case,
    Run,
    binary,
    entries,
    only_in_all,
    render,
    square,
    temporary_folder,
)

COLUMNS = 20
ROWS = 12
TILE = 16
TILES = COLUMNS * ROWS
PICTURE = ["--size", f"{COLUMNS * TILE}x{ROWS * TILE}", "--tile", str(TILE), "--samples", "16"]
FLAGS = [*PICTURE, "--look", "plain", "--quiet"]
LAYERS = [*FLAGS, "--layers", "all"]


def merge(*arguments):
    return Run([binary("RAYTRACER"), "merge", *arguments])


def records(journal):
    """@return (kind, cell, offset of its bytes, their number) of each complete record

    The format is in docs/formats/checkpoints.md.
    """
    data = pathlib.Path(journal).read_bytes()
    _, _, text_bytes, _ = struct.unpack_from("<8sIIQ", data)
    at = 24 + text_bytes
    out = []
    while at + 32 <= len(data):
        marker, kind, cell, size, _, _ = struct.unpack_from("<IIIIQQ", data, at)
        if marker != 0x9E01C57A:
            raise AssertionError(f"{journal}: no record at byte {at}")
        if at + 32 + size > len(data):
            break
        out.append((kind, cell, at + 32, size))
        at += 32 + size
    return out


def cells(journal):
    return [cell for kind, cell, _, _ in records(journal) if kind == 1]


class Resume(Case):
    @classmethod
    def setUpClass(cls):
        """The picture, made in one go."""
        cls.whole = temporary_folder()
        render(
            square(), *FLAGS, "-o", cls.whole / "whole.exr", "-o", cls.whole / "whole.png"
        ).done()

    def setUp(self):
        self.out = temporary_folder()
        self.picture = self.out / "a.exr"
        self.journal = self.out / "a.exr.tiles"

    def resume(self, *flags, **options):
        words = [*FLAGS, "--resume", "--report", self.out / "report.json", *flags]
        return render(square(), *words, "-o", self.picture, **options)

    def report(self):
        return json.loads((self.out / "report.json").read_text())

    def begun(self, *flags, most_bytes=None):
        """@param most_bytes a larger file kills the coordinator, in the middle of the write"""

        def limit():
            if most_bytes is not None:
                resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
                resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, most_bytes))

        words = ["render", square(), *FLAGS, "--resume", *flags, "-o", self.picture]
        return subprocess.Popen(
            [binary("RAYTRACER"), *words],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            preexec_fn=limit,
        )

    def grown(self, child, size):
        """Waits until the checkpoint has that size.

        @return whether the coordinator is still running
        """
        deadline = time.monotonic() + HANGS_S
        while time.monotonic() < deadline:
            if child.poll() is not None:
                return False
            try:
                if self.journal.stat().st_size >= size:
                    return True
            except FileNotFoundError:
                pass
            time.sleep(0.001)
        child.kill()
        child.communicate()
        raise AssertionError(f"the checkpoint has not grown to {size} bytes")

    def killed(self, size, *flags):
        """Runs a coordinator that is killed when its checkpoint would exceed that size.

        It does not depend on the speed of the coordinator and of this test.

        @return its exit code
        """
        child = self.begun(*flags, most_bytes=size)
        _, self.said = child.communicate(timeout=HANGS_S)
        return child.returncode

    def cut_off(self, size, how):
        """Sends a coordinator a signal some time after its checkpoint has that size.

        @return its exit code
        """
        child = self.begun()
        if self.grown(child, size):
            child.send_signal(how)
        _, self.said = child.communicate(timeout=HANGS_S)
        return child.returncode

    def assertWhole(self, picture=None):
        self.assertAlike(self.whole / "whole.exr", picture or self.picture, exact=True)

    def half_done(self, *flags):
        """A checkpoint with some of the tiles. @return how many"""
        self.assertEqual(self.killed(100_000, *flags), -signal.SIGXFSZ, self.said)
        self.assertTrue(self.journal.exists(), "the picture was made at once")
        count = len(set(cells(self.journal)))
        self.assertGreater(count, 0)
        self.assertLess(count, TILES)
        return count

    def test_at_a_signal_to_stop_it_keeps_what_it_has(self):
        self.assertEqual(self.cut_off(60_000, signal.SIGTERM), 1, self.said)
        self.assertFalse(self.picture.exists())
        before = len(cells(self.journal))
        self.assertGreater(before, 0)
        self.assertDone(self.resume())
        self.assertEqual(self.report()["tiles_resumed"], before)
        self.assertWhole()

    @only_in_all
    def test_a_picture_that_streams_goes_on_too(self):
        flags = ["--memory-mib", "2"]  # its film would take 1.6 MiB
        before = self.half_done(*flags)
        self.assertDone(self.resume(*flags))
        self.assertEqual(self.report()["tiles_resumed"], before)
        self.assertEqual(Picture(self.picture).tile, [TILE, TILE])
        self.assertWhole()

    @only_in_all
    def test_without_the_option_nothing_is_kept_and_at_the_end_nothing_is_left(self):
        self.assertDone(render(square(), *FLAGS, "-o", self.out / "b.exr"))
        self.assertDone(self.resume())
        self.assertEqual(entries(self.out), ["a.exr", "b.exr", "report.json"])
        self.assertEqual(self.report()["tiles_resumed"], 0)
        self.assertEqual(self.report()["tiles"], TILES)


class Merge(Case):
    @classmethod
    def setUpClass(cls):
        cls.made = temporary_folder()
        outputs = ["-o", cls.made / "whole.exr", "-o", cls.made / "whole.png"]
        render(square(), *LAYERS, *outputs).done()
        cls.parts = []
        for part in ("1/2", "2/2"):
            outputs = ["-o", cls.made / "a.exr", "-o", cls.made / "a.png"]
            report = ["--report", cls.made / f"{part[0]}.json"]
            render(square(), *LAYERS, "--part", part, *outputs, *report).done()
            cls.parts.append(cls.made / f"a.exr.part-{part[0]}-of-2.tiles")

    def setUp(self):
        self.out = temporary_folder()

    def test_two_halves_make_the_whole(self):
        self.assertDone(
            merge(*self.parts, "-o", self.out / "a.exr", "-o", self.out / "a.png", "--quiet")
        )
        self.assertAlike(self.made / "whole.exr", self.out / "a.exr", exact=True)
        whole = Picture(self.made / "whole.exr")
        joined = Picture(self.out / "a.exr")
        self.assertEqual(whole.names, joined.names)
        self.assertTrue(whole.bytes == joined.bytes)
        self.assertEqual((self.made / "whole.png").read_bytes(), (self.out / "a.png").read_bytes())
        for key, value in joined.metadata.items():
            if key.startswith("terravox:"):
                self.assertEqual(whole.metadata[key], value, key)

    def test_half_of_it_is_no_picture(self):
        run = merge(
            self.parts[0], "-o", self.out / "a.exr", "--tiles", self.out / "half.tiles", "--quiet"
        )
        self.assertRefused(
            run, 1, f"{TILES // 2} of {TILES} tiles are missing", f"in rows 1 to {ROWS} of {ROWS}"
        )
        self.assertEqual(entries(self.out), ["half.tiles"])
        self.assertEqual(set(cells(self.out / "half.tiles")), set(cells(self.parts[0])))
        # The existing tiles can be resumed from.
        shutil.move(self.out / "half.tiles", self.out / "b.exr.tiles")
        made = ["-o", self.out / "b.exr", "--report", self.out / "r.json"]
        self.assertDone(render(square(), *LAYERS, "--resume", *made))
        self.assertEqual(json.loads((self.out / "r.json").read_text())["tiles_resumed"], TILES // 2)
        self.assertTrue(Picture(self.out / "b.exr").bytes == Picture(self.made / "whole.exr").bytes)

    def test_what_cannot_be_joined(self):
        other = self.out / "other.exr"
        self.assertDone(render(square(), *LAYERS, "--fov", "50", "--part", "2/2", "-o", other))
        self.assertRefused(
            merge(self.parts[0], f"{other}.part-2-of-2.tiles", "-o", self.out / "a.exr"),
            1,
            "of another picture",
            "camera.fov_deg = 40.0 there, 50.0 here",
        )
        self.assertRefused(merge(*self.parts), 2, "-o FILE.exr")
        self.assertRefused(merge("-o", self.out / "a.exr"), 2)
        self.assertNotIn("a.exr", entries(self.out))

    def test_parts_are_written_i_of_n(self):
        run = render(square(), *FLAGS, "--part", "3/2", "-o", self.out / "a.exr")
        self.assertRefused(run, 2, "3/2", "allowed: I/N")


if __name__ == "__main__":
    unittest.main()

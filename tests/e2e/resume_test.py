#!/usr/bin/env python3
"""Pictures that were cut off go on where they were; pictures of several coordinators become one."""

import collections
import json
import pathlib
import random
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
FLAGS = [*PICTURE, "--quiet"]


def flags_with(flag, value):
    """FLAGS with another value."""
    out = list(FLAGS)
    out[out.index(flag) + 1] = value
    return out


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
        run = render(square(), *FLAGS, "-o", cls.whole / "whole.exr", "-o", cls.whole / "whole.png")
        if run.code != 0:
            raise AssertionError(str(run))

    def setUp(self):
        self.out = temporary_folder()
        self.picture = self.out / "a.exr"
        self.journal = self.out / "a.exr.tiles"

    def resume(self, *flags, **options):
        return render(
            square(),
            *FLAGS,
            "--resume",
            "--report",
            self.out / "report.json",
            *flags,
            "-o",
            self.picture,
            **options,
        )

    def report(self):
        return json.loads((self.out / "report.json").read_text())

    def begun(self, *flags, most_bytes=None):
        """@param most_bytes a larger file kills the coordinator, in the middle of the write"""

        def limit():
            if most_bytes is not None:
                resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
                resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, most_bytes))

        return subprocess.Popen(
            [
                binary("RAYTRACER"),
                "render",
                square(),
                *FLAGS,
                "--resume",
                *flags,
                "-o",
                self.picture,
            ],
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

    @only_in_all
    def test_killed_at_any_time_it_goes_on_and_no_finished_tile_is_rendered_again(self):
        self.assertDone(render(square(), *FLAGS, "--part", "1/1", "-o", self.out / "size.exr"))
        full = (self.out / "size.exr.part-1-of-1.tiles").stat().st_size
        chance = random.Random(20)
        # In the middle of a record, and then anywhere.
        for target in sorted(chance.randrange(0, int(0.6 * full)) for _ in range(15)):
            self.assertEqual(self.killed(target), -signal.SIGXFSZ, self.said)
            self.assertFalse(self.picture.exists())
            if self.journal.exists():
                twice = [
                    cell
                    for cell, times in collections.Counter(cells(self.journal)).items()
                    if times > 1
                ]
                self.assertEqual(twice, [], f"killed at {target} bytes")
        for target in (0.65, 0.7, 0.75):
            self.assertIn(
                self.cut_off(target * full, signal.SIGKILL), (0, -signal.SIGKILL), self.said
            )
        if self.journal.exists():
            before = len(cells(self.journal))
            self.assertDone(self.resume())
            report = self.report()
            self.assertEqual(report["tiles_resumed"], before)
            self.assertEqual(report["tiles"], TILES - before)
        self.assertWhole()
        self.assertFalse(self.journal.exists())

    def test_at_a_signal_to_stop_it_keeps_what_it_has(self):
        self.assertEqual(self.cut_off(60_000, signal.SIGTERM), 1, self.said)
        self.assertFalse(self.picture.exists())
        before = len(cells(self.journal))
        self.assertGreater(before, 0)
        self.assertDone(self.resume())
        self.assertEqual(self.report()["tiles_resumed"], before)
        self.assertWhole()

    @only_in_all
    def test_the_choice_and_order_of_processors_do_not_matter(self):
        before = self.half_done("--quality-tile-order", "rows", "--threads", "1")
        self.assertDone(
            self.resume(
                "--quality-tile-order",
                "hilbert",
                "--threads",
                "3",
                "--memory-mib",
                "100",
                "--quality-coarse-step",
                "4",
            )
        )
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

    @only_in_all
    def test_another_picture_is_refused_and_the_tiles_stay(self):
        self.half_done()
        before = self.journal.read_bytes()
        for said, flags in (
            ("camera.fov_deg = 40.0 there, 50.0 here", [*FLAGS, "--fov", "50"]),
            ("quality.samples = 16 there, 17 here", flags_with("--samples", "17")),
            ("tiles of 16 pixels there, 32 here", flags_with("--tile", "32")),
            ("output.layers", [*FLAGS, "--layers", "all"]),
        ):
            with self.subTest(said):
                self.assertRefused(
                    render(square(), *flags, "--resume", "-o", self.picture),
                    1,
                    "a.exr.tiles",
                    "another picture",
                    said,
                )
        self.assertRefused(
            render("generated:7", *FLAGS, "--resume", "-o", self.picture),
            1,
            "a.exr.tiles",
            "another picture",
        )
        self.assertRefused(self.resume("--time", "5"), 2, "quality.time_s")
        self.assertEqual(self.journal.read_bytes(), before)

    @only_in_all
    def test_data_that_changed_are_another_picture(self):
        data = self.out / "data.laz"
        shutil.copy(square(), data)
        command = [*FLAGS, "--resume", "-o", self.picture]
        child = subprocess.Popen(
            [binary("RAYTRACER"), "render", data, *command],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        self.assertTrue(self.grown(child, 60_000))
        child.kill()
        child.wait()
        elsewhere = temporary_folder() / "data.laz"
        shutil.copy(data, elsewhere)
        with data.open("ab") as file:
            file.write(b"!")
        self.assertRefused(render(data, *command), 1, "another picture", "data.laz: 1 file")
        self.assertDone(render(elsewhere, *command))
        self.assertWhole()

    @only_in_all
    def test_damage_costs_the_tiles_that_it_hit(self):
        before = self.half_done()
        data = bytearray(self.journal.read_bytes())
        hit = [r for r in records(self.journal) if r[0] == 1][1:4:2]
        for _, _, at, size in hit:
            data[at + size // 2] ^= 0x55
        self.journal.write_bytes(bytes(data))
        run = render(
            square(), *PICTURE, "--resume", "--report", self.out / "report.json", "-o", self.picture
        )
        self.assertDone(run)
        self.assertIn(
            f"a.exr.tiles is damaged: {len(hit)} tiles; what is lost is rendered again", run.err
        )
        self.assertEqual(self.report()["tiles_resumed"], before - len(hit))
        self.assertWhole()

    @only_in_all
    def test_a_file_that_is_none_is_not_overwritten(self):
        self.journal.write_text("my notes")
        self.assertRefused(self.resume(), 1, "a.exr.tiles", "no checkpoint of a picture")
        self.assertEqual(self.journal.read_text(), "my notes")

    @only_in_all
    def test_a_full_disk_is_reported_and_resumed_from(self):
        run = self.resume(file_bytes=80_000)
        self.assertRefused(run, 1, "a.exr.tiles", "File too large", "--resume goes on with them")
        before = len(cells(self.journal))
        self.assertGreater(before, 0)
        self.assertDone(self.resume())
        self.assertEqual(self.report()["tiles_resumed"], before)
        self.assertWhole()

    @only_in_all
    def test_two_coordinators_do_not_write_to_one_checkpoint(self):
        command = [
            "render",
            square(),
            *flags_with("--samples", "5000"),
            "--resume",
            "-o",
            self.picture,
        ]
        child = subprocess.Popen(
            [binary("RAYTRACER"), *command], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        self.assertTrue(self.grown(child, 1))
        self.assertRefused(
            Run([binary("RAYTRACER"), *command]),
            1,
            "a.exr.tiles",
            "another coordinator is writing to it",
        )
        child.kill()
        child.wait()


class Merge(Case):
    @classmethod
    def setUpClass(cls):
        cls.made = temporary_folder()
        run = render(
            square(),
            *FLAGS,
            "--layers",
            "all",
            "-o",
            cls.made / "whole.exr",
            "-o",
            cls.made / "whole.png",
        )
        if run.code != 0:
            raise AssertionError(str(run))
        cls.parts = []
        for part in ("1/2", "2/2"):
            run = render(
                square(),
                *FLAGS,
                "--layers",
                "all",
                "--part",
                part,
                "-o",
                cls.made / "a.exr",
                "-o",
                cls.made / "a.png",
                "--report",
                cls.made / f"{part[0]}.json",
            )
            if run.code != 0:
                raise AssertionError(str(run))
            cls.parts.append(cls.made / f"a.exr.part-{part[0]}-of-2.tiles")

    def setUp(self):
        self.out = temporary_folder()

    @only_in_all
    def test_parts_share_the_tiles_and_write_no_picture(self):
        done = [set(cells(part)) for part in self.parts]
        self.assertEqual(done[0] & done[1], set())
        self.assertEqual(done[0] | done[1], set(range(TILES)))
        self.assertLessEqual(abs(len(done[0]) - len(done[1])), 2)
        self.assertNotIn("a.exr", entries(self.made))
        for i, part in enumerate(done):
            self.assertEqual(
                json.loads((self.made / f"{i + 1}.json").read_text())["tiles"], len(part)
            )

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

    @only_in_all
    def test_larger_than_memory_they_stream(self):
        self.assertDone(
            merge(*reversed(self.parts), "-o", self.out / "a.exr", "--memory-mib", "2", "--quiet")
        )
        streamed = Picture(self.out / "a.exr")
        self.assertEqual(streamed.tile, [TILE, TILE])
        self.assertTrue(streamed.bytes == Picture(self.made / "whole.exr").bytes)
        self.assertRefused(
            merge(*self.parts, "-o", self.out / "a.png", "--memory-mib", "1"),
            2,
            "a.png",
            ".exr .tif",
        )

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
        self.assertDone(
            render(
                square(),
                *FLAGS,
                "--layers",
                "all",
                "--resume",
                "-o",
                self.out / "b.exr",
                "--report",
                self.out / "r.json",
            )
        )
        self.assertEqual(json.loads((self.out / "r.json").read_text())["tiles_resumed"], TILES // 2)
        self.assertTrue(Picture(self.out / "b.exr").bytes == Picture(self.made / "whole.exr").bytes)

    @only_in_all
    def test_parts_of_parts_join_in_steps(self):
        self.assertDone(merge(*self.parts, "--tiles", self.out / "all.tiles", "--quiet"))
        self.assertDone(
            merge(self.out / "all.tiles", self.parts[1], "-o", self.out / "a.exr", "--quiet")
        )
        self.assertAlike(self.made / "whole.exr", self.out / "a.exr", exact=True)
        self.assertRefused(
            merge(*self.parts, "--tiles", self.out / "all.tiles"),
            2,
            "all.tiles: it is there already",
        )

    @only_in_all
    def test_a_part_that_was_cut_off_goes_on(self):
        part = self.out / "a.exr.part-1-of-2.tiles"
        whole = self.parts[0].read_bytes()
        part.write_bytes(whole[: len(whole) * 2 // 3])
        before = len(cells(part))
        self.assertDone(
            render(
                square(),
                *FLAGS,
                "--layers",
                "all",
                "--part",
                "1/2",
                "-o",
                self.out / "a.exr",
                "--report",
                self.out / "r.json",
            )
        )
        report = json.loads((self.out / "r.json").read_text())
        self.assertEqual((report["tiles_resumed"], report["tiles"]), (before, TILES // 2 - before))
        self.assertEqual(set(cells(part)), set(cells(self.parts[0])))

    @only_in_all
    def test_what_a_file_is_of(self):
        run = merge("--info", *self.parts)
        self.assertDone(run)
        for said in (
            "320x192 pixels, 16 samples, layers",
            f"{TILES // 2} of {TILES} tiles of 16 pixels (50.0 %)",
            f"missing  in rows 1 to {ROWS} of {ROWS}",
            "1 file",
        ):
            self.assertEqual(run.out.count(said), 2, f"{said}: {run}")

    def test_what_cannot_be_joined(self):
        other = self.out / "other.exr"
        self.assertDone(
            render(square(), *FLAGS, "--fov", "50", "--layers", "all", "--part", "2/2", "-o", other)
        )
        self.assertRefused(
            merge(self.parts[0], f"{other}.part-2-of-2.tiles", "-o", self.out / "a.exr"),
            1,
            "of another picture",
            "camera.fov_deg = 40.0 there, 50.0 here",
        )
        self.assertRefused(
            merge(self.out / "none.tiles", "-o", self.out / "a.exr"),
            1,
            "none.tiles",
            "No such file",
        )
        self.assertRefused(
            merge(square(), "-o", self.out / "a.exr"), 1, "no checkpoint of a picture"
        )
        self.assertRefused(merge(*self.parts), 2, "-o FILE.exr")
        self.assertRefused(merge(*self.parts, "-o", self.out / "a.gif"), 2, "'.gif'")
        self.assertRefused(merge("-o", self.out / "a.exr"), 2)
        self.assertNotIn("a.exr", entries(self.out))

    def test_parts_are_written_i_of_n(self):
        for part in ("0/2", "3/2", "1", "a/b", "1/0"):
            self.assertRefused(
                render(square(), *FLAGS, "--part", part, "-o", self.out / "a.exr"),
                2,
                part,
                "allowed: I/N",
            )


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
"""Pictures larger than their memory limit are streamed into their files; memory stays constant."""

import json
import signal
import subprocess
import unittest

from pictures import Tags
from support import (
    HANGS_S,
    Case,
    Run,
    binary,
    entries,
    has_sanitizers,
    only_in_all,
    render,
    square,
    temporary_folder,
    wait_until,
)

MIB = 1 << 20
# Memory of the process in addition to its limits: libraries with their tables (GDAL, PROJ, gRPC;
# OpenImageIO with what it is linked with is 95 of them), textures, sky, tiles in flight.
BASE_MIB = 320
FILM_BYTES = 28  # a pixel of a picture that is kept; docs/formats/pictures.md


class BigPictures(Case):
    def streamed(
        self,
        width,
        height,
        memory_mib,
        world_mib,
        *flags,
        endings=(".exr", ".tif"),
        timeout_s=HANGS_S,
    ):
        """Renders a picture that does not fit in memory. @return the folder with the files"""
        out = temporary_folder()
        most_mib = BASE_MIB + memory_mib + world_mib
        film_mib = width * height * FILM_BYTES / MIB
        self.assertGreater(film_mib, memory_mib / 2, "this one would be kept")
        self.assertGreater(film_mib, most_mib, "this one would not show whether it was kept")
        files = [out / f"a{ending}" for ending in endings]
        limits = ["--memory-mib", str(memory_mib), "--world-memory-mib", str(world_mib)]
        words = ["--size", f"{width}x{height}", "--samples", "1", "--quiet", *limits]
        outputs = [x for file in files for x in ("-o", file)]
        report = ["--report", out / "r.json"]
        run = render(square(), *words, *report, *flags, *outputs, timeout_s=timeout_s)
        self.assertDone(run)
        report = json.loads((out / "r.json").read_text())
        if not has_sanitizers():
            self.assertLess(report["peak_rss_bytes"] / MIB, most_mib)
        self.assertLessEqual(report["boxes"]["peak_bytes"], report["boxes"]["limit_bytes"])
        for file in files:
            self.assertGreater(file.stat().st_size, width * height / 100)
        return out

    def header(self, file):
        run = Run([binary("VALUES"), file])
        self.assertDone(run)
        return json.loads(run.out)

    def test_a_poster_needs_no_more_memory_than_a_postcard(self):
        # Mostly sky: it costs no time, and is as large.
        out = self.streamed(4096, 4400, 60, 64, "--zoom", "0.2", "--look", "plain")
        said = self.header(out / "a.exr")
        self.assertEqual((said["width"], said["height"], said["tile"]), (4096, 4400, [64, 64]))
        self.assertEqual([c["name"] for c in said["channels"]], ["R", "G", "B", "A", "Z"])
        self.assertEqual(int(said["metadata"]["terravox:holes"]), 0)
        self.assertEqual(said["metadata"]["terravox:samples"], "1")
        said = self.header(out / "a.tif")
        self.assertEqual((said["width"], said["height"]), (4096, 4400))
        self.assertTrue(Tags(out / "a.tif").big)

    def begun(self, out, ending):
        """A picture that takes long, when the first of its bytes are on the disk."""
        words = ["render", square(), "--size", "8192x8192", "--samples", "64", "--quiet"]
        command = [binary("RAYTRACER"), *words, "--memory-mib", "60", "-o", out / f"a{ending}"]
        child = subprocess.Popen(
            command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
        )
        wait_until(lambda: entries(out) or child.poll() is not None, "its first bytes")
        self.assertIsNone(child.poll(), "it has ended")
        self.assertTrue(entries(out))
        return child

    def test_a_stop_leaves_nothing_behind(self):
        for ending in (".exr", ".tif"):
            with self.subTest(ending):
                out = temporary_folder()
                child = self.begun(out, ending)
                child.send_signal(signal.SIGTERM)
                _, said = child.communicate(timeout=HANGS_S)
                self.assertEqual(
                    (child.returncode, said.strip()),
                    (1, "terravox: render: interrupted; no picture was written"),
                )
                self.assertEqual(entries(out), [])

    # Minutes, and some 2 GB of disk.
    @only_in_all
    def test_a_poster_of_a_thousand_million_pixels(self):
        flags = ["--zoom", "0.2", "--look", "plain", "--quality-shadows", "no"]
        out = self.streamed(32768, 32768, 300, 64, *flags, endings=(".exr",), timeout_s=3000)
        said = self.header(out / "a.exr")
        self.assertEqual((said["width"], said["height"]), (32768, 32768))
        print(
            f"{(out / 'a.exr').stat().st_size / MIB:.0f} MiB, "
            f"report: {(out / 'r.json').read_text()}"
        )


if __name__ == "__main__":
    unittest.main()

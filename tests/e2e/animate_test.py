#!/usr/bin/env python3
"""Animations: frames, leftovers of a killed run, ranges, wrong files, and a video with ffmpeg."""

import shutil
import subprocess
import unittest

from pictures import Picture, scene_of
from support import (
    ROOT,
    Case,
    Run,
    binary,
    entries,
    only_in_all,
    render,
    square,
    temporary_folder,
    wait_until,
)

SIZE = ["--size", "96x54", "--samples", "1"]
TURN = "fps = 6\n[turntable]\nseconds = 1\n"


def animate(file, *arguments, **options):
    return Run([binary("RAYTRACER"), "animate", file, square(), *arguments], **options)


def is_whole_png(data):
    return data.startswith(b"\x89PNG\r\n\x1a\n") and data.endswith(b"IEND\xaeB\x60\x82")


class Animations(Case):
    def setUp(self):
        self.folder = temporary_folder()
        self.frames = self.folder / "frames"
        self.pattern = self.frames / "%03d.png"

    def file(self, text):
        out = self.folder / "a.toml"
        out.write_text(text)
        return out

    def contents(self):
        return {p.name: p.read_bytes() for p in self.frames.glob("[0-9]*.png")}

    def scenes(self):
        return [scene_of(Picture(p)) for p in sorted(self.frames.glob("*.png"))]

    def test_a_turntable_goes_around_once(self):
        self.assertDone(animate(self.file(TURN), *SIZE, "--quiet", "-o", self.pattern))
        made = self.contents()
        self.assertEqual(sorted(made), [f"{i:03}.png" for i in range(6)])
        self.assertEqual(len(set(made.values())), 6)
        turns = [float(s["camera.azimuth_deg"]) % 360 for s in self.scenes()]
        for i, deg in enumerate(turns):
            self.assertAlmostEqual(deg, (225 + 60 * i) % 360, places=6)

    @only_in_all
    def test_a_day_goes_from_dark_to_light(self):
        day = (
            "fps = 1\nseconds = 4\n"
            '[day]\nfrom = 4\nto = 12\n[sun]\nzone = "Europe/Ljubljana"\n[output]\nadaptation = 0\n'
        )
        self.assertDone(animate(self.file(day), *SIZE, "--quiet", "-o", self.pattern))
        hours = [float(s["sun.time_h"]) for s in self.scenes()]
        self.assertEqual(hours, [4, 6, 8, 10, 12])
        light = [sum(Picture(p).values) for p in sorted(self.frames.glob("*.png"))]
        self.assertEqual(light, sorted(light))
        self.assertGreater(light[-1], 2 * light[0])

    @only_in_all
    def test_keys_move_the_camera_and_a_key_is_the_picture_of_its_scene(self):
        keys = (
            "fps = 2\n[[key]]\ntime_s = 0\ncamera.position = [462400, 101400, 700]\n"
            "camera.target = [462500, 101500, 480]\ncamera.fov_deg = 40\n"
            "[[key]]\ntime_s = 1\ncamera.position = [462500, 101380, 650]\n"
            "camera.target = [462500, 101500, 480]\ncamera.fov_deg = 60\n"
        )
        self.assertDone(animate(self.file(keys), *SIZE, "--quiet", "-o", self.pattern))
        self.assertEqual(len(self.contents()), 3)
        views = [float(s["camera.fov_deg"]) for s in self.scenes()]
        self.assertEqual((views[0], views[2]), (40, 60))
        self.assertTrue(40 < views[1] < 60)
        last = self.folder / "last.png"
        self.assertDone(
            render(
                square(),
                *SIZE,
                "--quiet",
                "--camera-position",
                "462500,101380,650",
                "--camera-target",
                "462500,101500,480",
                "--fov",
                "60",
                "-o",
                last,
            )
        )
        self.assertTrue(last.read_bytes() == (self.frames / "002.png").read_bytes())

    @only_in_all
    def test_killed_in_the_middle_it_goes_on_where_it_was(self):
        frames = 24  # of which a busy machine may let some pass between the third and the kill
        film = self.file(f"fps = {frames}\n[turntable]\nseconds = 1\n")
        flags = ["--size", "320x180", "--samples", "2"]
        whole = self.folder / "whole"
        self.assertDone(animate(film, *flags, "--quiet", "-o", whole / "%03d.png"))
        child = subprocess.Popen(
            [binary("RAYTRACER"), "animate", film, square(), *flags, "--quiet", "-o", self.pattern],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        wait_until(
            lambda: (
                child.poll() is not None or (self.frames.exists() and len(self.contents()) >= 3)
            ),
            "three frames",
        )
        child.kill()
        child.wait()
        left = self.contents()
        self.assertTrue(
            3 <= len(left) < frames, f"it was killed too early or too late: {sorted(left)}"
        )
        for name, data in left.items():
            self.assertTrue(is_whole_png(data), name)
        noted = {
            int(line.split()[0])
            for line in (self.frames / ".frames.png.done").read_text().splitlines()
            if line
        }
        self.assertTrue(
            noted <= {int(name[:3]) for name in left}, "a frame is noted that is not there"
        )
        before = {name: (self.frames / name).stat().st_mtime_ns for name in left}
        run = animate(film, *flags, "-o", self.pattern)
        self.assertDone(run)
        self.assertIn(f"{frames - len(noted)} frames made, {len(noted)} were done before", run.err)
        for frame in noted:
            name = f"{frame:03}.png"
            self.assertEqual(
                (self.frames / name).stat().st_mtime_ns, before[name], f"{name} was made again"
            )
        self.assertEqual(self.contents(), {p.name: p.read_bytes() for p in whole.glob("*.png")})
        self.assertEqual(
            [e for e in entries(self.frames) if "part" in e],
            [],
            "what the killed run had begun still lies there",
        )

    @only_in_all
    def test_done_frames_stay_changed_ones_are_made_again(self):
        film = self.file(TURN)
        flags = [*SIZE, "-o", self.pattern]
        self.assertIn("6 frames made, 0 were done before", animate(film, *flags).err)
        first = self.contents()
        self.assertIn("0 frames made, 6 were done before", animate(film, *flags).err)
        (self.frames / "002.png").unlink()
        (self.frames / "004.png").write_bytes(b"")
        listed = animate(film, *flags, "--list")
        self.assertDone(listed)
        self.assertEqual(listed.out, "2\n4\n")
        self.assertIn("2 frames made, 4 were done before", animate(film, *flags).err)
        self.assertEqual(self.contents(), first)
        self.assertIn(
            "0 frames made, 6 were done before",
            animate(film, *flags, "--threads", "1", "--tile", "16").err,
        )
        self.assertIn(
            "6 frames made, 0 were done before", animate(film, *flags, "--exposure", "1").err
        )
        self.assertNotEqual(self.contents(), first)
        self.assertIn("6 frames made, 0 were done before", animate(film, *flags, "--again").err)
        self.assertEqual(self.contents(), first)

    @only_in_all
    def test_frames_of_another_survey_or_other_materials_are_made_again(self):
        film = self.file(TURN)
        data = self.folder / "data"
        config = self.folder / "config"
        data.mkdir()
        shutil.copy(square(), data / "a.laz")
        shutil.copytree(ROOT / "config", config)

        def said():
            run = Run(
                [binary("RAYTRACER"), "animate", film, data, *SIZE, "-o", self.pattern],
                environment={"TERRAVOX_CONFIG": str(config)},
            )
            self.assertDone(run)
            return run.err

        self.assertIn("6 frames made, 0 were done before", said())
        (data / "a.laz").touch()  # a copy has another time, and the same points
        self.assertIn("0 frames made, 6 were done before", said())
        with (config / "materials.toml").open("r+") as file:
            text = file.read().replace("#7f9a4c", "#ff0000")
            file.seek(0)
            file.write(text)
        self.assertIn("6 frames made, 0 were done before", said())
        other = self.folder / "other"
        self.assertDone(
            Run(
                [
                    binary("SURVEY"),
                    "--seed",
                    "8",
                    "--squares",
                    "1x1",
                    "--square-m",
                    "256",
                    "--density",
                    "3",
                    "-o",
                    other,
                ]
            )
        )
        shutil.copy(next(other.glob("*.laz")), data / "a.laz")
        self.assertIn("6 frames made, 0 were done before", said())

    @only_in_all
    def test_what_the_run_itself_writes_into_the_inputs_is_no_change(self):
        data = self.folder / "data"
        data.mkdir()
        shutil.copy(square(), data / "a.laz")
        film = data / "film.toml"
        film.write_text(TURN)
        pattern = data / "%03d.png"

        def said():
            run = Run([binary("RAYTRACER"), "animate", film, data, *SIZE, "-o", pattern])
            self.assertDone(run)
            return run.err

        self.assertIn("6 frames made, 0 were done before", said())
        (data / "017.png").write_text("left by a longer film")
        film.write_text(TURN + "# a comment\n")
        self.assertIn("0 frames made, 6 were done before", said())
        (data / "b.ply").write_text("points")  # data of another kind is a change all the same
        self.assertNotIn(
            "0 frames made",
            Run([binary("RAYTRACER"), "animate", film, data, *SIZE, "-o", pattern]).err,
        )

    def test_ranges(self):
        film = self.file(TURN)
        run = animate(
            film, *SIZE, "--first", "1", "--last", "5", "--every", "2", "-o", self.pattern
        )
        self.assertDone(run)
        self.assertEqual(sorted(self.contents()), ["001.png", "003.png", "005.png"])
        self.assertIn(
            "3 frames made, 3 were done before", animate(film, *SIZE, "-o", self.pattern).err
        )
        for flags, said in {
            ("--first", "6"): "first = 6; allowed: 0 to 5",
            ("--first", "-1"): "first = -1",
            ("--last", "6"): "last = 6; allowed: 0 to 5",
            ("--first", "3", "--last", "2"): "last = 2; allowed: 3 to 5",
            ("--every", "0"): "every = 0; allowed: 1 and more",
        }.items():
            with self.subTest(said):
                self.assertRefused(animate(film, *SIZE, *flags, "-o", self.pattern), 2, said)

    def test_wrong_files_and_names(self):
        cases = {
            "no file": (None, self.pattern, "no such file"),
            "nothing moves": (
                "fps = 5\n",
                self.pattern,
                "nothing moves; give [[key]], [turntable] or [day]",
            ),
            "no TOML": ("fps = \n", self.pattern, "line 1"),
            "an unknown field": (TURN + "speed = 3\n", self.pattern, "turntable.speed"),
            "no frames a second": (
                "fps = 0\n[turntable]\nseconds = 1\n",
                self.pattern,
                "fps = 0; allowed: 0.01 to 1000",
            ),
            "too long": (
                "[turntable]\nseconds = 1e6\n",
                self.pattern,
                "allowed: up to 1000000 frames",
            ),
            "keys out of order": (
                "[[key]]\ntime_s = 1\nsun.time_h = 5\n[[key]]\ntime_s = 0\nsun.time_h = 6\n",
                self.pattern,
                "is not after",
            ),
            "a key changes the size": (
                (
                    '[[key]]\ntime_s = 0\noutput.size = "9x9"\n'
                    '[[key]]\ntime_s = 1\noutput.size = "8x8"\n'
                ),
                self.pattern,
                "output.size",
            ),
            "another version": (
                "version = 2\n" + TURN,
                self.pattern,
                "version = 2; allowed: 1",
            ),
            "a view that is none": (
                '[[key]]\ntime_s = 0\ncamera.look = "nowhere at all"\n',
                self.pattern,
                "names no view",
            ),
            "one name for all frames": (TURN, self.frames / "a.png", "one %d or %0Nd"),
            "an ending": (TURN, self.frames / "%d.gif", "ending '.gif'"),
        }
        for name, (text, pattern, said) in cases.items():
            with self.subTest(name):
                file = self.file(text) if text is not None else self.folder / "none.toml"
                self.assertRefused(animate(file, *SIZE, "-o", pattern), 2, said)
                self.assertFalse(self.contents() if self.frames.exists() else {})

    @only_in_all
    def test_without_ffmpeg_a_video_is_refused_before_any_frame(self):
        empty = temporary_folder()
        run = animate(
            self.file(TURN),
            *SIZE,
            "-o",
            self.pattern,
            "--video",
            self.folder / "a.mp4",
            environment={"PATH": str(empty)},
        )
        self.assertRefused(
            run, 2, "ffmpeg is not installed; without --video the frames are made all the same"
        )
        self.assertFalse(self.contents() if self.frames.exists() else {})
        self.assertFalse((self.folder / "a.mp4").exists())

    @only_in_all
    @unittest.skipUnless(shutil.which("ffmpeg"), "ffmpeg is not installed")
    def test_with_ffmpeg_there_is_a_video(self):
        video = self.folder / "a.mp4"
        self.assertDone(
            animate(self.file(TURN), *SIZE, "--quiet", "-o", self.pattern, "--video", video)
        )
        data = video.read_bytes()
        self.assertEqual(data[4:8], b"ftyp")
        self.assertGreater(len(data), 2000)
        self.assertEqual(sorted(self.contents()), [f"{i:03}.png" for i in range(6)])
        # The film's length, of the movie header: 6 frames at 6 a second.
        at = data.index(b"mvhd")
        scale, length = (
            int.from_bytes(data[at + 16 + 4 * i : at + 20 + 4 * i], "big") for i in (0, 1)
        )
        self.assertAlmostEqual(length / scale, 1.0, delta=0.02)


if __name__ == "__main__":
    unittest.main()

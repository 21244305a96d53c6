#!/usr/bin/env python3
"""Animations: frames, what is done and stays, ranges, wrong files, and a video with ffmpeg."""

import shutil
import unittest

from pictures import Picture, scene_of
from support import ROOT, Case, Run, binary, make_survey, only_in_all, square, temporary_folder

SIZE = ["--size", "96x54", "--samples", "1"]
TURN = "fps = 6\n[turntable]\nseconds = 1\n"


def animate(file, *arguments, **options):
    return Run([binary("RAYTRACER"), "animate", file, square(), *arguments], **options)


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
        other = make_survey(self.folder / "other", "1x1", 256, 3)
        shutil.copy(next(other.glob("*.laz")), data / "a.laz")
        self.assertIn("6 frames made, 0 were done before", said())

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

    def test_wrong_files_and_names(self):
        for text, pattern, said in (
            (None, self.pattern, "no such file"),
            (TURN, self.frames / "a.png", "one %d or %0Nd"),
        ):
            with self.subTest(said):
                file = self.file(text) if text is not None else self.folder / "none.toml"
                self.assertRefused(animate(file, *SIZE, "-o", pattern), 2, said)
                self.assertFalse(self.frames.exists())

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

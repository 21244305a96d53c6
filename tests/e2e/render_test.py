#!/usr/bin/env python3
"""Pictures of a synthetic survey: formats, scenes, reports, and the same bits on any machine."""

import json
import re
import unittest

from support import Case, Run, binary, compare, entries, render, survey, temporary_folder

SMALL = ["--size", "160x90", "--samples", "1", "--quiet"]


class Render(Case):
    def test_a_survey_becomes_pictures_of_every_format(self):
        out = temporary_folder()
        files = [out / name for name in ("a.png", "a.exr", "a.jpg", "a.tif")]
        run = render(
            survey(), "--ortho", survey() / "ortho", *SMALL, *(x for f in files for x in ("-o", f))
        )
        self.assertDone(run)
        self.assertEqual(run.err, "")
        self.assertEqual(run.out, "")
        self.assertEqual(entries(out), ["a.exr", "a.jpg", "a.png", "a.tif"])
        for file in files:
            self.assertGreater(file.stat().st_size, 1000)
        self.assertAlike(out / "a.png", out / "a.jpg")

    def test_the_picture_does_not_depend_on_the_processors_instructions(self):
        out = temporary_folder()
        for name in ("none", "avx2", "all"):  # more than the machine has is what it has
            words = [*SMALL, "-o", out / f"{name}.png"]
            self.assertDone(render(survey(), *words, environment={"TERRAVOX_SIMD": name}))
        pictures = {file.read_bytes() for file in out.iterdir()}
        self.assertEqual(len(pictures), 1)

    def test_a_saved_scene_gives_the_same_picture(self):
        out = temporary_folder()
        words = [*SMALL, "--fov", "55", "--sun-time-h", "9.5", "--save-scene", out / "s.toml"]
        self.assertDone(render(survey(), *words, "-o", out / "a.exr"))
        self.assertDone(render(survey(), "--scene", out / "s.toml", "--quiet", "-o", out / "b.exr"))
        self.assertAlike(out / "a.exr", out / "b.exr", exact=True)

    def test_a_sun_that_the_scene_states_is_kept_where_it_is_the_usual_one(self):
        out = temporary_folder()
        for name, text, wanted in (
            ("stated", "version = 1\n[sun]\ntime_h = 16\n", False),
            ("silent", "version = 1\n", True),
        ):
            (out / f"{name}.toml").write_text(text)
            saved = out / f"{name}-saved.toml"
            words = ["--scene", out / f"{name}.toml", *SMALL, "--save-scene", saved]
            self.assertDone(render(survey(), *words, "-o", out / f"{name}.png"))
            self.assertEqual("altitude_deg" in saved.read_text(), wanted, name)

    def test_the_report_counts(self):
        out = temporary_folder()
        words = [*SMALL, "--cache", "none", "--report", out / "r.json", "-o", out / "a.png"]
        self.assertDone(render(survey(), *words))
        report = json.loads((out / "r.json").read_text())
        self.assertEqual(report["holes"], 0)
        self.assertEqual(report["size"], [160, 90])
        self.assertGreater(report["rays"], 160 * 90)
        self.assertTrue(any(s["name"] == "point load" for s in report["stages"]))
        self.assertEqual(report["rays_by_kind"]["primary"], 160 * 90)
        self.assertEqual(sum(report["rays_by_kind"].values()), report["rays"])
        boxes = report["boxes"]
        self.assertGreater(sum(level["loaded"] for level in boxes["levels"]), 0)
        self.assertLessEqual(boxes["peak_bytes"], boxes["limit_bytes"])
        self.assertGreater(report["peak_rss_bytes"], boxes["peak_bytes"])

    def test_a_second_run_decodes_nothing_and_looks_the_same(self):
        out = temporary_folder()
        stages = []
        for name in "ab":
            words = [*SMALL, "--cache", out / "cache", "--report", out / f"{name}.json"]
            self.assertDone(render(survey(), *words, "-o", out / f"{name}.png"))
            report = json.loads((out / f"{name}.json").read_text())
            stages.append({stage["name"] for stage in report["stages"]})
        self.assertIn("point load", stages[0])
        self.assertNotIn("point load", stages[1])
        self.assertTrue((out / "a.png").read_bytes() == (out / "b.png").read_bytes())

    def test_steps_are_chosen_by_name(self):
        out = temporary_folder()
        (out / "no.toml").write_text("[steps]\nvegetation = false\nwater_deepening = false\n")

        def picture(name, *flags):
            self.assertDone(render(survey(), *SMALL, *flags, "-o", out / name))
            return out / name

        # Metadata of the files differ: pixels are compared.
        everything = picture("all.png", "--steps", "all")
        less = picture("less.png", "--steps", "-vegetation,-water_deepening")
        self.assertNotEqual(compare(everything, less, exact=True).code, 0)
        settings = ["--settings", out / "no.toml"]
        self.assertAlike(picture("file.png", *settings), less, exact=True)
        self.assertAlike(picture("over.png", *settings, "--steps", "all"), everything, exact=True)

    def test_the_old_name_of_a_step_is_read_with_a_warning(self):
        out = temporary_folder()
        (out / "old.toml").write_text("[steps]\nvegetation_fill = false\n")
        run = render(
            survey(), "--size", "32x18", "--settings", out / "old.toml", "-o", out / "a.png"
        )
        self.assertDone(run)
        self.assertIn("steps.vegetation_fill is now steps.vegetation", run.err)

    def test_the_help_lists_the_steps(self):
        for program, *words in (("RAYTRACER", "render"), ("CONVERT",), ("VOXELSERVER",)):
            run = Run([binary(program), *words, "--help", "all"])
            self.assertEqual(run.code, 0, str(run))
            self.assertIn("neighbourhood_filters", run.out)

    def test_without_quiet_the_log_is_clean(self):
        out = temporary_folder()
        run = render(survey(), "--size", "32x18", "-o", out / "a.png")
        self.assertDone(run)
        for line in run.err.splitlines():
            self.assertFalse(line.startswith(("[warn", "[error")), run.err)
        self.assertRegex(run.out, rf"\Awrote {re.escape(str(out / 'a.png'))} in [0-9.]+ s\n\Z")

    def test_what_a_run_cost_is_printed_on_request(self):
        out = temporary_folder()
        small = ("generated:7", "--size", "32x18", "--samples", "1", "-o", out / "a.png")
        for flags in (["-v"], ["--report", out / "a.json"]):
            with self.subTest(str(flags)):
                run = render(*small, *flags)
                self.assertDone(run)
                for part in ("ray tracing (clock)", "steps a ray", "MiB of boxes at most"):
                    self.assertIn(part, run.out)
        self.assertRefused(render(*small, "-v", "-q"), 2, "-q and -v are given")

    def test_help_and_version_go_to_standard_output(self):
        for arguments in (["--help"], ["render", "--help"], ["--version"]):
            run = Run([binary("RAYTRACER"), *arguments])
            self.assertDone(run)
            self.assertEqual(run.err, "")
            self.assertIn("terravox", run.out.lower())


if __name__ == "__main__":
    unittest.main()

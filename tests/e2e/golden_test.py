#!/usr/bin/env python3
"""Pictures of the synthetic survey compared with those in tests/fixtures/golden, with a tolerance.

golden_test.py --refresh makes the kept pictures anew (look at them before you commit them).
"""

import shutil
import sys
import unittest

from support import GOLDEN, ROOT, Case, compare, render, survey, temporary_folder

SCENES = {
    # From the air, with the true colours of the orthophoto.
    "survey_above": ["--ortho", "ORTHO", "--camera-down-deg", "50", "--zoom", "1.1"],
    # Materials alone, low sun, from the other side.
    "survey_materials": [
        *("--colour", "material", "--camera-azimuth-deg", "60"),
        *("--sun-altitude-deg", "25", "--sun-azimuth-deg", "120"),
    ],
}
COMMON = ["--look", "plain", "--size", "320x180", "--samples", "4", "--quiet"]
COMMON += ["--sun-date", "2026-06-21", "--sun-time-h", "16"]


def picture(name, folder, *more):
    flags = [survey() / "ortho" if flag == "ORTHO" else flag for flag in SCENES[name]]
    target = folder / f"{name}.png"
    render(survey(), *COMMON, *flags, *more, "-o", target).done()
    return target


class Golden(Case):
    def test_pictures_look_as_they_did(self):
        out = temporary_folder()
        for name in SCENES:
            with self.subTest(name):
                kept = GOLDEN / f"{name}.png"
                self.assertLessEqual(kept.stat().st_size, 81_920)
                made = picture(name, out)
                run = compare(kept, made)
                if run.code != 0:
                    seen = ROOT / "out" / "golden"
                    seen.mkdir(parents=True, exist_ok=True)
                    shutil.copy(made, seen / made.name)
                    self.fail(
                        f"{kept.name}: {run.out.strip()}; the new picture is "
                        f"{seen / made.name}; --refresh accepts it"
                    )

    def test_the_comparison_sees_a_lake_that_is_gone(self):
        out = temporary_folder()
        table = out / "dry.toml"
        table.write_text(
            (ROOT / "config" / "classes" / "asprs.toml")
            .read_text()
            .replace('9 = { role = "water", material = "water" }', '9 = { role = "drop" }')
        )
        for name in SCENES:
            with self.subTest(name):
                self.assertEqual(
                    compare(GOLDEN / f"{name}.png", picture(name, out, "--classes", table)).code, 1
                )


if __name__ == "__main__":
    if "--refresh" in sys.argv:
        GOLDEN.mkdir(parents=True, exist_ok=True)
        for scene in SCENES:
            print("wrote", picture(scene, GOLDEN))
    else:
        unittest.main()

#!/usr/bin/env python3
"""The gallery: its names, scenes, pictures and table agree.

The command reports wrong usage, and renders the same picture again.
"""

import hashlib
import re
import unittest

from support import ROOT, Case, Run, binary, compare, render, square, survey, temporary_folder

SCENES = ROOT / "config" / "scenes" / "gallery"
PICTURES = ROOT / "docs" / "gallery"
MOST_BYTES = 350_000
MOST_BYTES_IN_ALL = 4_000_000
MOST_BYTES_BEFORE = 60_000

# A survey small enough for a test: two squares, the first of them again with more pulses.
SMALL_PLACE = """
set -euo pipefail
shopt -s inherit_errexit
ROOT=$1 LOGS=$1/logs VERBOSE=0
. "$ROOT/config/setup/say.sh"
. "$ROOT/config/setup/build.sh"
. "$ROOT/config/setup/gallery.sh"
GALLERY_AROUND=(--seed 7 --squares 2x1 --square-m 256 --density 0.5)
GALLERY_MIDDLE=(--seed 7 --squares 1x1 --square-m 256 --density 1)
GALLERY_PHOTO=(--seed 7 --squares 1x1 --square-m 256 --density 1 --photo-sun 120,32)
GALLERY_SQUARE=$2
gallery "${@:3}"
"""


def gallery(*arguments):
    return Run([ROOT / "terravox", "gallery", *arguments], environment={"TERRAVOX_NO_BUILD": "1"})


def names():
    run = gallery("--list").done()
    return [line.split()[0] for line in run.out.splitlines()]


class Gallery(Case):
    def test_names_scenes_pictures_and_the_table_agree(self):
        known = names()
        for line in gallery("--list").out.splitlines():
            self.assertRegex(line, r"^[a-z-]+ +\S.*\S\.$")
        self.assertGreaterEqual(len(known), 12)
        self.assertEqual(sorted(known), sorted(scene.stem for scene in SCENES.glob("*.toml")))
        self.assertEqual(sorted(known), sorted(picture.stem for picture in PICTURES.glob("*.jpg")))
        table = (PICTURES / "README.md").read_text()
        self.assertEqual(re.findall(r"^\| \[!\[[^]]*\]\(([a-z-]+)\.jpg\)\]", table, re.M), known)
        for name in known:
            self.assertIn(f"`./terravox gallery {name}`", table)

    def test_the_kept_pictures_are_small(self):
        sizes = {picture: picture.stat().st_size for picture in PICTURES.rglob("*.jpg")}
        for picture, size in sizes.items():
            self.assertLessEqual(
                size,
                MOST_BYTES_BEFORE if picture.parent.name == "before" else MOST_BYTES,
                picture.name,
            )
        self.assertLessEqual(sum(sizes.values()), MOST_BYTES_IN_ALL)

    def test_wrong_words_are_answered_with_what_is_allowed(self):
        for arguments, words in (
            (["noon", "moon"], ["'moon'", "dusk", "night"]),
            (["--fast"], ["'--fast'", "--help"]),
            (["--size", "0x10"], ["'0x10'", "WIDTHxHEIGHT"]),
            (["--size"], ["--size lacks"]),
            (["--output", ""], ["--output", "a folder"]),
        ):
            with self.subTest(words):
                run = gallery(*arguments)
                self.assertEqual(run.code, 2, run)
                self.assertEqual(len(run.err.strip().splitlines()), 1, run)
                for word in words:
                    self.assertIn(word, run.err)

    def test_every_scene_can_be_drawn(self):
        out = temporary_folder()
        for name in names():
            with self.subTest(name):
                scene = ["--scene", SCENES / f"{name}.toml", "--camera-inside-rock", "yes"]
                size = ["--size", "16x9", "--samples", "1", "--noise", "0"]
                words = ["--ortho", survey() / "ortho", *scene, *size, "-o", out / f"{name}.png"]
                run = render(survey(), *words)
                self.assertEqual(run.code, 0, run)

    def test_materials_are_found_by_name(self):
        out = temporary_folder()
        for name, flags in {
            "own": [],
            "clay": ["--materials", "clay"],
            "path": ["--materials", ROOT / "config" / "materials-clay.toml"],
        }.items():
            words = ["--colour", "material", "--size", "32x18", "-o", out / f"{name}.png"]
            run = render(survey(), *flags, *words)
            self.assertEqual(run.code, 0, run)
        self.assertEqual(compare(out / "clay.png", out / "path.png", exact=True).code, 0)
        self.assertEqual(compare(out / "clay.png", out / "own.png").code, 1)
        wrong = render(survey(), "--materials", "../materials", "--quiet", "-o", out / "wrong.png")
        self.assertRefused(wrong, 2, "'../materials'", "clay")

    def test_a_picture_is_made_again_bit_for_bit_and_the_place_once(self):
        root = temporary_folder()
        middle = square().stem
        (root / "config").symlink_to(ROOT / "config")
        programs = root / "build" / "release" / "bin"
        programs.mkdir(parents=True)
        for name in ("RAYTRACER", "SURVEY"):
            (programs / f"terravox-{name.lower()}").symlink_to(binary(name))
        environment = {"TERRAVOX_NO_BUILD": "1", "TERRAVOX_CONFIG": str(ROOT / "config")}

        def run(*arguments):
            words = ["bash", "-c", SMALL_PLACE, "gallery", root, middle, *arguments]
            done = Run(words, environment=environment)
            self.assertEqual(done.code, 0, done)
            return done

        def sums(folder):
            return {
                p.name: hashlib.sha256(p.read_bytes()).hexdigest()
                for p in (root / folder).glob("*.jpg")
            }

        pictures = ["noon", "poster", "photograph"]
        first = run("--size", "64x36", "--output", str(root / "one"), *pictures)
        self.assertRegex(first.out, r"(?m)^noon +\d+\.\d s$")
        self.assertIn("Making the survey", first.err)
        (photo,) = (root / "build" / "gallery").glob("place-*-PHOTO")
        place = photo.with_name(photo.name.removesuffix("-PHOTO"))
        self.assertEqual(len(list(place.glob("*.laz"))), 2)
        self.assertGreater((place / f"{middle}.laz").stat().st_size, 1000)
        before = (place / f"{middle}.laz").stat().st_mtime_ns
        again = run("--size", "64x36", "--output", str(root / "two"), *reversed(pictures))
        self.assertNotIn("Making the survey", again.err)
        self.assertEqual(before, (place / f"{middle}.laz").stat().st_mtime_ns)
        self.assertEqual(sorted(sums("one")), sorted(f"{name}.jpg" for name in pictures))
        self.assertEqual(sums("one"), sums("two"))


if __name__ == "__main__":
    unittest.main()

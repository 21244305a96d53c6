#!/usr/bin/env python3
"""Rasters of analyses in parts, on several machines: joined, they are the raster of one run."""

import json
import sys
import unittest

from analysing import analyse, area_flag, needed, village
from support import Case, Run, binary, entries, square, temporary_folder

YEAR = ["--from", "2026-01-01", "--to", "2026-12-31", "--step-min", "60", "--bin-deg", "10"]
# The options of each kind that a joined raster could forget, and those of its further files.
KINDS = {
    "terrain": ["--window", "9", "--relief", "dsm", "--fill-m", "20", "--light", "200,30"],
    "sun": ["--date", "2026-06-21", "--zone", "Europe/Ljubljana", "--surface", "ground"],
    "energy": [*YEAR, "--directions", "32"],
    "sky": ["--directions", "153"],
    "sight": ["--range-m", "60"],
}


def merge(*arguments):
    return Run([binary("RAYTRACER"), "merge", *arguments])


def cluster(*arguments, **options):
    return Run([binary("RAYTRACER"), "cluster", *arguments], **options)


class Parts(Case):
    def part(self, folder, kind, text, *flags):
        """@return the file of one part"""
        run = analyse(kind, square(), *flags, "--part", text, "--quiet", "-o", folder / "a.tif")
        self.assertEqual((run.code, run.out), (0, ""), run)
        index, count = text.split("/")
        return folder / f"a.tif.part-{index}-of-{count}.tiles"

    def parts(self, folder, kind, *flags):
        return [self.part(folder, kind, text, *flags) for text in ("1/2", "2/2")]

    def test_joined_they_have_the_bytes_of_one_run(self):
        for kind, flags in KINDS.items():
            with self.subTest(kind):
                folder = temporary_folder()
                # Cells whose edges are no round numbers, and tiles of which one is not enough.
                flags = [*area_flag(), "--resolution", "1.7", "--tile", "16", *flags]
                flags = [*flags, *needed(kind)]
                whole = folder / "whole.tif"
                run = analyse(kind, square(), *flags, "--quiet", "-o", whole)
                self.assertEqual(run.code, 0, run)
                parts = self.parts(folder, kind, *flags)
                self.assertEqual(len(entries(folder)), 3)
                run = merge(*parts, "-o", folder / "joined.tif", "--quiet")
                self.assertEqual((run.code, run.out), (0, ""), run)
                self.assertEqual((folder / "joined.tif").read_bytes(), whole.read_bytes())

    def test_what_is_made_of_the_whole_is_made_of_the_joined(self):
        folder = temporary_folder()
        files = {"--report": "a.html", "--map": "a.svg", "--objects": "a.gpkg"}
        flags = [*village(), "--tile", "32", *KINDS["energy"]]
        words = [word for option, name in files.items() for word in (option, folder / name)]
        run = analyse("energy", square(), *flags, *words, "--quiet", "-o", folder / "whole.tif")
        self.assertEqual(run.code, 0, run)
        made = {name: (folder / name).read_bytes() for name in files.values()}
        parts = self.parts(folder, "energy", *flags)
        run = merge(*parts, *words, "-o", folder / "joined.tif")
        self.assertEqual(run.code, 0, run)
        for name in files.values():
            self.assertIn(str(folder / name), run.out)
            if name != "a.gpkg":  # which has the time that it was made at
                self.assertEqual((folder / name).read_bytes(), made[name], name)
        self.assertGreater((folder / "a.gpkg").stat().st_size, 50_000)

    def test_what_is_seen_is_summed_up(self):
        folder = temporary_folder()
        flags = [*area_flag(), "--tile", "32", *needed("sight")]
        whole = analyse("sight", square(), *flags, "--json", "-o", folder / "whole.tif")
        parts = self.parts(folder, "sight", *flags)
        joined = merge(*parts, "--json", "-o", folder / "joined.tif")
        self.assertEqual(joined.code, 0, joined)
        self.assertEqual(json.loads(joined.out), json.loads(whole.out))
        said = merge("--info", parts[0]).out
        self.assertRegex(said, r"130x110 cells of sight\n")

    def test_half_of_it_is_no_raster_and_a_part_goes_on(self):
        folder = temporary_folder()
        flags = [*area_flag(), "--tile", "16", "--directions", "16"]
        part = self.part(folder, "sky", "1/2", *flags)
        self.assertRefused(merge(part, "-o", folder / "a.tif"), 1, "tiles are missing, in rows")
        self.assertEqual(entries(folder), [part.name])
        before = part.read_bytes()
        self.assertEqual(self.part(folder, "sky", "1/2", "--resume", *flags), part)
        self.assertEqual(part.read_bytes(), before)

    def test_what_cannot_be_joined(self):
        folder = temporary_folder()
        flags = [*area_flag(), "--tile", "64", "--directions", "16"]
        one = self.part(folder, "sky", "1/2", *flags)
        other_folder = temporary_folder()
        other = self.part(other_folder, "sky", "2/2", *flags, "--range-m", "50")
        kind = self.part(other_folder, "terrain", "1/2", *area_flag(), "--tile", "64")
        added = temporary_folder()
        west, south, _, _ = area_flag()[1].split(",")
        tower = f"{west},{south},{int(west) + 9},{int(south) + 9},+60"
        added = self.part(added, "sky", "2/2", *flags, "--add", tower)
        for words, code, said in (
            ([one, other, "-o", folder / "a.tif"], 1, "analysis.range_m"),
            ([one, kind, "-o", folder / "a.tif"], 1, "analysis.kind"),
            ([one, added, "-o", folder / "a.tif"], 1, "input"),
            ([one, "-o", folder / "a.png"], 2, "allowed: .tif"),
            ([one, "-o", folder / "a.tif", "-o", folder / "b.tif"], 2, "2 files"),
            ([one, "--objects", "a.gpkg", "-o", "a.tif"], 2, "allowed: of energy"),
            ([one, "--json", "-o", "a.tif"], 2, "allowed: of sight"),
        ):
            with self.subTest(said):
                self.assertRefused(merge(*words), code, said)
        self.assertEqual(entries(folder), [one.name])

    def test_a_part_makes_no_files_of_the_whole(self):
        folder = temporary_folder()
        for words, said in (
            (["sky", "--part", "3/2"], "--part 3/2; allowed: I/N"),
            (["sky", "--part", "1/2", "--map", "a.svg"], "--map of terravox merge"),
            (["sky", "--part", "1/2", "--report", "a.html"], "--report of terravox merge"),
            (["energy", "--part", "1/2", "--objects", "a.gpkg"], "--objects of terravox merge"),
            (["sight", "--part", "1/2", "--json"], "--json of terravox merge"),
        ):
            with self.subTest(words=words):
                run = analyse(words[0], square(), *words[1:], "-o", "a.tif", cwd=folder)
                self.assertRefused(run, 2, said)
        self.assertEqual(entries(folder), [])


class Schedulers(Case):
    def test_slurm_gets_scripts_for_an_analysis(self):
        folder = temporary_folder()
        words = ["--dry-run", "--batch", "--parts", "3", "--folder", folder / "job"]
        words += ["--no-bake", "--analyse", "sun", square(), *area_flag(), "--map=m.svg"]
        words += ["--report", "r.html", "--date", "2026-06-21", "-o", "sun.tif"]
        run = cluster("slurm", *words, cwd=folder, environment={"PATH": str(folder)})
        self.assertEqual(run.code, 0, run)
        parts = (folder / "job" / "parts.sbatch").read_text(encoding="utf-8")
        merging = (folder / "job" / "merge.sbatch").read_text(encoding="utf-8")
        self.assertRegex(parts, r"(?s)analyse\s+sun\s.*--date.*--part")
        self.assertNotRegex(parts, "m.svg|r.html")
        self.assertRegex(merging, r"(?s)--map=m.svg'\s+--report\s+r.html\s+-o\s+sun.tif")
        # What the scripts do, one task after the other.
        for script, task in (("parts", 0), ("parts", 1), ("parts", 2), ("merge", 0)):
            run = Run(
                ["bash", folder / "job" / f"{script}.sbatch"],
                environment={"SLURM_ARRAY_TASK_ID": str(task)},
            )
            self.assertEqual(run.code, 0, run)
        whole = folder / "whole.tif"
        run = analyse("sun", square(), *area_flag(), "--date", "2026-06-21", "-o", whole)
        self.assertEqual((folder / "sun.tif").read_bytes(), whole.read_bytes())
        self.assertTrue({"m.svg", "r.html"} <= set(entries(folder)))

    def test_workers_of_slurm_and_kubernetes_join_an_analysis(self):
        folder = temporary_folder()
        run = cluster(
            "slurm",
            *("--dry-run", "--folder", folder / "job", "--analyse", "sky", square()),
            *("--range-m", "50", "-o", folder / "a.tif"),
        )
        self.assertEqual(run.code, 0, run)
        coordinator = (folder / "job" / "coordinator.sbatch").read_text(encoding="utf-8")
        words = r"terravox-raytracer\s+analyse\s+sky\s.*--range-m\s+50\s.*--listen"
        self.assertRegex(coordinator, f"(?s){words}")
        words = ["--image", "i", "--claim", "c", "--analyse", "sky", "w", "-o", "a.tif"]
        run = cluster("kubernetes", *words)
        self.assertEqual(run.code, 0, run)
        jobs = [item for item in json.loads(run.out)["items"] if item["kind"] == "Job"]
        containers = [job["spec"]["template"]["spec"]["containers"][0] for job in jobs]
        commands = [one["command"] + one.get("args", []) for one in containers]
        self.assertTrue(any(command[1:4] == ["analyse", "sky", "w"] for command in commands))

    def test_squares_are_prepared_for_an_analysis(self):
        folder = temporary_folder()
        words = ["--for", "sky", "--part", "1/1", square(), "--cache", folder / "cache"]
        run = cluster("bake", *words, "--directions", "32", "-o", folder / "a.tif")
        self.assertEqual(run.code, 0, run)
        self.assertIn("1 squares prepared", run.err)

    def test_wrong_words_are_refused_before_anything_is_submitted(self):
        parts = ["slurm", "--dry-run", "--batch", "--parts", "2", "--analyse"]
        output = ["-o", "a.tif"]
        for name, words, said in (
            ("no kind", [*parts, "noise", square(), *output], "--analyse"),
            ("batch of one", ["slurm", "--batch", "--analyse", "sky", square()], "--parts"),
            ("of render", [*parts, "sky", square(), "--size", "9x9", *output], "--size"),
            ("json", [*parts, "sight", square(), "--json", *output], "--json among"),
            ("a part", [*parts, "sky", square(), "--part", "1/2", *output], "--part among"),
            (
                "frames",
                ["kubernetes", "--image", "i", "--claim", "c", "--batch", "--analyse", "sky", "w"],
                "--analyse with --batch",
            ),
        ):
            with self.subTest(name):
                folder = temporary_folder()
                self.assertRefused(cluster(*words, cwd=folder), 2, said)
                self.assertEqual(entries(folder), [])


if __name__ == "__main__":
    unittest.main(argv=sys.argv)

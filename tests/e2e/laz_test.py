"""terravox-laz as a user runs it: what it writes, prints and refuses."""

import json
import pathlib
import shutil
import unittest

from support import SHARED, Case, Run, binary, survey, temporary_folder


def laz(*arguments, **options):
    return Run([binary("LAZ"), *arguments], **options)


class LazTest(Case):
    def setUp(self):
        self.folder = temporary_folder()

    def square(self):
        found = sorted(pathlib.Path(survey()).rglob("*.laz"))
        self.assertTrue(found, "the synthetic survey has no square")
        return shutil.copy(found[0], self.folder)

    def test_info_is_json_with_the_facts_of_the_header(self):
        square = self.square()
        run = laz("info", square)
        self.assertEqual(run.code, 0, str(run))
        facts = json.loads(run.out)
        self.assertEqual(facts["crs"], "EPSG:3794")
        self.assertTrue(facts["compressed"])
        self.assertFalse(facts["copc"] or facts["lax"])
        self.assertEqual(run.err, "")
        self.assertIn(f"{facts['point_count']} points", laz("check", square).out)

    def test_an_index_appears_next_to_the_file(self):
        square = pathlib.Path(self.square())
        run = laz("index", square)
        self.assertEqual(run.code, 0, str(run))
        self.assertTrue(square.with_suffix(".lax").is_file())
        self.assertTrue(json.loads(laz("info", square).out)["lax"])

    def test_wrong_usage_ends_with_2(self):
        for arguments in ([], ["compress", "a"], ["squeeze", "a", "b"]):
            with self.subTest(arguments):
                self.assertEqual(laz(*arguments).code, 2)
        self.assertRefused(laz("check", self.folder / "none.laz"), 1, "none.laz")

    def test_no_real_file_crashes_it(self):
        if not SHARED.is_dir():
            self.skipTest(f"{SHARED} is not there")
        bad = ["lazpy/testdata/malformed", "ign-pdal-tools/check_las"]
        files = [
            p
            for folder in bad
            for p in sorted((SHARED / folder).rglob("*.la[sz]"))
            if p.stat().st_size < 3_000_000
        ]
        names = ["garbage_nVariableLength", "bad_vlr_count", "bad-geotiff-keys", "spurious"]
        names += ["no-points", "epsg_4326", "extrabytes", "lots_of_vlr", "test1_4"]
        files += [SHARED / "pdal/las" / f"{name}.las" for name in names]
        files.append(SHARED / "laspy/tests/data/simple.copc.laz")
        self.assertGreater(len(files), 15)
        done = 0
        for path in files:
            with self.subTest(path.name):
                copy = self.folder / ("copy" + path.suffix)
                shutil.copyfile(path, copy)
                out = self.folder / "out.laz"
                for arguments in (
                    ["info", copy],
                    ["check", copy],
                    ["index", copy],
                    ["compress", copy, out],
                ):
                    run = laz(*arguments)
                    if run.code == 0:
                        self.assertEqual(run.err, "", str(run))
                        done += 1
                    else:
                        self.assertRefused(run, 1)
                if out.exists():
                    before, after = (json.loads(laz("info", f).out) for f in (copy, out))
                    for key in ("point_count", "point_format", "version", "min", "max", "crs"):
                        self.assertEqual(before[key], after[key], key)
                for left in self.folder.iterdir():
                    left.unlink()
        self.assertGreater(done, 15)


if __name__ == "__main__":
    unittest.main()

"""terravox-laz as a user runs it: what it writes, prints and refuses."""

import json
import pathlib
import shutil
import unittest

from support import Case, Run, binary, survey, temporary_folder


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


if __name__ == "__main__":
    unittest.main()

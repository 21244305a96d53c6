"""Worlds of games."""

import json
import shutil

import game_worlds
from checks import Strangers

from support import Run, binary, temporary_folder


class Worlds(Strangers):
    def check_world(self, row, folder):
        path = row.write(folder)
        run = Run([binary("RAYTRACER"), "world", "info", "--json", "--blocks", path])
        if row.refused:
            self.assertEqual(run.code, 2, run)
            self.assertIn(row.refused, run.err, run)
            self.assertIn(str(folder), run.err, run)
            return
        facts = json.loads(run.out)
        first = facts["dimensions"][0]
        self.assertEqual([each["name"] for each in facts["dimensions"]], [*row.dimensions], run)
        self.assertEqual(first["versions"], row.versions, run)
        self.assertEqual(first["chunks"]["all"], 4, run)
        self.assertEqual(first["chunks"]["damaged"], row.damaged, run)
        self.assertEqual(first["chunks"]["finished"], 4 - row.damaged, run)
        self.assertEqual(run.code, 3 if row.damage else 0, run)
        for part, lines in ((row.damage, first["damage"]), (row.note, first["notes"])):
            self.assertEqual(bool(lines), bool(part), run)
            self.assertIn(part, "\n".join(lines), run)
        self.assertEqual(bool(run.err), bool(row.says), run)
        self.assertIn(row.says, run.err, run)
        if row.has_tables:
            text = Run([binary("RAYTRACER"), "world", "info", "--blocks", path])
            self.assertIn("minecraft:straw_bed (plain)", text.out, text)
            self.assertNotIn("in no table", text.out, text)

    def test_game_worlds(self):
        for row in game_worlds.ROWS:
            with self.subTest(row.name):
                folder = temporary_folder()
                self.check_world(row, folder)
                shutil.rmtree(folder)

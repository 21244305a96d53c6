#!/usr/bin/env python3
"""terravox-archive as a user runs it: what an archive holds, and whether it is whole."""

import json
import pathlib
import shutil
import subprocess
import unittest

from support import Case, Run, binary, entries, square, temporary_folder


def archive(*arguments, **options):
    return Run([binary("ARCHIVE"), *arguments], **options)


class Archive(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.whole = temporary_folder() / "place.tvx"
        words = [binary("CONVERT"), square(), cls.whole, "--cache", "none"]
        subprocess.run(words, check=True, capture_output=True)

    def assertRefused(self, run, code, *said):
        self.assertEqual(run.code, code, str(run))
        self.assertEqual(run.out, "", str(run))
        self.assertTrue(run.err.startswith("terravox: "), str(run))
        for text in said:
            self.assertIn(text, run.err)

    def damaged(self, offset):
        copy = pathlib.Path(shutil.copy(self.whole, temporary_folder() / "place.tvx"))
        with copy.open("r+b") as file:
            file.seek(offset)
            byte = file.read(1)[0]
            file.seek(offset)
            file.write(bytes([byte ^ 0x10]))
        return copy

    def test_info_tells_what_it_holds_and_verify_that_it_is_whole(self):
        run = archive("info", self.whole)
        self.assertDone(run)
        self.assertIn("EPSG:3794", run.out)
        self.assertIn("level 0", run.out)
        facts = json.loads(archive("info", "--json", self.whole).out)
        self.assertEqual(facts["bytes"], self.whole.stat().st_size)
        self.assertEqual(facts["world"]["levels"], len(facts["levels"]))
        self.assertGreater(facts["levels"][0]["boxes"], 10)
        self.assertEqual(facts["damage"], 0)
        boxes = sum(level["boxes"] for level in facts["levels"])
        run = archive("verify", self.whole)
        self.assertDone(run)
        self.assertEqual(run.out, f"{self.whole}: whole, {boxes} boxes, 0 holes\n")

    def test_damage_is_named(self):
        size = self.whole.stat().st_size
        for flags in ([], ["--checksums"]):
            run = archive("verify", *flags, self.damaged(size // 2))
            self.assertRefused(run, 1, "is damaged", "1 problem")
        self.assertDone(archive("verify", "--checksums", self.whole))
        self.assertRefused(archive("verify", self.damaged(size - 20)), 1, "index is damaged")

    def test_other_files_are_refused(self):
        self.assertRefused(archive("verify", square()), 1, "not a box archive")
        self.assertRefused(archive("info", temporary_folder()), 1, "not a plain file")
        self.assertRefused(archive("info", temporary_folder() / "none.tvx"), 1, "no such file")

    def shards(self, count, *options):
        folder = temporary_folder()
        out = []
        for number in range(1, count + 1):
            out.append(folder / f"{number}.tvx")
            words = [binary("CONVERT"), square(), out[-1], "--cache", "none", *options]
            self.assertDone(Run([*words, "--shard", f"{number}/{count}"]))
        return out

    def test_shards_in_any_order_give_the_same_bytes(self):
        for count in (1, 3):
            merged = temporary_folder() / "merged.tvx"
            self.assertDone(archive("merge", *reversed(self.shards(count)), "-o", merged))
            self.assertEqual(merged.read_bytes(), self.whole.read_bytes(), count)

    def test_a_shard_says_what_it_is(self):
        shards = self.shards(2)
        facts = json.loads(archive("info", "--json", shards[1]).out)
        self.assertEqual((facts["shard"], facts["shards"]), (2, 2))
        self.assertIn("2 of 2", archive("info", shards[1]).out)
        for shard in shards:
            self.assertDone(archive("verify", shard))
            run = Run([binary("RAYTRACER"), "render", shard, "-o", shard.with_suffix(".png")])
            self.assertRefused(run, 1, "it is a shard of one", "archive merge")
            self.assertFalse(shard.with_suffix(".png").exists())

    def test_shards_that_do_not_belong_together_are_refused(self):
        first, second = self.shards(2)
        other = self.shards(2, "--level", "1")[1]
        merged = first.parent / "merged.tvx"
        for shards, code, said in (
            ([first], 2, "shard 2 of 2 is missing"),
            ([second], 2, "shard 1 of 2 is missing"),
            ([first, first], 2, "is there twice"),
            ([first, other], 2, "is of another conversion"),
            ([first, self.whole], 2, "not a shard"),
            ([first, square()], 1, "not a box archive"),
        ):
            with self.subTest(said):
                self.assertRefused(archive("merge", *shards, "-o", merged), code, said)
        run = archive("merge", first, second, "-o", second, "--overwrite")
        self.assertRefused(run, 2, "it is one of the shards")
        data = bytearray(second.read_bytes())
        data[len(data) // 3] ^= 1
        second.write_bytes(data)
        self.assertRefused(archive("merge", first, second, "-o", merged), 1, "is damaged")
        self.assertEqual(entries(first.parent), [first.name, second.name])
        merged.write_text("mine", encoding="utf-8")
        self.assertRefused(archive("merge", first, second, "-o", merged), 2, "--overwrite")
        self.assertEqual(merged.read_text(encoding="utf-8"), "mine")

    def test_an_archive_is_cut_into_parts_and_joined_again(self):
        large = temporary_folder() / "place.tvx"
        fine = [binary("CONVERT"), square(), large, "--cache", "none", "--voxel", "0.2"]
        self.assertDone(Run(fine))
        self.assertGreater(large.stat().st_size, 2 << 20, "it makes no parts")
        folder = temporary_folder()
        words = ["split", large, "--max-mib", "1", "-o", folder]
        run = archive(*words)
        self.assertDone(run)
        parts = sorted(folder.iterdir())
        self.assertEqual(run.out.split(), [str(part) for part in parts])
        self.assertGreater(len(parts), 1)
        self.assertEqual(parts[0].name, "place-0001.part")
        self.assertLessEqual(max(part.stat().st_size for part in parts), 1 << 20)
        self.assertDone(archive("verify", *parts))
        self.assertDone(archive("verify", "--checksums", *parts))
        self.assertIn("level 0", archive("info", *parts).out)
        joined = temporary_folder() / "joined.tvx"
        self.assertDone(archive("merge", *parts, "-o", joined))
        self.assertEqual(joined.read_bytes(), large.read_bytes())
        self.assertRefused(archive(*words), 2, "it is there already", "--overwrite")
        joined.unlink()
        self.assertRefused(archive("merge", *parts[:1], "-o", joined), 1, "place-0001.part: bytes")
        self.assertRefused(archive("split", square(), "--max-mib", "1"), 1, "not a box archive")
        run = archive("split", self.shards(2)[0], "--max-mib", "1")
        self.assertRefused(run, 1, "it is a shard of one", "archive merge")

    def test_many_parts_in_any_order_need_few_open_files(self):
        """Beyond 9,999 parts the order of names is not that of numbers."""
        data = self.whole.read_bytes()
        folder = temporary_folder()
        count = 400
        parts = []
        for i in range(count):
            parts.append(folder / f"place-{9_800 + i}.part")
            stretch = slice(len(data) * i // count, len(data) * (i + 1) // count)
            parts[-1].write_bytes(data[stretch])
        self.assertNotEqual(parts, sorted(parts))
        joined = temporary_folder() / "joined.tvx"
        few = ["sh", "-c", 'ulimit -n 64; exec "$@"', "sh", binary("ARCHIVE")]
        self.assertDone(Run([*few, "merge", *sorted(parts), "-o", joined]))
        self.assertEqual(joined.read_bytes(), data)
        self.assertDone(Run([*few, "verify", *reversed(parts)]))
        self.assertDone(Run([*few, "info", *sorted(parts)]))

    def test_wrong_shards_are_refused(self):
        out = temporary_folder() / "part.tvx"
        for text in ("0/2", "1/2/3", "1/200000", "1/ 2"):
            with self.subTest(text):
                words = [binary("CONVERT"), square(), out, f"--shard={text}"]
                self.assertRefused(Run(words), 2, "--shard", "allowed: I/N")
        words = [binary("CONVERT"), square(), out.with_suffix(".glb"), "--shard", "1/2"]
        self.assertRefused(Run(words), 2, "allowed: to a box archive")

    def test_wrong_usage_ends_with_2(self):
        for arguments in (
            [],
            ["verify"],
            ["repair", self.whole],
            ["patch", self.whole],
            ["split", self.whole],
            ["split", "--max-mib", "0", self.whole],
            ["split", "--max-mib", "1", self.whole, self.whole],
            ["verify", "--threads", "many", self.whole],
            ["verify", "--threads", "-1", self.whole],
            ["info", "--threads", "1", self.whole],
        ):
            with self.subTest(arguments):
                self.assertRefused(archive(*arguments), 2)


if __name__ == "__main__":
    unittest.main()

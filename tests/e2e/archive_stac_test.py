#!/usr/bin/env python3
"""terravox-archive stac: archives described for catalogues, by the rules of STAC 1.0.0."""

import json
import pathlib
import re
import shutil
import subprocess
import unittest
import urllib.parse

from support import Case, Run, binary, entries, square, temporary_folder

TIME = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ")
DAY = ["--datetime", "2023-04-01"]


def stac(*arguments, **options):
    return Run([binary("ARCHIVE"), "stac", *arguments], **options)


def read(file):
    return json.loads(file.read_text(encoding="utf-8"))


class Stac(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.archive = temporary_folder() / "place.tvx"
        words = [binary("CONVERT"), square(), cls.archive, "--cache", "none", "--voxel", "1"]
        subprocess.run(words, check=True, capture_output=True)

    def copies(self, *names):
        folder = temporary_folder()
        return folder, [pathlib.Path(shutil.copy(self.archive, folder / name)) for name in names]

    def assertItem(self, item):
        """What the schemas of an item, and of the extensions that it names, ask for."""
        self.assertEqual(item["type"], "Feature")
        self.assertEqual(item["stac_version"], "1.0.0")
        self.assertTrue(item["id"])
        self.assertEqual(len(item["bbox"]), 4)
        west, south, east, north = item["bbox"]
        self.assertTrue(-180 <= west < east <= 180 and -90 <= south < north <= 90, item["bbox"])
        self.assertEqual(item["geometry"]["type"], "Polygon")
        (ring,) = item["geometry"]["coordinates"]
        self.assertEqual(ring[0], ring[-1])
        area = sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(ring, ring[1:], strict=False))
        self.assertGreater(area, 0, "not counterclockwise")
        for lon, lat in ring:
            self.assertTrue(west <= lon <= east and south <= lat <= north)
        properties = item["properties"]
        if properties["datetime"] is None:
            self.assertLessEqual(properties["start_datetime"], properties["end_datetime"])
        for name in ("datetime", "start_datetime", "end_datetime"):
            if properties.get(name) is not None:
                self.assertRegex(properties[name], TIME)
        self.assertRegex(properties["license"], r"^[\w\-.+]+$")
        self.assertIsInstance(properties["proj:epsg"], (int, type(None)))
        self.assertTrue(properties["proj:wkt2"].startswith("PROJCRS["))
        self.assertEqual(len(properties["proj:bbox"]), 4)
        for link in item["links"]:
            self.assertTrue(link["rel"] and link["href"])
        self.assertEqual("collection" in item, any(a["rel"] == "collection" for a in item["links"]))
        for asset in item["assets"].values():
            self.assertTrue(asset["href"] and asset["type"])
            self.assertEqual(asset["roles"], ["data"])

    def test_an_item_says_where_and_what_an_archive_is(self):
        folder, (archive,) = self.copies("place.tvx")
        run = stac(archive, "-o", folder, *DAY)
        self.assertDone(run)
        self.assertEqual(run.out, f"{folder}/place.json\n")
        self.assertEqual(entries(folder), ["place.json", "place.tvx"])
        item = read(folder / "place.json")
        self.assertItem(item)
        self.assertEqual(item["id"], "place")
        asset = item["assets"]["archive"]
        self.assertEqual(asset["href"], "./place.tvx")
        self.assertEqual(asset["file:size"], archive.stat().st_size)
        info = Run([binary("ARCHIVE"), "info", "--json", archive])
        facts = json.loads(info.out)
        world = facts["world"]
        properties = item["properties"]
        self.assertEqual(properties["datetime"], None)
        self.assertEqual(properties["start_datetime"], "2023-04-01T00:00:00Z")
        self.assertEqual(properties["end_datetime"], "2023-04-01T23:59:59Z")
        self.assertEqual(properties["proj:epsg"], 3794)
        self.assertEqual(properties["gsd"], 1)
        self.assertEqual(properties["terravox:voxel_m"], 1)
        self.assertEqual(properties["terravox:levels"], world["levels"])
        self.assertEqual(properties["terravox:boxes"], sum(x["boxes"] for x in facts["levels"]))
        low, high = world["bounds"]["min"], world["bounds"]["max"]
        self.assertEqual(properties["terravox:heights_m"], [low[1], high[1]])
        self.assertEqual(properties["proj:bbox"], [low[0], -high[2], high[0], -low[2]])
        west, south, east, north = item["bbox"]
        self.assertTrue(west < world["centre"]["lon_deg"] < east)
        self.assertTrue(south < world["centre"]["lat_deg"] < north)
        # A degree of latitude has 111 km; the grid of Slovenia is turned by less than 2 degrees.
        metres = high[2] - low[2]
        self.assertAlmostEqual((north - south) * 111_170, metres, delta=0.05 * metres)

    def test_times_are_instants_days_and_periods(self):
        for text, wanted in (
            ("2023-04-01T10:30:00Z", ("2023-04-01T10:30:00Z", None, None)),
            ("2014-01-01/2015-12-31", (None, "2014-01-01T00:00:00Z", "2015-12-31T23:59:59Z")),
        ):
            folder, (archive,) = self.copies("place.tvx")
            self.assertDone(stac(archive, "-o", folder, "--datetime", text))
            item = read(folder / "place.json")
            self.assertItem(item)
            names = ("datetime", "start_datetime", "end_datetime")
            self.assertEqual(tuple(item["properties"].get(name) for name in names), wanted)
        for text in (
            "", "2023-02-29", "2023-04-01T24:00:00Z", "2023-04-02/2023-04-01", "2023-04-01/",
        ):  # fmt: skip
            with self.subTest(text):
                folder, (archive,) = self.copies("place.tvx")
                run = stac(archive, "-o", folder, "--datetime", text)
                self.assertRefused(run, 2, "--datetime", "allowed: 2023-04-01")
                self.assertEqual(entries(folder), ["place.tvx"])

    def test_several_archives_have_a_collection(self):
        folder, archives = self.copies("b.tvx", 'a "0%?.tvx')
        run = stac(*archives, "-o", folder, *DAY)
        self.assertDone(run)
        collection = read(folder / "collection.json")
        self.assertEqual(collection["type"], "Collection")
        self.assertEqual(collection["stac_version"], "1.0.0")
        self.assertEqual(collection["id"], folder.name)
        self.assertTrue(collection["description"])
        self.assertRegex(collection["license"], r"^[\w\-.+]+$")
        (interval,) = collection["extent"]["temporal"]["interval"]
        self.assertEqual(interval, ["2023-04-01T00:00:00Z", "2023-04-01T23:59:59Z"])
        links = [link["href"] for link in collection["links"] if link["rel"] == "item"]
        self.assertEqual(links, ["./b.json", "./a%20%220%25%3F.json"])
        for link, archive in zip(links, archives, strict=True):
            item = read(folder / urllib.parse.unquote(link))
            self.assertItem(item)
            self.assertEqual(item["collection"], collection["id"])
            self.assertEqual(item["bbox"], collection["extent"]["spatial"]["bbox"][0])
            href = item["assets"]["archive"]["href"]
            self.assertEqual(folder / urllib.parse.unquote(href), archive)
        words = ["--collection", "flights-2023", "--href", "https://example.org/data/"]
        self.assertDone(stac(archives[1], "-o", folder, *DAY, *words, "--overwrite"))
        self.assertEqual(read(folder / "collection.json")["id"], "flights-2023")
        href = read(folder / 'a "0%?.json')["assets"]["archive"]["href"]
        self.assertEqual(href, "https://example.org/data/a%20%220%25%3F.tvx")

    def test_items_name_no_folder_of_this_machine(self):
        folder, (archive,) = self.copies("place.tvx")
        below = folder / "data" / "2023"
        below.mkdir(parents=True)
        archive.rename(below / "place.tvx")
        run = Run(
            [binary("ARCHIVE"), "stac", "2023/place.tvx", "-o", "..", *DAY], cwd=folder / "data"
        )
        self.assertDone(run)
        text = (folder / "place.json").read_text(encoding="utf-8")
        self.assertIn('"./data/2023/place.tvx"', text)
        self.assertNotIn(folder.name, text)
        other = folder / "elsewhere"
        run = stac(below / "place.tvx", "-o", other, *DAY)
        self.assertRefused(run, 2, "lies outside of", "--href")
        self.assertFalse(other.exists())

    def test_what_cannot_be_described_is_refused(self):
        folder, (archive,) = self.copies("place.tvx")
        shard = folder / "shard.tvx"
        words = [binary("CONVERT"), square(), shard, "--cache", "none", "--shard", "1/2"]
        self.assertDone(Run(words))
        nowhere = folder / "nowhere.tvx"
        blocks = ["--area", "0,0,64,64", "--cache", "none"]
        self.assertDone(Run([binary("CONVERT"), "generated:1", nowhere, *blocks]))
        (folder / "more").mkdir()
        again = shutil.copy(archive, folder / "more" / "place.tvx")
        there = entries(folder)
        for words, code, said in (
            ([shard], 2, "it is a shard of an archive"),
            ([nowhere], 2, "it has no CRS"),
            ([square()], 1, "not a box archive"),
            ([archive, again], 2, "two files would have the name place.json"),
            ([archive, "--href", "https://me@example.org"], 2, "allowed: the address of a folder"),
        ):
            with self.subTest(said):
                href = ["--href", "https://example.org"] if words[0] == square() else []
                self.assertRefused(stac(*words, *href, "-o", folder, *DAY), code, said)
                self.assertEqual(entries(folder), there)
        self.assertDone(stac(archive, "-o", folder, *DAY))
        before = (folder / "place.json").read_bytes()
        self.assertRefused(stac(archive, "-o", folder, *DAY), 2, "--overwrite")
        self.assertRefused(stac(archive, "-o", folder), 2, "--datetime")
        self.assertDone(stac(archive, "-o", folder, *DAY, "--overwrite"))
        self.assertEqual((folder / "place.json").read_bytes(), before)


if __name__ == "__main__":
    unittest.main()

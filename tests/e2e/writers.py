"""Programs that write files, and what must hold for each when a write fails."""

import functools
import itertools
import json
import resource
import shutil
import struct
from typing import NamedTuple

from support import Case, Run, binary, make, make_survey, temporary_folder

LIMITS = {
    "descriptors": resource.RLIMIT_NOFILE,
    "address space": resource.RLIMIT_AS,
    "file size": resource.RLIMIT_FSIZE,
}


class Writer(NamedTuple):
    program: str  # as support.binary() takes it
    words: str  # its arguments: OUT is the folder that it writes to, an INPUT what it reads
    file: str  # what it makes, below OUT
    left: tuple = ()  # what may be left below OUT to resume from, or for the next run to remove
    holds_times: bool = False  # and so no two are equal


OF_A_PICTURE = " --size 160x90 --threads 2"
# A few rays suffice: what is tested is how the rasters are written.
OF_AN_ENERGY = " --directions 16 --step-min 60 --threads 2"

WRITERS = {
    "render to PNG": Writer("RAYTRACER", "render DATA -o OUT/a.png" + OF_A_PICTURE, "a.png"),
    "render to EXR": Writer(
        "RAYTRACER", "render DATA -o OUT/a.exr" + OF_A_PICTURE, "a.exr", (), True
    ),
    "render to TIFF": Writer(
        "RAYTRACER", "render DATA -o OUT/a.tif" + OF_A_PICTURE, "a.tif", (), True
    ),
    "render with a report": Writer(
        "RAYTRACER",
        "render DATA -o OUT/a.jpg --report OUT/a.json" + OF_A_PICTURE,
        "a.json",
        (),
        True,
    ),
    "render with a checkpoint": Writer(
        "RAYTRACER",
        "render DATA -o OUT/a.png --resume" + OF_A_PICTURE,
        "a.png",
        ("a.png.tiles",),
    ),
    "part of a picture": Writer(
        "RAYTRACER",
        "render DATA -o OUT/a.png --part 1/2 " + OF_A_PICTURE,
        "a.png.part-1-of-2.tiles",
        ("a.png.part-1-of-2.tiles",),
        True,
    ),
    "merge of parts": Writer("RAYTRACER", "merge TILES -o OUT/a.png", "a.png"),
    "merge to tiles": Writer("RAYTRACER", "merge TILES --tiles OUT/a.tiles", "a.tiles"),
    "animate": Writer(
        "RAYTRACER",
        "animate TURN DATA -o OUT/%02d.png" + OF_A_PICTURE,
        "00.png",
        (".frames.png.done",),
    ),
    "analyse terrain": Writer("RAYTRACER", "analyse terrain DATA -o OUT/a.tif", "a.tif"),
    "analyse with a checkpoint": Writer(
        "RAYTRACER",
        "analyse energy DATA -o OUT/a.tif --resume" + OF_AN_ENERGY,
        "a.tif",
        ("a.tif.tiles",),
    ),
    "analyse to a map": Writer(
        "RAYTRACER", "analyse terrain DATA -o OUT/a.tif --map OUT/a.svg", "a.svg"
    ),
    "analyse to a page": Writer(
        "RAYTRACER", "analyse terrain DATA -o OUT/a.tif --report OUT/a.html", "a.html"
    ),
    "objects of an analysis": Writer(
        "RAYTRACER",
        "analyse energy DATA -o OUT/a.tif --objects OUT/a.gpkg" + OF_AN_ENERGY,
        "a.gpkg",
    ),
    "facades of an analysis": Writer(
        "RAYTRACER",
        "analyse energy DATA -o OUT/a.tif --facades OUT/a.gpkg" + OF_AN_ENERGY,
        "a.gpkg",
    ),
    "map": Writer("RAYTRACER", "map DATA -o OUT/a.tif", "a.tif"),
    "map for the web": Writer("RAYTRACER", "map DATA -o OUT/a.pmtiles --tiles png", "a.pmtiles"),
    "archive": Writer("CONVERT", "DATA OUT/a.tvx", "a.tvx", ("a.tvx.journal", "a.tvx.part")),
    "changes of an archive": Writer(
        "CONVERT",
        "DATA OUT/a.tvx --squares SQUARE",
        "a.tvx",
        ("a.tvx.journal", "a.tvx.part"),
    ),
    "archive of shards": Writer("ARCHIVE", "merge SHARDS -o OUT/a.tvx", "a.tvx"),
    "archive of parts": Writer("ARCHIVE", "merge PARTS -o OUT/a.tvx", "a.tvx"),
    "parts of an archive": Writer("ARCHIVE", "split LARGE --max-mib 1 -o OUT", "large-0001.part"),
    "patched archive": Writer("ARCHIVE", "patch ARCHIVE CHANGES -o OUT/a.tvx", "a.tvx"),
    "items of a catalogue": Writer(
        "ARCHIVE",
        "stac ARCHIVE -o OUT --datetime 2023-04-01 --href https://example.org/",
        "archive.json",
    ),
    "plan of a country": Writer(
        "RAYTRACER", "country plan DATA -o OUT/plan --shards 2 -q", "plan/plan.json", (), True
    ),
    "site": Writer(
        "PUBLISH",
        "DATA OUT/site --no-preview",
        "site/place.tvx",
        ("site/place.tvx.journal", "site/place.tvx.part", "site/.terravox-publish.lock"),
    ),
    "Minecraft world": Writer("CONVERT", "DATA OUT/mc", "mc/level.dat", ("mc/conversion.journal",)),
    "MagicaVoxel": Writer("CONVERT", "DATA OUT/a.vox", "a.vox"),
    "OpenVDB": Writer("CONVERT", "DATA OUT/a.vdb", "a.vdb"),
    "glTF": Writer("CONVERT", "DATA OUT/a.glb", "a.glb"),
    "PLY": Writer("CONVERT", "DATA OUT/a.ply", "a.ply"),
    "LAZ": Writer("LAZ", "compress LAS OUT/a.laz", "a.laz"),
    "synthetic survey": Writer(
        "SURVEY",
        "--squares 1x1 --square-m 64 --density 4 -o OUT/sv",
        "sv/TM_462464_101456.laz",
    ),
}
# GDAL writes the time into a GeoPackage.
ENVIRONMENT = {"OGR_CURRENT_DATE": "2026-01-01T00:00:00.000Z"}


def ended(arguments, limit=None, value=0, environment=None, within=()):
    """@param limit a name of LIMITS, set to `value` @return the Run"""
    limits = [(LIMITS[limit], value)] if limit else []
    environment = {**ENVIRONMENT, **(environment or {})}
    return Run(arguments, limits=limits, environment=environment, within=within)


def write_las(path):
    """LAS 1.2 with points of format 0."""
    points = 4000
    places = b"".join(
        struct.pack("<3iH6x", 10 * i, 7919 * i % 5000, 104729 * i % 3000, i % 251)
        for i in range(points)
    )
    header = struct.pack(
        "<4s4x16xBB32s32s2xHHIIBHI5I12d",
        *(b"LASF", 1, 2, b"", b"", 0, 227, 227, 0, 0, 20, points, points, 0, 0, 0, 0),
        *(0.01, 0.01, 0.01, 0, 0, 0, 399.9, 0, 49.99, 0, 29.0, 0),
    )
    path.write_bytes(header + places)


class Inputs:
    """What writers read, each made when it is first asked for."""

    def __init__(self, folder):
        self.folder = folder

    def arguments(self, word):
        """@return what stands for a word of a Writer"""
        return getattr(self, word) if word.isupper() else [word]

    @functools.cached_property
    def DATA(self):
        # A quarter of survey(), without its orthophotos and truth: each format still fills several
        # pages, and the writers run a hundred times.
        made = make_survey(self.folder / "survey", "1x1", 128, 4)
        data = self.folder / "data"
        data.mkdir()
        for file in made.glob("*.laz"):
            shutil.copy(file, data)
        return [data]

    @functools.cached_property
    def SQUARE(self):
        return [file.stem for file in self.DATA[0].glob("*.laz")]

    @functools.cached_property
    def TURN(self):
        turn = self.folder / "turn.toml"
        turn.write_text("fps = 2\n\n[turntable]\nseconds = 1\n")
        return [turn]

    @functools.cached_property
    def TILES(self):
        picture = self.folder / "tiles.png"
        parts = [f"{part}/2" for part in (1, 2)]
        for part in parts:
            options = ["--part", part, "--cache", "none", *OF_A_PICTURE.split()]
            make("RAYTRACER", "render", *self.DATA, "-o", picture, *options)
        return sorted(self.folder.glob("tiles.png.part-*"))

    @functools.cached_property
    def ARCHIVE(self):
        archive = self.folder / "archive.tvx"
        make("CONVERT", *self.DATA, archive, "--cache", "none")
        return [archive]

    @functools.cached_property
    def CHANGES(self):
        changes = self.folder / "changes.tvx"
        make("CONVERT", *self.DATA, changes, "--cache", "none", "--squares", *self.SQUARE)
        return [changes]

    @functools.cached_property
    def SHARDS(self):
        shards = [self.folder / f"shard{i}.tvx" for i in (1, 2)]
        for i, shard in enumerate(shards, 1):
            make("CONVERT", *self.DATA, shard, "--cache", "none", "--shard", f"{i}/2")
        return shards

    @functools.cached_property
    def LARGE(self):
        """An archive of a little more than 1 MiB."""
        archive = self.folder / "large.tvx"
        make("CONVERT", "generated:7", archive, "--area", "0,0,512,512")
        return [archive]

    @functools.cached_property
    def PARTS(self):
        make("ARCHIVE", "split", *self.LARGE, "--max-mib", "1", "-o", self.folder / "parts")
        return sorted((self.folder / "parts").iterdir())

    @functools.cached_property
    def LAS(self):
        path = self.folder / "points.las"
        write_las(path)
        return [path]


class Writers(Case):
    """The common part of tests of writers."""

    @classmethod
    def setUpClass(cls):
        cls.folder = temporary_folder()
        cls.inputs = Inputs(cls.folder)
        cls.data = cls.inputs.DATA[0]
        cls.count = itertools.count()
        cls.good = {}

    def writer(self, name, out=None):
        """A run of a writer into a folder: one of its own, or another. @return arguments, folder"""
        if out is None:
            out = self.folder / f"out{next(self.count)}"
            out.mkdir()
        words = WRITERS[name].words.split()
        arguments = [binary(WRITERS[name].program)]
        for word in words:
            arguments += self.inputs.arguments(word.replace("OUT", str(out)))
        if "DATA" in words and "country" not in words:
            arguments += ["--cache", "none"]
        return arguments, out

    def whole(self, name):
        """Output of a writer without faults."""
        if name not in self.good:
            arguments, out = self.writer(name)
            ended(arguments).done()
            self.good[name] = out
        return self.good[name] / WRITERS[name].file

    def whole_pages(self, name, page_bytes):
        """Of all files that a writer leaves without faults."""
        self.whole(name)
        return sum(
            -(-path.stat().st_size // page_bytes)
            for path in self.good[name].rglob("*")
            if path.is_file()
        )

    def assert_alike(self, name, made, usual, message):
        """The same bytes, or the same but for times."""
        ending = made.suffix if WRITERS[name].holds_times else ""
        if ending in (".exr", ".tif"):
            self.assertAlike(made, usual, exact=True)
        elif ending == ".tiles":
            self.assertEqual(self.facts_of(made), self.facts_of(usual), message)
        elif ending == ".json":
            self.assertEqual(*(json.loads(f.read_bytes()).keys() for f in (made, usual)), message)
        else:
            self.assertEqual(made.read_bytes(), usual.read_bytes(), message)

    def facts_of(self, tiles):
        """What is there of a picture, and which it is."""
        return make("RAYTRACER", "merge", "--info", tiles).out.replace(str(tiles), "")

    def assert_as_on_a_good_day(self, name, out):
        made = out / WRITERS[name].file
        self.assert_alike(name, made, self.whole(name), f"{name}: not as without faults")

    def assert_told(self, run, what):
        """It ended by itself: with a code, and with a line where it failed."""
        self.assertIn(run.code, (0, 1, 3), f"{what}: {run}")
        if run.code == 1:
            self.assertTrue(run.last.startswith("terravox: "), f"{what}: {run}")

    def assert_nothing_half_written(self, name, run, out, hidden=()):
        """@param hidden  patterns of names that may be left as well"""
        kept = WRITERS[name].left
        if run.code == 0:
            self.assert_as_on_a_good_day(name, out)
        elif run.code == 1:
            self.whole(name)
            several = len([path for path in self.good[name].rglob("*") if path.is_file()]) > 1
            for path in out.rglob("*"):
                inside = str(path.relative_to(out))
                usual = self.good[name] / inside
                if inside in kept:
                    # Without its first bytes there is nothing in it to resume from. A list of
                    # frames stays all the same: other machines may have it open. So does a lock,
                    # which says that the folder is not complete.
                    if path.suffix not in (".done", ".lock"):
                        self.assertGreater(path.stat().st_size, 0, f"{name} left {inside}: {run}")
                    continue
                if any(map(path.match, hidden)) or (path.is_dir() and usual.is_dir()):
                    continue
                # Of several files some may be done when another one fails: then they are whole.
                self.assertTrue(several and usual.is_file(), f"{name} left {inside}: {run}")
                self.assert_alike(name, path, usual, f"{name} left half of {inside}: {run}")

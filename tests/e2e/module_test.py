#!/usr/bin/env python3
"""The modules: that of the voxel server, which reads LiDAR files and images, those of OpenVDB and
of OpenImageIO.

Programs start without them, and report their errors as their own.
"""

import os
import pathlib
import shutil
import subprocess
import unittest

from support import (
    Case,
    Run,
    Server,
    binary,
    has_sanitizers,
    square,
    survey,
    temporary_folder,
)

PROGRAM = pathlib.Path(binary("VOXELSERVER"))
MODULE = PROGRAM.parent / "terravox-worlds.so"
VDB_MODULE = PROGRAM.parent / "terravox-vdb.so"
PICTURE_MODULE = PROGRAM.parent / "terravox-pictures.so"
CONFIG = pathlib.Path(__file__).resolve().parents[2] / "config"


def libraries(file):
    return subprocess.run(["ldd", str(file)], check=True, capture_output=True, text=True).stdout


KEEPS_ALL = "builds with a sanitizer keep what is not used, and the libraries that it needs"


class Module(Case):
    @unittest.skipIf(has_sanitizers(), KEEPS_ALL)
    def test_the_program_does_not_load_gdal(self):
        self.assertIn("libgdal", libraries(MODULE))
        loaded = libraries(PROGRAM)
        self.assertIn("libsqlite3", loaded)
        for name in ("libgdal", "libproj", "libssl"):
            self.assertNotIn(name, loaded)
        self.assertLess(len(loaded.splitlines()), 30, loaded)

    def test_errors_of_the_module_end_the_program_as_its_own(self):
        folder = temporary_folder()
        (folder / "text.laz").write_bytes(b"no points here\n" * 50)
        no_crs = bytearray(square().read_bytes())
        at = no_crs.find(b"LASF_Projection")
        no_crs[at : at + 4] = b"NONE"
        (folder / "nowhere.laz").write_bytes(no_crs)
        for cache in ("none", temporary_folder()):
            for file, code, said in (
                ("text.laz", 1, "text.laz"),
                ("nowhere.laz", 2, "--crs EPSG:"),
                ("none.laz", 2, "none.laz"),
            ):
                with self.subTest(f"{file}, --cache {cache}"):
                    self.assertRefused(
                        Run([PROGRAM, folder / file, "--cache", cache, "--port", "0"]), code, said
                    )

    @unittest.skipIf(has_sanitizers(), KEEPS_ALL)
    def test_kept_boxes_are_served_where_gdal_cannot_be_loaded(self):
        cache = temporary_folder()
        server = Server(survey(), "--cache", cache, "--no-ahead")
        paths = server.box_paths()
        kept = server.get(paths[0])
        self.assertEqual((kept[0], server.stop()), (200, 0))
        broken = temporary_folder()
        gdal = next(word for word in libraries(MODULE).split() if word.startswith("libgdal"))
        (broken / gdal).write_bytes(b"no library\n" * 100)
        os.environ["LD_LIBRARY_PATH"] = str(broken)
        try:
            self.assertRefused(
                Run([PROGRAM, square(), "--cache", "none", "--port", "0"]), 1, "worlds module", gdal
            )
            server = Server(survey(), "--cache", cache, "--no-ahead")
        finally:
            del os.environ["LD_LIBRARY_PATH"]
        again = server.get(paths[0])
        status, _, body = server.get(paths[1])
        health = server.get("/healthz")
        self.assertEqual(server.stop(), 0, server.err)
        self.assertEqual((again[0], again[2]), (200, kept[2]))
        self.assertEqual(status, 500, body)
        self.assertEqual(health[0], 503)
        for reply in (health[2], body):
            self.assertNotIn(str(PROGRAM.parent).encode(), reply)
        self.assertNotIn(gdal.encode(), health[2])
        self.assertIn(gdal, server.err)
        self.assertIn("only boxes that were kept can be served", server.err)

    def test_facts_of_another_world_make_no_boxes_and_are_replaced(self):
        cache = temporary_folder()

        def start(voxel):
            server = Server(survey(), "--cache", cache, "--no-ahead", "--voxel", voxel)
            # After this the world is open, or is known not to open.
            status = server.get(server.box_paths()[0])[0]
            health = server.get("/healthz")[0]
            self.assertEqual(server.stop(), 0, server.err)
            return status, health, "start it again" in server.err

        self.assertEqual(start("1"), (200, 200, False))
        (first,) = (cache / "worlds").glob("*.facts")
        right = first.read_bytes()
        self.assertEqual(start("2"), (200, 200, False))
        (second,) = set((cache / "worlds").glob("*.facts")) - {first}
        self.assertNotEqual(second.read_bytes(), right)
        first.write_bytes(second.read_bytes())
        (cache / "boxes-1.sqlite").unlink()
        self.assertEqual(start("1"), (500, 503, True))
        self.assertFalse(first.exists())
        self.assertEqual(start("1"), (200, 200, False))
        self.assertEqual(first.read_bytes(), right)

    def test_without_the_module_the_program_reports_that(self):
        alone = temporary_folder() / PROGRAM.name
        shutil.copy(PROGRAM, alone)
        os.environ["TERRAVOX_CONFIG"] = str(CONFIG)
        try:
            for cache in ("none", temporary_folder()):
                with self.subTest(f"--cache {cache}"):
                    self.assertRefused(
                        Run([alone, square(), "--cache", cache, "--port", "0"]),
                        1,
                        "worlds module",
                        "terravox-worlds.so",
                    )
            self.assertDone(Run([alone, "--version"]))
        finally:
            del os.environ["TERRAVOX_CONFIG"]


def programs():
    folder = PROGRAM.parent
    files = [path for path in folder.glob("terravox-*") if not path.suffix]
    files += [folder.parent / "lib" / "libterravox.so"]
    return files + list(folder.parent.glob("python/terravox/_core*.so"))


def without(module, library):
    """@return an environment in which that library of a module cannot be loaded, and its name"""
    broken = temporary_folder()
    name = next(word for word in libraries(module).split() if word.startswith(library))
    (broken / name).write_bytes(b"no library\n" * 100)
    return {"LD_LIBRARY_PATH": str(broken)}, name


@unittest.skipUnless(VDB_MODULE.exists(), "a build without OpenVDB (TERRAVOX_VDB=OFF)")
@unittest.skipIf(has_sanitizers(), KEEPS_ALL)
class OpenVdb(Case):
    def test_nothing_but_its_module_loads_openvdb_at_the_start(self):
        self.assertIn("libopenvdb", libraries(VDB_MODULE))
        for file in programs():
            with self.subTest(file.name):
                self.assertNotRegex(libraries(file), "libopenvdb|liblog4cplus")

    def test_without_openvdb_all_other_formats_are_written(self):
        environment, openvdb = without(VDB_MODULE, "libopenvdb")
        convert = [binary("CONVERT"), square(), "--cache", "none", "--quiet"]
        out = temporary_folder()
        run = Run([*convert, out / "a.vdb"], environment=environment)
        self.assertRefused(run, 1, "load the OpenVDB module", openvdb)
        self.assertEqual(list(out.iterdir()), [])
        self.assertDone(Run([*convert, out / "a.vox"], environment=environment))


@unittest.skipIf(has_sanitizers(), KEEPS_ALL)
class Pictures(Case):
    def test_nothing_but_its_module_loads_openimageio_at_the_start(self):
        self.assertIn("libOpenImageIO", libraries(PICTURE_MODULE))
        for file in programs():
            with self.subTest(file.name):
                self.assertNotRegex(libraries(file), "libOpenImageIO|libOpenEXR|libopencv")

    def test_without_openimageio_its_formats_are_refused_before_any_work(self):
        environment, library = without(PICTURE_MODULE, "libOpenImageIO.so")
        render = [binary("RAYTRACER"), "render", "generated:5", "--size", "32x18", "--quiet"]
        out = temporary_folder()
        for ending in (".exr", ".jpg", ".webp"):
            with self.subTest(ending):
                run = Run([*render, "-o", out / f"a{ending}"], environment=environment)
                self.assertRefused(run, 1, "load the module of pictures", library)
        self.assertEqual(list(out.iterdir()), [])
        for ending in (".png", ".tif"):
            self.assertDone(Run([*render, "-o", out / f"a{ending}"], environment=environment))

    def test_where_it_has_no_room_its_formats_are_refused_and_nothing_waits(self):
        little = ["prlimit", f"--as={420 << 20}", binary("RAYTRACER"), "render", "generated:5"]
        out = temporary_folder()
        run = Run([*little, "--size", "32x18", "--quiet", "-o", out / "a.exr"])
        self.assertRefused(run, 1, "load the module of pictures", "ulimit -v")
        self.assertEqual(list(out.iterdir()), [])


if __name__ == "__main__":
    unittest.main()

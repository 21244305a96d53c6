#!/usr/bin/env python3
"""The Python package: values, types, errors, Ctrl-C, and what stays behind."""

import concurrent.futures
import doctest
import gc
import math
import multiprocessing
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np
import terravox
import xarray as xr

ROOT = pathlib.Path(__file__).resolve().parents[4]
GRASS = 4
# Ends a process that hangs.
HANGS_S = 600
SMALL = {"output.size": "48x32", "quality.samples": 1}
_folder = tempfile.TemporaryDirectory(prefix="terravox-python-")
FOLDER = pathlib.Path(_folder.name)
_worlds = {}


# Prints the exit code of a forked process that ends at once, as Python ends.
FORK = (
    "sys.stdout.flush()\n"
    "child = os.fork()\n"
    "if child == 0:\n"
    "    sys.exit(0)\n"
    "print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))\n"
)


def village():
    """@return a small synthetic place with a CRS, as an archive that is open"""
    if "village" not in _worlds:
        (laz,) = terravox.survey(FOLDER / "survey", density=2, square_m=208)
        world = terravox.open(laz, cache="none")
        world.convert(FOLDER / "village.tvx")
        _worlds["village"] = terravox.open(FOLDER / "village.tvx")
    return _worlds["village"]


def run_python(code, *, loses_objects=False):
    """Runs code in a process of its own.

    :param loses_objects: what CPython does not free there is no leak of the package
    """
    environment = dict(os.environ)
    if loses_objects and "ASAN_OPTIONS" in environment:
        environment["ASAN_OPTIONS"] += ":detect_leaks=0"
    process = subprocess.Popen(
        [sys.executable, "-c", code],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        out, err = process.communicate(timeout=HANGS_S)
    except subprocess.TimeoutExpired:
        # With the processes that it has forked, which hold its output open.
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        raise
    return subprocess.CompletedProcess(process.args, process.returncode, out, err)


def highest(archive):
    """Runs in a process of its own."""
    return float(terravox.open(archive).surface().max())


def open_descriptors():
    return len(list(pathlib.Path("/proc/self/fd").iterdir()))


def resident_kib():
    return int(pathlib.Path("/proc/self/statm").read_text().split()[1]) * 4


class Values(unittest.TestCase):
    def test_facts(self):
        world = village()
        self.assertEqual(world.crs, "EPSG:3794")
        west, south, east, north = world.bounds
        self.assertAlmostEqual(east - west, 208, delta=2)
        self.assertAlmostEqual(north - south, 208, delta=2)
        self.assertLess(world.heights[0], world.heights[1])
        self.assertEqual(world.voxel_m, 1)
        self.assertAlmostEqual(world.centre[0], 46.05, delta=0.1)
        # West of the meridian of 15 degrees the map's north lies west of true north.
        self.assertAlmostEqual(world.convergence_deg, -0.35, delta=0.02)
        self.assertEqual(world.damage, [])
        self.assertIn("EPSG:3794", repr(world))

    def test_surface_is_that_of_voxels_and_of_the_analysis(self):
        world = village()
        surface = world.surface()
        self.assertIsInstance(surface, xr.DataArray)
        self.assertEqual(surface.dtype, np.float32)
        voxels = world.voxels()
        self.assertEqual(voxels.dtype, np.uint8)
        self.assertEqual(voxels.shape[1:], surface.shape)
        top = voxels.shape[0] - np.argmax(voxels[::-1] > 0, axis=0)
        np.testing.assert_array_equal(world.heights[0] + top, surface.values)
        terrain = world.terrain()
        np.testing.assert_array_equal(terrain.dsm.values, surface.values)
        self.assertEqual(terrain.dsm.attrs["units"], "m")
        self.assertEqual(terrain.attrs["holes"], 0)

    def test_coordinates_are_middles_of_cells_and_the_crs_is_named(self):
        surface = village().surface()
        west, _, _, north = village().bounds
        self.assertEqual(float(surface.x[0]), west + 0.5)
        self.assertEqual(float(surface.y[0]), north - 0.5)
        self.assertEqual(float(surface.y[1] - surface.y[0]), -1)
        mapping = surface.coords[surface.attrs["grid_mapping"]].attrs
        self.assertIn("Slovenia 1996", mapping["crs_wkt"])
        numbers = [float(one) for one in mapping["GeoTransform"].split()]
        self.assertEqual(numbers, [west, 1, 0, north, 0, -1])

    def test_bounds_choose_a_part(self):
        world = village()
        # Voxels of level 1 begin at even coordinates.
        west, south = (2 * round(edge / 2) for edge in world.bounds[:2])
        part = (west + 10, south + 20, west + 42, south + 60)
        self.assertEqual(world.surface(part).shape, (40, 32))
        self.assertEqual(world.surface(part, level=1).shape, (20, 16))
        block = world.voxels((*part, world.heights[0], world.heights[0] + 8))
        self.assertEqual(block.shape, (8, 40, 32))

    def test_arrays_live_longer_than_their_world(self):
        world = terravox.open(FOLDER / "village.tvx") if village() else None
        voxels = world.voxels()
        expected = voxels.sum(dtype=np.int64)
        del world
        gc.collect()
        self.assertEqual(voxels.sum(dtype=np.int64), expected)

    def test_a_world_is_closed_at_the_end_of_a_statement(self):
        village()
        before = open_descriptors()
        with terravox.open(FOLDER / "village.tvx") as world:
            surface = world.surface()
            self.assertGreater(open_descriptors(), before)
        self.assertEqual(open_descriptors(), before)
        self.assertGreater(float(surface.max()), 0)
        self.assertEqual(world.bounds, village().bounds)
        self.assertIn("closed", repr(world))
        self.assertIn("closed", world._repr_html_())
        with self.assertRaisesRegex(ValueError, "it was closed"):
            world.surface()
        world.close()

    def test_pictures(self):
        world = village()
        picture = world.render({"camera": {"azimuth_deg": 200.0}}, fields=SMALL)
        self.assertEqual(picture.rgb.shape, (32, 48, 3))
        self.assertEqual(picture.light.shape, (32, 48, 4))
        self.assertEqual(np.asarray(picture).shape, (32, 48, 3))
        self.assertEqual(picture.layers, {})
        self.assertTrue(np.isinf(picture.depth).any())
        self.assertTrue(picture.png().startswith(b"\x89PNG"))
        self.assertIn("data:image/png;base64,", world._repr_html_())
        layers = world.render(fields={**SMALL, "output.layers": "all"}).layers
        self.assertEqual(layers["normal"].shape, (32, 48, 3))
        self.assertEqual(layers["material"].shape, (32, 48))

    def test_a_picture_is_that_of_the_command(self):
        program = os.environ.get("TERRAVOX_RAYTRACER")
        if not program:
            self.skipTest("TERRAVOX_RAYTRACER names no program")
        village()
        out = FOLDER / "command.png"
        command = [program, "render", FOLDER / "village.tvx", "-o", out, "-q"]
        command += ["--size", "48x32", "--samples", "1", "--look", "plain"]
        subprocess.run(command, check=True)
        compare = os.environ["TERRAVOX_COMPARE"]
        mine = FOLDER / "mine.png"
        village().render(fields=SMALL).save(mine)
        subprocess.run([compare, "--exact", out, mine], check=True)

    def test_kinds_of_analyses(self):
        world = village()
        shadow = world.analyse("shadow", resolution=8, fields={"sun.time_h": 12})
        measured = shadow.sunlit.values[np.isfinite(shadow.sunlit.values)]
        self.assertEqual(set(measured.tolist()), {0.0, 1.0})
        west, south, east, north = world.bounds
        middle = ((west + east) / 2, (south + north) / 2, 900)
        seen = world.analyse("sight", resolution=8, observers=[middle])
        self.assertGreater(float(seen.seen.sum()), 10)

    def test_materials(self):
        self.assertEqual(terravox.MATERIALS[0].name, "air")
        self.assertEqual(terravox.MATERIALS[GRASS].name, "grass")
        self.assertTrue(all(m.number == i for i, m in enumerate(terravox.MATERIALS)))

    def test_examples_in_docstrings(self):
        failed, tried = doctest.testmod(terravox)
        self.assertEqual(failed, 0)
        self.assertGreater(tried, 0)


class Guide(unittest.TestCase):
    def test_examples_of_the_guide(self):
        folder = str(FOLDER / "guide")
        failed, tried = doctest.testfile(
            str(ROOT / "docs" / "guide" / "programming.md"),
            module_relative=False,
            globs={"folder": folder},
        )
        self.assertEqual(failed, 0)
        self.assertGreater(tried, 10)


class Errors(unittest.TestCase):
    def refused(self, call, *parts):
        with self.assertRaises(ValueError) as caught:
            call()
        for part in parts:
            self.assertIn(part, str(caught.exception))

    def test_messages_are_those_of_the_programs(self):
        world = village()
        self.refused(lambda: terravox.open("/nowhere"), "/nowhere does not exist")
        self.refused(lambda: world.surface(level=99), "level = 99", "allowed: 0 to")
        self.refused(lambda: world.surface((0, 0, 1, 1)), "nothing is within")
        self.refused(lambda: world.surface((0, 1)), "2 numbers of bounds")
        self.refused(lambda: world.surface((math.nan, 0, 1, 1)), "not a number")
        self.refused(lambda: world.surface(threads=-1), "-1", "0 to 1024")
        self.refused(lambda: terravox.open("generated:7", fields={"sun.size": 2}), "sun.size")
        self.refused(lambda: world.render({"camera": {"fow": 3}}), "unknown field 'camera.fow'")
        self.refused(lambda: world.analyse("gravity"), "gravity", "terrain")
        with self.assertRaisesRegex(terravox.Error, "/nowhere/a.tif: no such file"):
            world.analyse("sky", horizon="/nowhere/a.tif")
        self.refused(lambda: world.cast((0, 0, 0), (0, 0, 0)), "no direction")
        self.refused(lambda: world.cast((0, 0, math.nan), (0, 0, 1)), "endless number")
        self.refused(lambda: world.cast([[1, 2]], (0, 0, 1)), "n x 3")

    def test_kinds_of_errors(self):
        self.assertTrue(issubclass(terravox.UsageError, terravox.Error))
        self.assertTrue(issubclass(terravox.UsageError, ValueError))
        self.assertTrue(issubclass(terravox.Error, RuntimeError))
        broken = FOLDER / "broken.laz"
        broken.write_bytes(b"LASF" + bytes(100))
        with self.assertRaises(terravox.Error):
            terravox.open(broken)

    def test_scenes_of_wrong_types(self):
        wrong = ({"camera": 3}, {"camera": {"look": object()}}, {"a]\n[b": {}})
        for scene in (*wrong, {"camera": {"a = 1\nb": 2}}):
            with self.assertRaises(TypeError):
                village().render(scene)

    def test_rays_of_wrong_types(self):
        with self.assertRaises((TypeError, ValueError)):
            village().cast("north", (0, 0, 1))
        with self.assertRaises((TypeError, ValueError)):
            village().cast([[1, 2, 3]], [[0, 0, 1], [0, 0, 1]])
        with self.assertRaisesRegex(ValueError, "rays of complex128; allowed: real numbers"):
            village().occluded([[1j, 2, 3]], (0, 0, 1))
        hidden = np.ma.array([[1.0, 2, 3]], mask=[[0, 1, 0]])
        for origins, directions in ((hidden, (0, 0, 1)), ((1, 2, 3), hidden)):
            with self.assertRaisesRegex(ValueError, "rays with 1 masked values of 3"):
                village().cast(origins, directions)

    def test_masked_numbers_are_no_numbers(self):
        nothing = np.ma.masked
        west, south, east, north = village().bounds
        for call in (
            lambda: village().surface((west, south, east, nothing)),
            lambda: village().analyse("sight", observers=[(west, north, nothing)]),
            lambda: village().render({"sun": {"time_h": nothing}}, fields=SMALL),
            lambda: village().render(fields={**SMALL, "sun.time_h": nothing}),
        ):
            with self.assertRaises((TypeError, ValueError)):
                call()


class Interruptions(unittest.TestCase):
    """A call that would take long ends soon after Ctrl-C, and the world goes on."""

    def setUp(self):
        # A shell starts programs in the background so that they ignore Ctrl-C.
        before = signal.signal(signal.SIGINT, signal.default_int_handler)
        self.addCleanup(signal.signal, signal.SIGINT, before)

    def interrupted_after_s(self, call):
        main = threading.main_thread().ident
        pressed = []

        def press():
            time.sleep(0.3)
            pressed.append(time.monotonic())
            signal.pthread_kill(main, signal.SIGINT)

        thread = threading.Thread(target=press)
        thread.start()
        with self.assertRaises(KeyboardInterrupt):
            call()
        ended = time.monotonic()
        thread.join()
        return ended - pressed[0]

    def test_a_picture(self):
        world = village()
        long = {"output.size": "2000x2000", "quality.samples": 512}
        # That it ends soon is the point, not how soon exactly on a busy machine.
        self.assertLess(self.interrupted_after_s(lambda: world.render(fields=long)), 30)
        self.assertEqual(world.render(fields=SMALL).holes, 0)

    def test_a_conversion(self):
        world = terravox.open("generated:7")
        out = FOLDER / "interrupted.tvx"
        bounds = (-2000, -2000, 2000, 2000)
        self.assertLess(self.interrupted_after_s(lambda: world.convert(out, bounds=bounds)), 30)
        self.assertFalse(out.exists())

    def test_progress_is_told_and_its_errors_come_through(self):
        world = village()
        told = []
        world.render(fields=SMALL, progress=lambda done, total: told.append((done, total)))
        self.assertTrue(told)
        self.assertEqual(told[-1][0], told[-1][1])

        def fail(_done, _total):
            raise LookupError("enough")

        with self.assertRaises(LookupError):
            world.render(fields={"output.size": "1000x1000"}, progress=fail)

    def test_other_threads_go_on_meanwhile(self):
        world = village()
        counted = []
        stop = threading.Event()

        def count():
            while not stop.is_set():
                counted.append(1)
                time.sleep(0.001)

        thread = threading.Thread(target=count)
        thread.start()
        before = len(counted)
        world.render(fields={"output.size": "320x240", "quality.samples": 4})
        after = len(counted)
        stop.set()
        thread.join()
        self.assertGreater(after, before)

    def test_several_threads_use_one_world(self):
        world = village()
        expected = world.surface().values

        def work(_):
            world.render(fields=SMALL)
            return np.array_equal(world.surface().values, expected)

        with concurrent.futures.ThreadPoolExecutor(4) as threads:
            self.assertEqual(list(threads.map(work, range(8))), [True] * 8)


class Processes(unittest.TestCase):
    def test_a_forked_process_is_told_to_start_anew(self):
        world = village()
        world.surface()
        read, write = os.pipe()
        child = os.fork()
        if child == 0:
            with os.fdopen(write, "w") as out:
                for call in (world.surface, lambda: terravox.open("generated:7")):
                    try:
                        call()
                    except terravox.UsageError as error:
                        out.write(f"{'spawn' in str(error)} ")
            os._exit(0)
        os.close(write)
        with os.fdopen(read) as told:
            self.assertEqual(told.read(), "True True ")
        self.assertEqual(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), 0)
        self.assertEqual(world.render(fields=SMALL).holes, 0)

    def test_a_process_that_was_forked_before_any_use_works(self):
        village()
        code = (
            "import multiprocessing, terravox\n"
            "def highest(path):\n"
            "    return float(terravox.open(path).surface().max())\n"
            "with multiprocessing.get_context('fork').Pool(2) as pool:\n"
            f"    print(pool.map(highest, [{str(FOLDER / 'village.tvx')!r}] * 2))\n"
        )
        done = run_python(code)
        expected = f"{[float(village().surface().max())] * 2}\n"
        self.assertEqual((done.returncode, done.stdout), (0, expected), done.stderr)

    def test_spawned_processes_work(self):
        village()
        with multiprocessing.get_context("spawn").Pool(2) as pool:
            heights = pool.map(highest, [FOLDER / "village.tvx"] * 2)
        self.assertEqual(heights, [float(village().surface().max())] * 2)


class Leaks(unittest.TestCase):
    def test_hundreds_of_worlds_leave_nothing(self):
        village()

        def use(times):
            for _ in range(times):
                world = terravox.open(FOLDER / "village.tvx")
                world.surface()
                world.cast((0, 0, 1e6), (0, 0, -1))
            gc.collect()

        use(50)
        descriptors = open_descriptors()
        before = resident_kib()
        use(200)
        self.assertEqual(open_descriptors(), descriptors)
        # A world that stayed would take megabytes.
        self.assertLess(resident_kib() - before, 64 * 1024)

    def test_the_interpreter_ends_while_another_thread_is_in_a_call(self):
        village()
        code = (
            "import threading, time, terravox\n"
            f"w = terravox.open({str(FOLDER / 'village.tvx')!r})\n"
            "def work():\n"
            "    while True:\n"
            "        w.render(fields={'output.size': '400x400', 'quality.samples': 64})\n"
            "threading.Thread(target=work, daemon=True).start()\n"
            "time.sleep(0.5)\n"
        )
        # CPython ends the thread wherever it is, with all that it holds.
        done = run_python(code, loses_objects=True)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_the_interpreter_ends_after_an_interrupted_call_and_so_does_one_forked_then(self):
        village()
        code = (
            "import os, signal, sys, threading, terravox\n"
            f"w = terravox.open({str(FOLDER / 'village.tvx')!r})\n"
            "main = threading.main_thread().ident\n"
            "threading.Timer(0.3, lambda: signal.pthread_kill(main, signal.SIGINT)).start()\n"
            "try:\n"
            "    w.render(fields={'output.size': '3000x3000', 'quality.samples': 64})\n"
            "except KeyboardInterrupt:\n"
            "    print('interrupted')\n" + FORK
        )
        done = run_python(code)
        self.assertEqual((done.returncode, done.stdout), (0, "interrupted\n0\n"), done.stderr)

    def test_a_process_that_is_forked_after_the_import_ends(self):
        done = run_python("import os, sys, terravox\n" + FORK)
        self.assertEqual((done.returncode, done.stdout), (0, "0\n"), done.stderr)

    def test_a_process_that_is_forked_after_an_openvdb_file_was_written_ends(self):
        if not (pathlib.Path(terravox.__file__).parent / "terravox-vdb.so").exists():
            self.skipTest("this package has no OpenVDB")
        village()
        code = (
            "import os, sys, terravox\n"
            f"w = terravox.open({str(FOLDER / 'village.tvx')!r})\n"
            f"w.convert({str(FOLDER / 'forked.vdb')!r})\n"
        )
        done = run_python(code + FORK)
        self.assertEqual((done.returncode, done.stdout), (0, "0\n"), done.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)

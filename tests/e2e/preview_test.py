#!/usr/bin/env python3
"""The preview window as a user works with it, on a virtual display.

Fly, drag the sun, pick, save, render; and what fails meanwhile.
"""

import json
import math
import os
import pathlib
import re
import sys
import unittest

from desktop import MISSING, Desktop, changed, colours
from support import (
    FARM_TOKEN,
    Case,
    Program,
    Run,
    Server,
    binary,
    hold_port,
    only_in_all,
    render,
    survey,
    temporary_folder,
    wait_until,
)

TOKEN = {"TERRAVOX_FARM_TOKEN": FARM_TOKEN, "TERRAVOX_FARM_TEST": "1"}
WIDTH = 1000
HEIGHT = 640
FIRST = "first picture after"  # of a change
# Right of the panel, away from status line and map, in a picture of 16 to 9.
PICTURE = (440, 160, 740, 370)
MIDDLE = (682, 340)
FRAMES_TO_GROW = 2
# Drivers of windows leak, and are unloaded before the program ends: no list can name them then.
if "ASAN_OPTIONS" in os.environ:
    os.environ["ASAN_OPTIONS"] += ":detect_leaks=0"
KEEP = os.environ.get("TERRAVOX_KEEP_SCREENS")  # a folder of pictures for visual checks


class NoDisplay(Case):
    def test_one_clear_line(self):
        run = Run(
            [binary("RAYTRACER"), "preview", "generated:3"],
            environment={"DISPLAY": "", "WAYLAND_DISPLAY": "", "XDG_RUNTIME_DIR": ""},
        )
        self.assertRefused(
            run, 1, "open the preview window", "terravox render WORLD -o picture.png"
        )

    def test_errors_are_reported_before_a_window_opens(self):
        self.assertRefused(Run([binary("RAYTRACER"), "preview", "/nowhere"]), 2, "/nowhere")
        self.assertRefused(
            Run([binary("RAYTRACER"), "preview", "generated:3", "--window", "0x5"]),
            2,
            "output.size",
            "65536",
        )


@unittest.skipIf(MISSING, f"without {', '.join(MISSING)}")
class Window(Case):
    @classmethod
    def setUpClass(cls):
        cls.desktop = Desktop(1280, 1600)

    @classmethod
    def tearDownClass(cls):
        cls.desktop.stop()

    def setUp(self):
        self.out = temporary_folder()

    def preview(self, world, *arguments, environment=None, first=True, width=WIDTH, height=HEIGHT):
        words = ["preview", world, "--window", f"{width}x{height}", "--log", "trace"]
        words += ["--report", self.out / "report.json", "--save-scene", self.out / "scene.toml"]
        environment = {**self.desktop.environment, **(environment or {})}
        program = Program(*words, *arguments, environment=environment, cwd=self.out, test=self)
        if first:
            program.saw(FIRST)
            self.desktop.do("mousemove", *MIDDLE)
            self.saved(program)
        return program

    def worker(self):
        words = ("worker", "--listen", "127.0.0.1:0", "--threads", "1")
        return Program(*words, environment=TOKEN, test=self).address()

    def quit(self, program, code=0):
        self.desktop.key("ctrl+q")
        self.assertEqual(program.end(), code, program.log()[-3000:])
        return json.loads((self.out / "report.json").read_text())

    def place_of(self, program, name):
        """@return the middle of an item, as last reported, and its width

        No text field may have the focus.
        """
        program.saw(f"place of {re.escape(name)}: ")
        places = self.places(program, name)
        before = None
        while len(places) != before:  # windows grow until all fits, which takes some frames
            before = len(places)
            for _ in range(FRAMES_TO_GROW):
                self.saved(program)
            places = self.places(program, name)
        return places[-1]

    def places(self, program, name):
        found = re.findall(rf"place of {re.escape(name)}: (\d+) (\d+) (\d+) (\d+)", program.log())
        return [
            ((x0 + x1) / 2, (y0 + y1) / 2, x1 - x0)
            for x0, y0, x1, y1 in (map(int, place) for place in found)
        ]

    def press(self, program, name):
        x, y, _ = self.place_of(program, name)
        self.desktop.click(x, y)

    def count(self, program, pattern):
        return len(re.findall(pattern, program.log()))

    def keep(self, name):
        if KEEP:
            self.desktop.save(pathlib.Path(KEEP) / (name + ".ppm"))

    def wait_for_more(self, program, pattern, than):
        """Until the log has more lines with the pattern than that."""
        program.saw(pattern, times=than + 1)

    def see_change(self, before, share, box=PICTURE):
        """What is to be seen once that share of the box is not as it was before."""
        wait_until(
            lambda: changed(before, self.desktop.see(), box) > share,
            f"more than {share} of {box} has changed",
            pause_s=0.1,
        )
        return self.desktop.see()

    def saved(self, program):
        """Saves the scene and returns it; no text field may have the focus.

        All keys and clicks before have been handled by then, since they are handled in order.
        """
        before = self.count(program, "saved .*scene.toml")
        self.desktop.key("ctrl+s")
        self.wait_for_more(program, "saved .*scene.toml", before)
        return (self.out / "scene.toml").read_text()

    def settle(self, program):
        """Waits until the picture and the map are finished and nothing moves.

        @return the visible state
        """
        self.saved(program)
        last = max(
            i for i, line in enumerate(program.lines) if re.search("saved .*scene.toml", line or "")
        )
        program.saw("at rest", after=last)
        return self.desktop.see()

    def time_h(self, program):
        return float(re.search(r"time_h = (\S+)", self.saved(program)).group(1))

    def fly(self, program, first):
        """Moves and turns the camera. @return the visible state at the end"""
        desktop = self.desktop
        with desktop.held("w"):
            self.see_change(first, 0.5)
        flown = self.settle(program)
        with desktop.held("a"):
            self.see_change(flown, 0.2)
        flown = self.settle(program)
        desktop.drag(500, 300, 600, 260)
        self.see_change(flown, 0.2)
        self.keep("flown")
        desktop.key("Home")
        return self.settle(program)

    def pick(self, program):
        """Picks the voxel in the middle of the picture."""
        self.desktop.click(*MIDDLE)
        for fact in ("voxel", "height", "material", "source class", "square", "distance"):
            program.saw(f"picked {fact}: ")
        self.settle(program)
        self.keep("picked")

    def assert_final_picture_is_the_headless_one(self, program):
        """From the window and without one: the same bytes."""
        self.desktop.key("ctrl+r")
        wait_until((self.out / "picture.png").exists, "the final picture")
        scene, headless = self.out / "scene.toml", self.out / "headless.png"
        self.assertDone(render(survey(), "--scene", scene, "--quiet", "-o", headless))
        is_same = (self.out / "picture.png").read_bytes() == headless.read_bytes()
        self.assertTrue(is_same, program.log()[-2000:])

    def test_fly_drag_the_sun_pick_save_and_render(self):
        program = self.preview(survey(), "--size", "160x90", "--samples", "2")
        desktop = self.desktop
        first = self.settle(program)
        self.assertGreater(colours(first, PICTURE), 200)
        self.keep("open")
        flown = self.fly(program, first)

        x, y, width = self.place_of(program, "sun.time_h")
        desktop.drag(x, y, x + width * 0.3, y)
        self.see_change(flown, 0.3)
        self.settle(program)
        self.keep("sun")
        self.pick(program)

        time_h = self.time_h(program)
        self.assertGreater(time_h, 17)
        desktop.key("ctrl+z")
        self.assertEqual(self.time_h(program), 16)
        desktop.key("ctrl+y")
        self.assertEqual(self.time_h(program), time_h)
        self.assert_final_picture_is_the_headless_one(program)

        desktop.key("ctrl+p")
        program.saw("saved preview.png")
        self.assertTrue((self.out / "preview.png").read_bytes().startswith(b"\x89PNG"))
        report = self.quit(program)
        for what in ("frames", "first_pictures", "stops"):
            print(f"{what}: {report[what]}", file=sys.stderr)
        self.assertGreater(report["first_pictures"]["count"], 5)

    @only_in_all
    def test_layers_themes_help_and_a_measured_distance(self):
        program = self.preview(survey(), "--samples", "1")
        desktop = self.desktop
        seen = [self.settle(program)]
        for layer in range(13):
            desktop.key("F6")
            self.see_change(seen[-1], 0.02)
            seen.append(self.settle(program))
            self.keep(f"layer-{layer + 1:02}")
            self.assertGreater(colours(seen[-1], PICTURE), 1, f"layer {layer + 1}")
        desktop.key("F6", "F7")
        self.see_change(seen[0], 0.5, (10, 300, 300, 600))
        desktop.key("F1")
        self.settle(program)
        desktop.key("Escape", "m")
        desktop.click(640, 330)
        self.settle(program)  # a ray has met something there
        desktop.click(700, 350)
        program.saw(r"measured \d+\.\d\d m on the map, -?\d+\.\d\d m up")
        self.keep("measured")
        desktop.key("m", "f", "F2")
        desktop.drag(500, 300, 560, 330)
        self.settle(program)
        self.keep("no-panel")
        self.quit(program)

    @only_in_all
    def test_the_panel_by_keyboard_alone(self):
        program = self.preview(survey(), "--samples", "1", "--ui-scale", "1.5", "--light")
        desktop = self.desktop
        with desktop.at_once(program):
            desktop.key("ctrl+Tab")
            desktop.key("Down", "Down", "Down", "Return")  # buttons, heading, date, time
        desktop.do("type", "12.5")
        desktop.key("Return")
        self.settle(program)
        self.keep("keyboard")
        desktop.key("Down", "Escape")
        before = self.settle(program)
        with desktop.held("Left"):  # the view's again
            self.see_change(before, 0.1, (600, 200, 900, 400))
        self.assertEqual(self.time_h(program), 12.5)
        self.quit(program)

    @only_in_all
    def test_threads_and_workers_are_added_and_a_final_picture_given_up(self):
        address = self.worker()
        slow = ["--integrator", "path", "--samples", "4000", "--size", "1600x900", "--threads", "0"]
        program = self.preview(survey(), *slow, environment=TOKEN, height=1500)
        desktop = self.desktop
        self.press(program, "Processors")
        self.press(program, "address")
        desktop.do("type", "not a place:99999999")
        desktop.key("Return")
        self.press(program, "Add worker")
        program.saw("99999999")
        self.press(program, "address")
        desktop.key("ctrl+a")
        desktop.do("type", address)
        desktop.key("Return")
        self.press(program, "Add worker")
        program.saw(r"answer: .* of (?!this machine)")
        x, y, width = self.place_of(program, "threads")
        desktop.click(x + width * 0.1, y)
        self.saved(program)
        self.keep("processors")
        x, y, width = self.place_of(program, "green")
        desktop.click(x - width / 2 + 8, y)
        self.saved(program)
        self.press(program, "Render")
        self.press(program, "Give up")  # which is there as long as it is rendered
        program.saw("the final picture: given up")
        wait_until(
            lambda: not any(p.name.startswith("picture") for p in self.out.iterdir()),
            "nothing is left of it, hours before its end",
        )
        self.keep("given-up")
        self.quit(program)

    @only_in_all
    def test_coordinates_a_click_on_the_map_and_a_named_view_lead_there(self):
        program = self.preview(survey(), "--samples", "1", height=1500)
        desktop = self.desktop

        def target():
            """Nowhere as long as the scene has none, since it frames the world."""
            scene = self.saved(program)
            found = re.search(r"target = \[ *(\S+), *(\S+), *(\S+) *\]", scene)
            return [float(v) for v in found.groups()] if found else [math.inf] * 3

        def at(easting, northing, within):
            wait_until(
                lambda: abs(target()[0] - easting) + abs(target()[1] - northing) < within,
                f"the target is {easting}, {northing}",
            )
            return target()[2]

        self.press(program, "place")
        desktop.do("type", "462500.5, 101400.5")
        desktop.key("Return")
        self.assertTrue(400 < at(462500.5, 101400.5, 0.01) < 600)
        self.press(program, "place")
        desktop.key("ctrl+a")
        desktop.do("type", "somewhere")
        desktop.key("Return")
        program.saw("go to 'somewhere': not two numbers")
        x, y, width = self.place_of(program, "map")
        desktop.click(x + width / 4, y)
        at(462368 + 192, 101360 + 128, 4)
        self.keep("went")
        self.press(program, "Demo castle")
        program.saw(r"place of Demo castle")
        self.assertGreater(abs(target()[0] - 462560), 4)
        self.quit(program)

    @only_in_all
    def test_a_flight_is_made_played_and_saved(self):
        program = self.preview(survey(), "--size", "64x36", "--samples", "1")
        desktop = self.desktop
        before = self.settle(program)
        for key in ("Left", "w"):
            desktop.key("k")
            with desktop.held(key):
                self.see_change(before, 0.3)
            before = self.settle(program)
        desktop.key("k")
        program.saw("key frame at 6.00 s")
        before = self.settle(program)
        self.keep("flight")
        desktop.key("p")
        self.see_change(before, 0.1)
        self.press(program, "Save flight")
        program.saw("saved flight.toml")
        text = (self.out / "flight.toml").read_text()
        for what in ("[[key]]", "camera.position", "camera.target"):
            self.assertEqual(text.count(what), 3, what)
        self.assertRegex(text, "space = 'crs'")
        self.settle(program)  # at its end
        self.quit(program)
        words = ["animate", self.out / "flight.toml", survey(), "--quiet", "--last", "1"]
        self.assertDone(Run([binary("RAYTRACER"), *words, "-o", self.out / "frame-%04d.png"]))
        self.assertTrue((self.out / "frame-0000.png").exists(), list(self.out.iterdir()))

    @only_in_all
    def test_no_memory_is_lost_over_hundreds_of_moves(self):
        # A small window makes a move a quick one. Its picture, of some 100,000 pixels, still takes
        # several times the 41 KiB for each move that the check below lets pass.
        size = {"width": MIDDLE[0] + 20, "height": MIDDLE[1] + 20}
        program = self.preview(survey(), "--samples", "1", "--memory-mib", "64", **size)

        def memory_mib():
            status = pathlib.Path(f"/proc/{program.process.pid}/status").read_text()
            return int(re.search(r"VmRSS:\s+(\d+)", status).group(1)) / 1024

        def moves(count):
            goal = self.count(program, FIRST) + count
            while (done := self.count(program, FIRST)) < goal:
                for more, key in enumerate(("Left", "Right")):
                    with self.desktop.held(key):
                        self.wait_for_more(program, FIRST, done + 10 * (more + 1))

        moves(200)  # until all that there is to be kept is there
        before = memory_mib()
        moves(400)
        after = memory_mib()
        print(f"memory before and after 400 moves: {before:.0f}, {after:.0f} MiB", file=sys.stderr)
        self.assertLess(after, before + 16)
        self.quit(program)

    @only_in_all
    def test_tiny_hidden_and_closed_in_the_middle(self):
        program = self.preview(
            survey(), "--integrator", "path", "--samples", "4000", "--size", "4000x4000"
        )
        desktop = self.desktop
        window = ["search", "--name", "Terravox", "windowsize", "--sync"]
        for width, height in ((1, 1), (500, 300), (WIDTH, HEIGHT)):
            before = self.count(program, FIRST)
            desktop.do(*window, width, height)
            self.wait_for_more(program, FIRST, before)
            self.keep(f"window-{width}")
        desktop.do("mousemove", *MIDDLE)
        desktop.key("ctrl+r")
        program.saw("place of Give up: ")
        self.quit(program)  # in the middle: the picture would take hours
        self.assertEqual([p.name for p in self.out.iterdir() if p.name.startswith("picture")], [])

    @only_in_all
    def test_a_broken_scene_is_reported_and_the_window_stays(self):
        program = self.preview(survey(), "--samples", "1", "--voxel", "2")
        broken = self.out / "scene.toml"
        for text, said in (
            ("[camera]\nfov_deg = 900\n", "camera.fov_deg = 900; allowed: 1 to 360"),
            ("[camera\n", "parsing table header"),
        ):
            broken.write_text(text)
            self.desktop.key("ctrl+o")
            program.saw(re.escape(said))
            self.assertIsNone(program.process.poll())
        self.keep("broken")
        broken.write_text("[sun]\ntime_h = 12\n")
        self.desktop.key("ctrl+o")
        program.saw("opened .*scene.toml")
        self.assertEqual(self.time_h(program), 12)
        self.assertRegex(self.saved(program), r"voxel_m = 2")  # the world is the one that is open
        # Of a scene that is no picture the window stays as it is, whatever is done to it.
        self.settle(program)
        pictures = self.count(program, FIRST)
        self.press(program, "sun.date")
        self.desktop.key("ctrl+a")
        self.desktop.do("type", "2026-13-01")
        self.desktop.key("Return")
        program.saw("2026-13-01")
        self.desktop.key("Escape", "F6", "ctrl+z", "ctrl+z", "ctrl+z", "ctrl+z")
        self.wait_for_more(program, FIRST, pictures)
        self.quit(program)

    @only_in_all
    def test_a_server_that_goes_and_comes_back(self):
        port = hold_port()
        server = Server(survey(), port=port)
        self.addCleanup(lambda: server.process.poll() is None and server.kill())
        # A busy server takes seconds for a box, and what it is late with would stay a hole; one
        # that is gone is asked again for as long.
        timeout = ["--processing-box-timeout-s", "20"]
        program = self.preview(server.url, "--samples", "1", *timeout, "--memory-mib", "1")
        server.kill()
        with self.desktop.held("Left"):
            program.saw("hole at box")
        self.saved(program)
        self.keep("server-gone")
        again = Program("--port", str(port), survey(), program="VOXELSERVER", test=self)
        again.saw("listening on")
        # By itself, after a while.
        program.saw("a box that was a hole has come")
        self.settle(program)
        self.keep("server-back")
        self.quit(program)


if __name__ == "__main__":
    unittest.main()

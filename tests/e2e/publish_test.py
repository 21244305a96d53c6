#!/usr/bin/env python3
"""Sites of `terravox publish`: what lies in them, and what a browser shows of them."""

import json
import os
import re
import shutil
import signal
import struct
import unittest
import urllib.error
import urllib.request

from certificate import self_signed
from site_views import (
    NoBrowser,
    Traced,
    compare_hits,
    compare_shadows,
    minutes_of_the_year,
    numbers_of,
    rmse_of_light,
    show,
    show_at,
    three_views,
)
from static_host import StaticHost
from support import (
    HANGS_S,
    Case,
    Program,
    Run,
    binary,
    compare,
    entries,
    only_in_all,
    render,
    run_page_tests,
    survey,
    temporary_folder,
    wait_until,
)

SIZE = (320, 240)
# The whole survey; how it is framed depends on the picture's shape.
VIEW = ["--camera-azimuth-deg", "200", "--camera-down-deg", "30", "--size", "320x240"]


def publish(*arguments, **options):
    return Run([binary("PUBLISH"), *arguments, "--quiet"], **options)


class Publish(Case):
    @classmethod
    def setUpClass(cls):
        cls.site = temporary_folder() / "site"
        publish(survey(), "--ortho", survey() / "ortho", cls.site, *VIEW, "--title", "A & B").done()

    def place(self, site):
        return json.loads((site / "place.json").read_text())

    def test_a_site_has_all_that_the_page_needs(self):
        files = ["appearance.bin", "index.html", "place.json", "place.tvx", "preview.jpg"]
        viewer = [f"viewer/{name}" for name in ("licences.txt", "viewer.css", "viewer.js")]
        files += ["squares.json", "viewer", *viewer, "viewer/worker.js"]
        self.assertEqual(entries(self.site), files)
        index = (self.site / "index.html").read_text()
        self.assertIn("<title>A &amp; B</title>", index)
        for name in re.findall(r'(?:src|href)="(viewer/[^"]+)"', index):
            self.assertTrue((self.site / name).is_file(), name)
        place = self.place(self.site)
        self.assertEqual(place["title"], "A & B")
        self.assertEqual(place["archive"], {"url": "place.tvx"})
        self.assertEqual([view["name"] for view in place["views"]], ["Start", "Whole place"])
        squares = json.loads((self.site / place["squares"]).read_text())["features"]
        self.assertEqual(len(squares), 1)

    def test_an_archive_is_published_as_it_is(self):
        site = temporary_folder() / "site"
        self.assertDone(publish(self.site / "place.tvx", site, *VIEW, "--no-preview"))
        self.assertEqual((site / "place.tvx").read_bytes(), (self.site / "place.tvx").read_bytes())
        self.assertNotIn("preview.jpg", entries(site))
        self.assertNotIn("squares.json", entries(site))
        refused = publish(site / "place.tvx", site, "--split-mib", "1")
        self.assertRefused(refused, 2, "would be removed from the site")
        self.assertTrue((site / "place.tvx").exists())

    @only_in_all
    def test_an_archive_elsewhere_is_referred_to_and_not_copied(self):
        folder = temporary_folder()
        shutil.copy(self.site / "place.tvx", folder / "valley.tvx")
        site = folder / "site"
        self.assertDone(publish(folder / "valley.tvx", site, *VIEW))
        refer = (folder / "valley.tvx", site, *VIEW, "--archive-url")
        self.assertDone(publish(*refer, "https://files.example/valley.tvx?key=1"))
        self.assertEqual(
            self.place(site)["archive"], {"url": "https://files.example/valley.tvx?key=1"}
        )
        # That of the site before is not left lying there.
        self.assertNotIn("place.tvx", entries(site))
        self.assertIn("preview.jpg", entries(site))
        refused = publish(*refer, "http://files.example/a.tvx")
        self.assertRefused(refused, 2, "allowed: https://HOST/PATH")
        added = publish(*refer, "../valley.tvx", "--add", "462010,101010,462020,101020,+60")
        self.assertRefused(added, 2, "--add with --archive-url")
        made = publish(survey(), site, "--archive-url", "https://files.example/valley.tvx")
        self.assertRefused(made, 2, "terravox convert makes archives")
        own = publish(self.site / "place.tvx", self.site, "--archive-url", "../valley.tvx")
        self.assertRefused(own, 2, "would be removed")
        self.assertTrue((self.site / "place.tvx").exists())

    @only_in_all
    def test_a_browser_reads_an_archive_of_another_host(self):
        if not os.environ.get("TERRAVOX_NODE"):
            self.skipTest("no Node.js")
        folder = temporary_folder()
        views = three_views(self.site / "place.tvx")[:1]
        allowed = {
            "Access-Control-Allow-Origin": "*",
            "Access-Control-Expose-Headers": "Content-Range, ETag",
        }
        files = StaticHost(self.site, headers=allowed, certificate=self_signed())
        refer = ("--archive-url", files.url + "place.tvx")
        self.assertDone(
            publish(self.site / "place.tvx", folder / "site", *VIEW, "--no-preview", *refer)
        )
        pages = StaticHost(folder / "site")
        try:
            show_at(pages.url, views, (160, 90), folder, trusts_all=True)
            hits = numbers_of(folder / f"{views[0].name}.hits", "i")
            self.assertGreater(sum(bits >> 13 & 1 for bits in hits[3::4]), 160 * 90 / 10)
            files.headers = {}
            with self.assertRaisesRegex(AssertionError, "Access-Control-Allow-Origin of the host"):
                show_at(pages.url, views, (160, 90), folder, trusts_all=True)
        except NoBrowser as reason:
            self.skipTest(str(reason))
        finally:
            pages.stop()
            files.stop()

    @only_in_all
    def test_a_part_is_published_where_one_is_chosen(self):
        site = temporary_folder() / "site"
        noise = ("generated:7", site, "--no-preview", "--sun-date", "2026-06-21")
        run = publish(*noise, "--area", "-64,0,128,64")
        self.assertDone(run)
        self.assertNotIn("--area chooses", run.err)
        info = Run([binary("RAYTRACER"), "world", "info", site / "place.tvx", "--json"])
        self.assertDone(info)
        bounds = json.loads(info.out)["bounds"]
        self.assertEqual((bounds["min"][0], bounds["max"][0]), (-64, 128))
        self.assertEqual((bounds["min"][2], bounds["max"][2]), (0, 64))
        self.assertRefused(publish(*noise, "--area", "1,2,3"), 2, "--area 1,2,3")
        archive = publish(site / "place.tvx", site.parent / "other", "--area", "0,0,64,64")
        self.assertRefused(archive, 2, "published whole")

    @only_in_all
    def test_a_damaged_archive_is_published_with_a_word_of_its_holes(self):
        folder = temporary_folder()
        data = bytearray((self.site / "place.tvx").read_bytes())
        at = sum(struct.unpack_from("<QQ", data, 16))  # of the facts: records follow
        while struct.unpack_from("<i", data, at)[0] != 0:
            at += 32 + struct.unpack_from("<I", data, at + 16)[0]
        data[at + 72] ^= 255
        (folder / "bad.tvx").write_bytes(data)
        run = publish(folder / "bad.tvx", folder / "site", "--detail", "0")
        self.assertEqual(run.code, 3, str(run))

    def test_a_folder_of_somebody_is_left_alone(self):
        folder = temporary_folder()
        (folder / "index.html").write_text("somebody's page")
        place = self.site / "place.tvx"
        self.assertRefused(publish(place, folder, "--no-preview"), 2, "--overwrite")
        self.assertEqual(entries(folder), ["index.html"])

    def test_wrong_usage_writes_nothing(self):
        folder = temporary_folder()
        place = self.site / "place.tvx"
        for arguments, said in (
            ([place], "1 path"),
            ([place, folder / "site", "--split-mib", "-1"], "--split-mib"),
            ([place, folder / "site", "--camera-projection", "panorama"], "perspective"),
            ([place, folder / "site", "--title", "x" * 5000], "4096"),
            ([place, folder / "site", "--sun-altitude-deg", "3"], "by date"),
            ([folder / "none.tvx", folder / "site"], "none.tvx"),
        ):
            with self.subTest(said):
                self.assertRefused(publish(*arguments), 2, said)
        self.assertEqual([name for name in entries(folder) if name != "site"], [])

    def asked(self, address, path="", **headers):
        request = urllib.request.Request(address + path, headers=headers)
        try:
            with urllib.request.urlopen(request, timeout=HANGS_S) as reply:
                return reply.status, reply.headers, reply.read()
        except urllib.error.HTTPError as refusal:
            return refusal.code, refusal.headers, refusal.read()

    def test_view_serves_a_site_to_this_machine_alone(self):
        site = temporary_folder() / "site"
        shutil.copytree(self.site, site)
        (site.parent / "secret.txt").write_text("secret")
        (site / "out.txt").symlink_to("../secret.txt")
        view = Program(site, "--no-browser", program="VIEW")
        try:
            address = view.saw(r"http://127\.0\.0\.1:\d+/")[0]
            archive = (self.site / "place.tvx").read_bytes()
            status, headers, body = self.asked(address, "place.tvx", Range="bytes=100-199")
            self.assertEqual((status, body), (206, archive[100:200]))
            self.assertEqual(headers["Content-Range"], f"bytes 100-199/{len(archive)}")
            policy = self.asked(address, "viewer/worker.js")[1]["Content-Security-Policy"]
            self.assertIn("connect-src 'self';", policy)
            self.assertEqual(self.asked(address)[2], (self.site / "index.html").read_bytes())
            for status, path, given in (
                (421, "", {"Host": "evil.example"}),
                (403, "place.json", {"Origin": "http://evil.example"}),
                (404, "out.txt", {}),
            ):
                with self.subTest(path=path, given=given):
                    self.assertEqual(self.asked(address, path, **given)[0], status)
        finally:
            view.process.send_signal(signal.SIGTERM)
            code = view.end()
        self.assertEqual(code, 0, view.log())

    @only_in_all
    def test_view_shows_what_is_no_site_yet_and_leaves_nothing(self):
        scratch = temporary_folder()
        environment = {"TMPDIR": str(scratch)}
        words = (self.site / "place.tvx", "--no-browser")
        view = Program(*words, program="VIEW", environment=environment)
        try:
            address = view.saw(r"http://127\.0\.0\.1:\d+/")[0]
            place = json.loads(self.asked(address, "place.json")[2])
            self.assertEqual(place["archive"], {"url": "place.tvx"})
        finally:
            view.process.send_signal(signal.SIGINT)
            code = view.end()
        self.assertEqual(code, 0, view.log())
        self.assertEqual(entries(scratch), [])

    @only_in_all
    def test_a_view_that_is_stopped_while_it_publishes_leaves_nothing(self):
        for stop in (signal.SIGINT, signal.SIGTERM):
            scratch = temporary_folder()
            words = (survey(), "--no-browser", "--processing-threads", "1")
            view = Program(*words, program="VIEW", environment={"TMPDIR": str(scratch)})
            wait_until(lambda folder=scratch: entries(folder), "the folder of the site")
            view.process.send_signal(stop)
            code = view.end()
            with self.subTest(stop):
                self.assertEqual(code, 1, view.log())
                self.assertIn("view: stopped before", view.log())
                self.assertEqual(entries(scratch), [])

    def test_a_browser_shows_what_the_ray_tracer_shows(self):
        folder = temporary_folder()
        shown = folder / "shown.jpg"
        hits = folder / "hits.json"
        run = self.run_in_browser(
            "TERRAVOX_SITE",
            TERRAVOX_SITE_PICTURE=str(shown),
            TERRAVOX_SITE_HITS=str(hits),
            TERRAVOX_SITE_SIZE=f"{SIZE[0]}x{SIZE[1]}",
        )
        if not shown.exists():
            self.skipTest("no browser: " + run.out)
        with self.subTest("the picture"):
            wanted = folder / "wanted.png"
            self.assertDone(render(self.site / "place.tvx", *VIEW, "--look", "plain", "-o", wanted))
            alike = compare(shown, wanted)
            self.assertEqual(alike.code, 0, alike)
        with self.subTest("voxels, faces and shadows"):
            self.compare_hits(json.loads(hits.read_text())["voxels"], folder)

    @only_in_all
    def test_the_tools_of_a_site_work_in_a_browser(self):
        for what in ("TERRAVOX_SITE_TOOLS", "TERRAVOX_SITE_DRAWING"):
            with self.subTest(what):
                run = self.run_in_browser(what)
                if "# SKIP" in run.out:
                    self.skipTest("no browser: " + run.out)

    def run_in_browser(self, what, **environment):
        """Runs tests of the page (tests/page/run.mjs); what: the variable for the address."""
        if not os.environ.get("TERRAVOX_NODE"):
            self.skipTest("no Node.js")
        host = StaticHost(self.site)
        try:
            run = run_page_tests(**{what: host.url}, **environment)
        finally:
            host.stop()
        return run.done()

    def compare_hits(self, hits, folder):
        """First hits of the viewer with those of the ray tracer, pixel by pixel."""
        solid, same, lit = compare_hits(hits, Traced(self.site / "place.tvx", VIEW, folder))
        self.assertGreater(solid, 0.1)
        self.assertGreaterEqual(same, 0.999)
        self.assertGreaterEqual(lit, 0.995)

    @only_in_all
    def test_views_levels_dates_and_light_are_those_of_the_ray_tracer(self):
        if not os.environ.get("TERRAVOX_NODE"):
            self.skipTest("no Node.js")
        size = (320, 180)
        archive = self.site / "place.tvx"
        folder = temporary_folder()
        cameras = three_views(archive)
        dates = [
            camera.at(f"{camera.name}-{minute}", minute)
            for camera, minute in zip(cameras, minutes_of_the_year(3), strict=True)
        ]
        names = [camera.name for camera in cameras]
        try:
            show(self.site, [*cameras, *dates], size, folder, light=names)
        except NoBrowser as reason:
            self.skipTest(str(reason))
        levels = set()
        for camera in cameras:
            with self.subTest(camera.name):
                traced = Traced(archive, camera.flags(size), folder)
                hits = numbers_of(folder / f"{camera.name}.hits", "i")
                levels |= {bits >> 4 & 31 for bits in hits[3::4] if bits >> 13 & 1}
                solid, same, lit = compare_hits(hits, traced)
                self.assertGreater(solid, 0.1)
                self.assertGreaterEqual(same, 0.999)
                self.assertGreaterEqual(lit, 0.995)
                light = numbers_of(folder / f"{camera.name}.light", "f")
                self.assertLessEqual(rmse_of_light(light, traced), 0.03)
        self.assertGreaterEqual(len(levels), 2)
        for view in dates:
            with self.subTest(view.name):
                traced = Traced(archive, view.flags(size), folder)
                hits = numbers_of(folder / f"{view.name}.hits", "i")
                sunny, same = compare_shadows(hits, traced)
                self.assertGreater(sunny, 0.05)
                self.assertLess(sunny, 0.999)
                self.assertGreaterEqual(same, 0.995)


if __name__ == "__main__":
    unittest.main()

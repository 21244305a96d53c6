#!/usr/bin/env python3
"""The interface of the voxel server as its clients see it: what docs/openapi.json promises,
preparing, stores, TLS."""

import contextlib
import json
import re
import resource
import shutil
import sqlite3
import ssl
import unittest
import urllib.error
import urllib.request

from certificate import self_signed
from installed import hidden
from pictures import Picture
from support import (
    HANGS_S,
    ROOT,
    Case,
    Run,
    Server,
    binary,
    render,
    square,
    survey,
    temporary_folder,
    wait_until,
)


def middle(world):
    low = world["bounds"]["min"]
    high = world["bounds"]["max"]
    return (low[0] + high[0]) // 2, (low[2] + high[2]) // 2


class Interface(Case):
    @classmethod
    def setUpClass(cls):
        flags = ["--ortho", survey() / "ortho", "--cache", temporary_folder(), "--jobs", "1"]
        cls.server = Server(survey(), *flags)
        cls.world = cls.server.json("/v2/world")
        x, z = middle(cls.world)
        column = cls.server.json(f"/v2/columns/0/{x // 64}/{z // 64}")
        cls.keys = [[0, x // 64, by, z // 64] for by in range(column["by_begin"], column["by_end"])]

    @classmethod
    def tearDownClass(cls):
        assert cls.server.stop() == 0, cls.server.err

    def job(self):
        """@return the name of a job that is done"""
        x, z = middle(self.world)
        job = {"kind": "terrain", "area": [x, -z, x + 20, 20 - z]}
        status, _, body = self.server.post("/v2/jobs", json.dumps(job))
        self.assertEqual(status, 201, body)
        name = json.loads(body)["id"]
        done = ("done", "failed")
        wait_until(lambda: self.server.json(f"/v2/jobs/{name}")["state"] in done, "a job")
        return name

    def test_the_document_and_the_page_name_the_same_members_of_a_job(self):
        document = json.loads((ROOT / "docs" / "openapi.json").read_text())
        page = (ROOT / "docs" / "formats" / "http.md").read_text(encoding="utf-8")
        jobs = page[page.index("\n## Jobs") : page.index("\n## First system")]
        first = "".join(row.split("|")[1] for row in re.findall(r"^\| `.*", jobs, re.MULTILINE))
        members = document["components"]["schemas"]["JobRequest"]["properties"]
        self.assertEqual(sorted(re.findall("`([a-z_]+)`", first)), sorted(members))
        # What is offered is one table, of which the page is told.
        reply = self.server.json("/v2/jobs")
        offered = reply["kinds"]
        self.assertEqual([one["kind"] for one in reply["analyses"]], offered)
        self.assertEqual(self.server.json("/v2/stats")["jobs"]["analyses"], reply["analyses"])
        kind_row = re.search(r"^\| `kind` \|(.*)", jobs, re.MULTILINE)[1]
        self.assertEqual(members["kind"]["enum"], offered)
        self.assertEqual(re.findall(r"`(\w+)`", kind_row), offered)
        # The server knows no others: it names them when it refuses one.
        known = set()
        for kind in members["kind"]["enum"]:
            x, z = middle(self.world)
            body = {"kind": kind, "area": [x, -z, x + 20, 20 - z], "nothing": 1}
            if kind == "sight":
                body["observers"] = [[x, -z, 2]]
            status, _, said = self.server.post("/v2/jobs", json.dumps(body))
            self.assertEqual(status, 400)
            known |= set(json.loads(said)["detail"].split("allowed: ")[1].split(", "))
        self.assertEqual(set(members), known)

    def test_every_path_of_the_document_is_answered_as_documented(self):
        document = json.loads((ROOT / "docs" / "openapi.json").read_text())
        self.assertEqual(self.server.json("/openapi.json"), document)
        level, bx, by, bz = next(
            key
            for key in self.keys
            if self.server.get("/v2/boxes/" + "/".join(map(str, key)))[0] == 200
        )
        zoom = self.world["map"]["zooms"][1]
        x, z = middle(self.world)
        values = {"level": level, "bx": bx, "by": by, "bz": bz, "name": "app.js"}
        values["file"] = "viewer.js"
        values["id"] = self.job()
        queries = {
            "/gkot/box": f"?format=raw&tmx={x}&tmy={-z}&x=0&y=0&z=0&sx=16&sy=16&sz=16",
            "/gkot/origin.json": f"?tmx={x}&tmy={-z}",
        }
        for path, methods in document["paths"].items():
            if path.startswith("/map"):
                values.update(z=zoom, x=x // 256, y=z // 256)
            address = path.format(**values) + queries.get(path, "")
            for method, facts in methods.items():
                if method != "get":
                    continue
                status, headers, body = self.server.get(address)
                with self.subTest(address):
                    wanted = next(iter(facts["responses"]))
                    if path == "/v2/archive.tvx":  # the world of this server is no archive
                        wanted = "404"
                    self.assertEqual(str(status), wanted, body[:300])
                    kind = headers["Content-Type"].split(";")[0]
                    self.assertIn(kind, facts["responses"][wanted].get("content", {kind: {}}))
        # Nothing is served that the document lacks.
        requested = set(self.server.json("/v2/stats")["requests"]) - {"unknown", "refused"}
        self.assertLessEqual(requested, set(document["paths"]))

    def test_bytes_of_a_batch_are_counted(self):
        def counted():
            return self.server.json("/v2/stats")["replies"]["bytes"]

        before = counted()
        kind = {"Content-Type": "application/json"}
        status, _, data = self.server.post("/v2/boxes", json.dumps({"boxes": self.keys}), kind)
        self.assertEqual(status, 200)
        wait_until(lambda: counted() > before + len(data), "the reply is counted")


class Kept(Case):
    def test_preparing_makes_everything_and_reports_the_outcome(self):
        cache = temporary_folder()
        run = Run([binary("VOXELSERVER"), survey(), "--cache", cache, "--prepare-only"])
        self.assertDone(run)
        self.assertIn("prepared:", run.err)
        with Server(survey(), "--cache", cache, "--prepare") as server:
            world = server.json("/v2/world")
            x, z = middle(world)
            column = server.json(f"/v2/columns/0/{x // 64}/{z // 64}")
            for by in range(column["by_begin"], column["by_end"]):
                self.assertIn(server.get(f"/v2/boxes/0/{x // 64}/{by}/{z // 64}")[0], (200, 204))
            stats = server.json("/v2/stats")
            self.assertEqual(stats["making"]["made"], 0)
            self.assertGreater(stats["prepare"]["total"], 10)
        self.assertRefused(
            Run([binary("VOXELSERVER"), survey(), "--cache", "none", "--prepare-only"]),
            2,
            "--cache",
        )

    def test_preparing_fails_where_the_disk_is_full(self):
        words = [binary("VOXELSERVER"), survey(), "--cache", temporary_folder(), "--prepare-only"]
        run = Run(words, limits=[(resource.RLIMIT_FSIZE, 100_000)])
        self.assertEqual(run.code, 1, str(run))
        self.assertIn("cannot be kept in", run.err.splitlines()[-1])

    def test_damaged_facts_of_a_world_are_made_again(self):
        cache = temporary_folder()
        for damage in (None, b"", b"nonsense", None):
            with Server(square(), "--cache", cache) as server:
                self.assertEqual(server.json("/v2/world")["crs"], "EPSG:3794")
            facts = list((cache / "worlds").glob("*.facts"))
            self.assertEqual(len(facts), 1)
            if damage is not None:
                facts[0].write_bytes(damage)

    def test_a_damaged_square_is_reported_and_counted(self):
        place = temporary_folder()
        data = bytearray(square().read_bytes())
        data[len(data) // 2 : len(data) // 2 + 2000] = bytes(2000)
        (place / "damaged.laz").write_bytes(data)
        run = Run([binary("VOXELSERVER"), place, "--cache", temporary_folder(), "--prepare-only"])
        self.assertEqual(run.code, 3, str(run))
        self.assertIn("cannot be made", run.err)
        with Server(place, "--cache", temporary_folder()) as server:
            x, z = middle(server.json("/v2/world"))
            column = server.json(f"/v2/columns/0/{x // 64}/{z // 64}")
            path = f"/v2/boxes/0/{x // 64}/{column['by_begin']}/{z // 64}"
            status, headers, body = server.get(path)
            self.assertEqual((status, headers["Content-Type"]), (500, "application/problem+json"))
            self.assertNotIn(str(place).encode(), body)
            states = [f["properties"] for f in server.json("/v2/squares")["features"]]
            self.assertEqual([s["state"] for s in states], ["failed"])
            self.assertIn("damaged.laz", states[0]["error"])
            self.assertNotIn(str(place), states[0]["error"])


NOW = "2026-01-01T00:00:00.000Z"


def fishnet(store):
    """The list of a store, made with the grabber's own migrations."""
    database = sqlite3.connect(store / "fishnet.gpkg")
    for version, file in enumerate(sorted((ROOT / "grabber" / "migrations").glob("*.sql")), 1):
        database.executescript(file.read_text())
        database.execute("INSERT INTO terravox_schema VALUES (?, ?, ?)", (version, file.stem, NOW))
    return database


def add_square(database, name, state, **columns):
    row = {
        "source": "si-lss",
        "grid": "si-lss",
        "name": name,
        "state": state,
        "urls": "[]",
        "crs": "EPSG:3794",
        "licence": "CC BY 4.0",
        "attribution": "Somebody <b>",
        "known_at": NOW,
        **columns,
    }
    database.execute(
        f"INSERT INTO squares ({', '.join(row)}) VALUES ({', '.join('?' * len(row))})",
        tuple(row.values()),
    )


class Stores(Case):
    def store_of_four_states(self):
        """@return the folder of a store with a square of each state"""
        store = temporary_folder()
        folder = store / "lidar" / "si-lss"
        folder.mkdir(parents=True)
        name = square().name
        shutil.copy(square(), folder / name)

        with contextlib.closing(fishnet(store)) as database, database:
            held = {"file_path": f"lidar/si-lss/{name}", "file_sha256": "0" * 64}
            held |= {"file_bytes": (folder / name).stat().st_size, "point_count": 5}
            held |= {"las_version": "1.4", "point_format": 6, "verified_at": NOW}
            held |= {f"{end}_{axis}": end == "max" for end in ("min", "max") for axis in "xyz"}
            add_square(database, "462_101", "verified", **held)
            failure = {"error_code": "HTTP", "error_message": "status 500", "error_at": NOW}
            add_square(database, "463_101", "failed", **failure)
            for east, state in ((464, "wanted"), (465, "known")):
                bounds = {"west": 1000 * east, "south": 101000, "north": 102000}
                bounds["east"] = 1000 * (east + 1)
                add_square(database, f"{east}_101", state, **bounds)
        return store

    def test_a_store_is_served_with_its_licence_and_what_it_lacks(self):
        with Server("--store", self.store_of_four_states(), "--cache", "none") as server:
            world = server.json("/v2/world")
            self.assertEqual(
                (world["licence"], world["attribution"]), ("CC BY 4.0", "Somebody <b>")
            )
            states = {
                f["properties"]["name"]: f["properties"]
                for f in server.json("/v2/squares")["features"]
            }
            self.assertEqual(states["463_101"]["state"], "failed")
            self.assertEqual(states["464_101"]["state"], "wanted")
            self.assertNotIn("465_101", states)  # it was not requested
            self.assertIn("500", states["463_101"]["error"])
            self.assertEqual(states[square().stem]["licence"], "CC BY 4.0")

    def test_what_is_made_of_a_store_names_its_licence_and_attribution(self):
        store = self.store_of_four_states()
        info = Run([binary("RAYTRACER"), "world", "info", store])
        self.assertDone(info)
        self.assertRegex(info.out, r"(?m)^licence +CC BY 4\.0$")
        self.assertRegex(info.out, r"(?m)^attribution +Somebody <b>$")
        words = ("--size", "64x36", "--samples", "1", "--cache", "none", "--quiet")
        pictures = {}
        for credit in ("no", "yes"):
            file = store / f"{credit}.png"
            self.assertDone(render(store, *words, "--credit", credit, "-o", file))
            pictures[credit] = Picture(file)
            self.assertEqual(pictures[credit].metadata["Copyright"], "Somebody <b>, CC BY 4.0")
        self.assertNotEqual(pictures["no"].bytes, pictures["yes"].bytes)

    def test_a_credit_that_cannot_be_written_is_refused_before_the_picture(self):
        store = self.store_of_four_states()
        fonts = "/usr/share/fonts/truetype/dejavu"
        if not (without_fonts := hidden(fonts)):
            self.skipTest("no namespace of its own is allowed here")
        for ending, code, said in ((".png", 1, "fonts-dejavu-core"), (".exr", 0, "")):
            with self.subTest(ending):
                out = store / f"a{ending}"
                words = ("--size", "64x36", "--samples", "1", "--cache", "none", "--quiet")
                run = Run(
                    [*without_fonts, binary("RAYTRACER"), "render", store]
                    + [*words, "--credit", "yes", "-o", out]
                )
                self.assertEqual((run.code, out.exists()), (code, code == 0), run)
                self.assertIn(said, run.err)

    def test_a_store_without_squares_is_refused(self):
        store = self.store_of_four_states()
        self.assertRefused(
            Run([binary("VOXELSERVER"), "--store", temporary_folder()]), 1, "fishnet.gpkg"
        )
        self.assertRefused(Run([binary("VOXELSERVER")]), 2, "--store")
        self.assertRefused(
            Run([binary("VOXELSERVER"), square(), "--store", store]), 2, "one of them"
        )


class Tls(Case):
    def test_https_works_with_a_certificate_and_only_with_one(self):
        folder = self_signed()
        with Server(square(), "--cache", "none", "--tls-cert", folder / "both.pem") as server:
            self.assertTrue(server.url.startswith("https://"))
            context = ssl.create_default_context(cafile=folder / "certificate.pem")
            for _ in range(3):
                with urllib.request.urlopen(
                    server.url + "/v2/world", context=context, timeout=HANGS_S
                ) as reply:
                    self.assertEqual(json.load(reply)["version"], 2)
            old = ssl.create_default_context(cafile=folder / "certificate.pem")
            old.minimum_version = ssl.TLSVersion.MINIMUM_SUPPORTED
            old.maximum_version = ssl.TLSVersion.TLSv1_1
            with self.assertRaises(urllib.error.URLError):
                urllib.request.urlopen(server.url + "/healthz", context=old, timeout=HANGS_S)
            with self.assertRaises(OSError):
                urllib.request.urlopen(
                    server.url.replace("https", "http") + "/healthz", timeout=HANGS_S
                )
            with urllib.request.urlopen(
                server.url + "/healthz", context=context, timeout=HANGS_S
            ) as reply:
                self.assertEqual(reply.read(), b"ok\n")

    def test_a_file_without_a_certificate_is_refused(self):
        folder = self_signed()
        self.assertRefused(
            Run([binary("VOXELSERVER"), square(), "--tls-cert", folder / "none.pem"]), 2, "none.pem"
        )
        words = [square(), "--cache", "none", "--port", "0", "--tls-cert", folder / "key.pem"]
        self.assertRefused(Run([binary("VOXELSERVER"), *words]), 1, "key.pem")


class Flags(Case):
    def test_times_that_are_none_are_refused(self):
        for flag in ("--drain-s=nan", "--header-timeout-s=-1", "--keep-alive-s=1e9", "--drain-s=x"):
            run = Run([binary("VOXELSERVER"), square(), flag])
            self.assertRefused(run, 2, flag.partition("=")[0])


class Logs(Case):
    def test_log_lines_are_json_where_that_is_wanted(self):
        server = Server(square(), "--log-json", "--cache", "none")
        server.stop()
        lines = [json.loads(line) for line in server.err.splitlines()]
        self.assertTrue(any("stopping" in line["message"] for line in lines), server.err)
        for line in lines:
            self.assertEqual(list(line), ["time", "level", "message"])


if __name__ == "__main__":
    unittest.main()

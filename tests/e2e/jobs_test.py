#!/usr/bin/env python3
"""Analyses as jobs of the voxel server: what a client gets, and what a stranger does not."""

import contextlib
import http.client
import json
import os
import pathlib
import re
import shutil
import subprocess
import time
import unittest

from analysing import analyse, area, area_flag
from certificate import self_signed
from support import (
    HANGS_S,
    Case,
    Run,
    Server,
    binary,
    entries,
    secret_file,
    square,
    temporary_folder,
)
from support import wait_until as wait_for

TOKEN = "correct-horse-battery-staple-1871"


class Jobs:
    """A server that makes analyses."""

    def __init__(self, *arguments, token=""):
        self.folder = temporary_folder()
        before = os.environ.get("TMPDIR")
        os.environ["TMPDIR"] = str(self.folder)
        try:
            self.server = Server(square(), "--cache", "none", "--jobs", "1", *arguments)
        finally:
            os.environ.pop("TMPDIR")
            if before is not None:
                os.environ["TMPDIR"] = before
        self.headers = {"Authorization": "Bearer " + token} if token else {}

    def ask(self, method, path, body=None, headers=()):
        """@return status, headers, body"""
        connection = http.client.HTTPConnection("127.0.0.1", self.server.port, timeout=HANGS_S)
        with contextlib.closing(connection):
            given = {**self.headers, **dict(headers)}
            connection.request(method, path, body=body, headers=given)
            reply = connection.getresponse()
            return reply.status, reply.headers, reply.read()

    def submit(self, **job):
        status, headers, body = self.ask("POST", "/v2/jobs", json.dumps(job))
        if status != 201:
            raise AssertionError(f"{status} {body}")
        made = json.loads(body)
        assert headers["Location"] == "jobs/" + made["id"]
        return "/v2/jobs/" + made["id"]

    def state(self, path):
        status, _, body = self.ask("GET", path)
        return json.loads(body) if status == 200 else {"state": status}

    def end_of(self, path):
        wait_for(lambda: self.state(path)["state"] not in ("waiting", "running"), "the job's end")
        return self.state(path)

    def running(self):
        """@return the numbers of the processes that work for this server"""
        out = []
        for folder in pathlib.Path("/proc").glob("[0-9]*"):
            with contextlib.suppress(OSError, IndexError):
                words = (folder / "cmdline").read_bytes().split(b"\0")
                parent = (folder / "stat").read_text().rsplit(")", 1)[1].split()[1]
                if b"analyse" in words and int(parent) == self.server.process.pid:
                    out.append(int(folder.name))
        return out


def box():
    west, south, east, north = area()
    return [west, south, east, north]


# Takes minutes: all directions of a year, one after the other.
ENDLESS = {
    "kind": "sun",
    "area": box(),
    "from": "2020-01-01",
    "to": "2026-12-31",
    "step_min": 1,
}


def is_there(pid):
    """@return whether a process exists, and is not only waited for"""
    try:
        return "\nState:\tZ" not in pathlib.Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return False


class Clients(Case):
    @classmethod
    def setUpClass(cls):
        cls.jobs = Jobs()

    @classmethod
    def tearDownClass(cls):
        folder = cls.jobs.folder
        assert cls.jobs.server.stop() == 0, cls.jobs.server.err
        assert entries(folder) == [], entries(folder)

    @unittest.skipUnless(shutil.which("gdalinfo"), "needs GDAL's programs")
    def test_a_job_has_the_values_of_the_command(self):
        def checksums(file):
            command = ["gdalinfo", "-checksum", file]
            run = subprocess.run(command, capture_output=True, text=True, check=True)
            return re.findall(r"Checksum=\d+|Description = .*|Origin = .*|Size is .*", run.stdout)

        for kind, job, flags in (
            (
                "sun",
                {"date": "2026-06-21", "zone": "Europe/Ljubljana", "resolution_m": 2},
                ["--date", "2026-06-21", "--zone", "Europe/Ljubljana", "--resolution", "2"],
            ),
            (
                "sight",
                {"observers": [[box()[0] + 50, box()[1] + 50, 20]]},
                ["--observer", f"{box()[0] + 50},{box()[1] + 50},+20"],
            ),
        ):
            with self.subTest(kind):
                path = self.jobs.submit(kind=kind, area=box(), **job)
                end = self.jobs.end_of(path)
                self.assertEqual((end["state"], end.get("holes")), ("done", False), end)
                status, headers, body = self.jobs.ask("GET", path + "/result.tif")
                self.assertEqual((status, len(body)), (200, end["bytes"]))
                self.assertEqual(headers["Content-Type"], "image/tiff")
                folder = temporary_folder()
                (folder / "job.tif").write_bytes(body)
                own = analyse(kind, square(), *area_flag(), *flags, "-o", folder / "own.tif")
                self.assertEqual(own.code, 0, own)
                self.assertEqual(checksums(folder / "job.tif"), checksums(folder / "own.tif"))
                self.assertEqual(self.jobs.ask("DELETE", path)[0], 204)
                self.assertEqual(self.jobs.ask("GET", path + "/result.tif")[0], 404)

    def test_deleting_ends_the_process_and_removes_its_files(self):
        first = self.jobs.submit(**ENDLESS)
        wait_for(lambda: self.jobs.running(), "a process")
        second = self.jobs.submit(**ENDLESS)
        self.assertEqual(self.jobs.state(second)["state"], "waiting")
        (child,) = self.jobs.running()
        self.assertEqual(self.jobs.ask("DELETE", second)[0], 204)
        self.assertEqual(self.jobs.ask("DELETE", first)[0], 204)
        self.assertEqual(self.jobs.state(first)["state"], 404)
        wait_for(lambda: not is_there(child), "the end of the process")
        (root,) = self.jobs.folder.iterdir()
        wait_for(lambda: first.rsplit("/", 1)[1] not in entries(root), "the folder to go")


class Ends(Case):
    def started(self):
        jobs = Jobs()
        jobs.submit(**ENDLESS)
        wait_for(lambda: jobs.running(), "a process")
        (child,) = jobs.running()
        return jobs, child

    def test_children_end_with_the_server(self):
        jobs, child = self.started()
        self.assertEqual(jobs.server.stop(), 0)
        self.assertFalse(is_there(child))
        self.assertEqual(entries(jobs.folder), [])

    def test_children_end_with_a_server_that_is_killed(self):
        jobs, child = self.started()
        jobs.server.kill()
        wait_for(lambda: not is_there(child), "the end of the process")


class Strangers(Case):
    def test_the_token_is_needed_and_is_passed_on(self):
        jobs = Jobs("--token-file", secret_file(TOKEN), token=TOKEN)
        path = jobs.submit(kind="terrain", area=box())
        self.assertEqual(jobs.end_of(path)["state"], "done")
        self.assertEqual(jobs.ask("GET", path, headers={"Authorization": "Bearer x"})[0], 401)
        self.assertEqual(jobs.ask("GET", path)[0], 200)
        self.assertEqual(jobs.server.stop(), 0)

    def test_tls_does_not_concern_jobs(self):
        folder = self_signed()
        # Without a token the job's own server is asked by http.
        server = Server(
            square(), "--cache", "none", "--jobs", "1", "--tls-cert", folder / "both.pem"
        )
        curl = shutil.which("curl")
        if curl is None:
            self.skipTest("needs curl")
        command = [curl, "-s", "--cacert", folder / "certificate.pem"]
        job = json.dumps({"kind": "terrain", "area": box()})
        made = json.loads(Run([*command, "-d", job, server.url + "/v2/jobs"]).out)
        address = f"{server.url}/v2/jobs/{made['id']}"
        state = {}
        end = time.monotonic() + HANGS_S
        while state.get("state") not in ("done", "failed") and time.monotonic() < end:
            state = json.loads(Run([*command, address]).out)
        self.assertEqual(state["state"], "done", state)
        self.assertEqual(server.stop(), 0)

    def test_without_the_ray_tracer_the_server_does_not_start(self):
        folder = temporary_folder()
        program = pathlib.Path(binary("VOXELSERVER"))
        for name in (program.name, "terravox-worlds.so"):
            shutil.copy(program.parent / name, folder)
        config = pathlib.Path(__file__).resolve().parents[2] / "config"
        run = Run(
            [folder / program.name, "generated:1", "--jobs", "1", "--port", "0"],
            environment={"TERRAVOX_CONFIG": str(config)},
        )
        self.assertRefused(run, 1, "terravox-raytracer")


if __name__ == "__main__":
    unittest.main()

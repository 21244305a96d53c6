"""A farm of real programs: listening and joining workers, killed, stopped or refused.

The picture is the same in any case.
"""

import http.client
import json
import os
import pathlib
import re
import signal
import unittest

from support import (
    FARM_TOKEN,
    HANGS_S,
    Program,
    Run,
    Server,
    binary,
    only_in_all,
    render,
    secret_file,
    survey,
    temporary_folder,
    wait_until,
)

ENVIRONMENT = {"TERRAVOX_FARM_TOKEN": FARM_TOKEN, "TERRAVOX_FARM_TEST": "1"}
PICTURE = ["--size", "256x144", "--tile", "16", "--integrator", "path", "--bounces", "4"]
# Some seconds on one thread: long enough to be killed, queried and joined meanwhile.
SCENE = [*PICTURE, "--look", "plain", "--samples", "20"]
# As many tiles, for tests in which nothing happens while it is rendered.
SHORT = [*PICTURE, "--samples", "4"]
os.environ["TERRAVOX_FARM_TEST"] = "1"


def unread_bytes(port):
    """@return bytes that connections to a local port have received and the program has not read

    Ref: proc_net_tcp.rst of Linux.
    """
    lines = [line.split() for line in pathlib.Path("/proc/net/tcp").read_text().splitlines()[1:]]
    return sum(
        int(queues.split(":")[1], 16)
        for _, local, _, _, queues, *_ in lines
        if int(local.split(":")[1], 16) == port
    )


class Farm(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.out = temporary_folder()
        cls.wanted = {}
        for name, scene in (("long.png", SCENE), ("short.png", SHORT)):
            render(survey(), *scene, "--quiet", "-o", cls.out / name).done()
            cls.wanted[name] = (cls.out / name).read_bytes()

    def program(self, *arguments, **options):
        return Program(*arguments, test=self, **{"environment": ENVIRONMENT, **options})

    def worker(self, *arguments, **options):
        """A daemon that listens. Returns it and its address."""
        daemon = self.program(
            "worker", "--listen", "127.0.0.1:0", "--threads", "1", *arguments, **options
        )
        return daemon, daemon.address()

    def coordinator(self, name, *arguments, scene=SCENE, **options):
        return self.program(
            "render", survey(), *scene, "-o", self.out / name, *arguments, **options
        )

    def check(self, program, name, wanted="long.png"):
        self.assertEqual(program.end(), 0, program.log())
        self.assertTrue(
            (self.out / name).read_bytes() == self.wanted[wanted],
            f"{name} is another picture\n{program.log()}",
        )
        self.assertFalse((self.out / (name + ".tiles")).exists())

    def test_workers_that_listen(self):
        _, a = self.worker()
        _, b = self.worker()
        farm = ["--worker", a, "--worker", b, "--threads", "1"]
        report = ["--report", self.out / "report.json"]
        self.check(self.coordinator("mixed.png", *farm, *report), "mixed.png")
        hands = json.loads((self.out / "report.json").read_text())["farm"]["processors"]
        self.assertEqual(sorted(h["kind"] for h in hands), ["socket", "socket", "threads"])

    def status(self, address):
        """@return what a coordinator or worker reports of itself"""
        done = Run(
            [binary("RAYTRACER"), "farm", "status", address, "--json"], environment=ENVIRONMENT
        )
        self.assertEqual(done.code, 0, done)
        return json.loads(done.out)[0]

    def test_workers_that_join(self):
        bare = {"TERRAVOX_FARM_TEST": "1", "TERRAVOX_FARM_TOKEN": ""}
        given = ["--token-file", secret_file(FARM_TOKEN)]
        listening = ["--listen", "127.0.0.1:0", "--threads", "0", *given]
        coordinator = self.coordinator("join.png", *listening, environment=bare)
        address = coordinator.address()
        # Before any worker has joined: the picture cannot end meanwhile.
        shown = self.status(address)
        self.assertEqual((shown["role"], shown["members"]), ("coordinator", []))
        workers = [
            self.program(
                *("worker", "--join", address, "--threads", "1", "--once", *given),
                environment=bare,
            )
            for _ in range(2)
        ]
        self.check(coordinator, "join.png")
        for worker in workers:
            self.assertEqual(worker.end(), 0, worker.log())

    @only_in_all
    def test_a_generated_token_is_shown(self):
        none = {"TERRAVOX_FARM_TOKEN": "", "TERRAVOX_FARM_TEST": "1"}
        listening = ["--listen", "127.0.0.1:0", "--threads", "0"]
        coordinator = self.coordinator("shown.png", *listening, scene=SHORT, environment=none)
        token = coordinator.saw(r"token: (\S+)").group(1)
        address = coordinator.address()
        self.program(
            "worker", "--join", address, environment={**none, "TERRAVOX_FARM_TOKEN": token}
        )
        self.check(coordinator, "shown.png", wanted="short.png")

    def test_workers_killed_and_stopped_in_the_middle(self):
        for sign in (signal.SIGKILL, signal.SIGTERM, signal.SIGSTOP):
            with self.subTest(sign.name):
                victim, a = self.worker()
                _, b = self.worker()
                name = f"{sign.name}.png"
                farm = ["--worker", a, "--worker", b, "--threads", "0", "--log", "debug"]
                coordinator = self.coordinator(name, *farm)
                coordinator.saw("answer: tile", times=4)
                victim.process.send_signal(sign)
                if sign == signal.SIGTERM:
                    self.assertEqual(victim.end(), 0, victim.log())
                self.check(coordinator, name)
                victim.process.send_signal(signal.SIGCONT)

    @only_in_all
    def test_all_workers_lost(self):
        worker, a = self.worker()
        coordinator = self.coordinator(
            "lost.png", "--worker", a, "--threads", "0", "--give-up", "1s", "--log", "debug"
        )
        # From its own log: querying the worker would take the start of a program, and the picture
        # may be finished by then.
        coordinator.saw("answer: tile", times=4)
        worker.kill()
        self.assertEqual(coordinator.end(), 3, coordinator.log())
        self.assertRegex(coordinator.log(), r"lacks \d+ tiles")
        self.assertTrue((self.out / "lost.png").exists())
        self.assertTrue((self.out / "lost.png.tiles").exists())
        # Without --resume the checkpoint is not discarded by accident.
        refused = self.coordinator("lost.png", "--worker", a, "--threads", "1")
        self.assertEqual(refused.end(), 2, refused.log())
        report = self.out / "resumed.json"
        self.check(self.coordinator("lost.png", "--resume", "--report", report), "lost.png")
        done = json.loads(report.read_text())
        self.assertGreater(done["tiles_resumed"], 0)
        self.assertEqual(done["tiles"] + done["tiles_resumed"], 144)

    def certificate_flags(self, folder, name):
        """@return flags for a program with that certificate of the folder"""
        files = {"ca": "ca.pem", "cert": f"{name}.pem", "key": f"{name}.key"}
        return [word for flag, file in files.items() for word in (f"--tls-{flag}", folder / file)]

    def test_certificates(self):
        folder = self.out / "certs"
        for where in (folder, self.out / "others"):
            made = Run([binary("RAYTRACER"), "farm", "certs", "-o", where])
            self.assertEqual(made.code, 0, made)

        def ask(what, where, name):
            words = ["farm", what, a, *self.certificate_flags(where, name)]
            return Run([binary("RAYTRACER"), *words], environment=bare)

        bare = {"TERRAVOX_FARM_TOKEN": "", "TERRAVOX_FARM_TEST": "1"}
        _, a = self.worker(*self.certificate_flags(folder, "worker"), environment=bare)
        farm = ["--worker", a, "--threads", "0", *self.certificate_flags(folder, "coordinator")]
        coordinator = self.coordinator("tls.png", *farm, scene=SHORT, environment=bare)
        self.check(coordinator, "tls.png", wanted="short.png")
        self.assertEqual(ask("status", self.out / "others", "coordinator").code, 1)
        # A worker's certificate gives no control, and a revoked one gives no access.
        refused = ask("pause", folder, "worker")
        self.assertEqual(refused.code, 1, refused)
        self.assertIn("an observer with the certificate of a worker", refused.err)
        self.assertEqual(ask("status", folder, "coordinator").code, 0)
        words = ["farm", "certs", "-o", folder, "--revoke", "coordinator"]
        revoked = Run([binary("RAYTRACER"), *words])
        self.assertEqual(revoked.code, 0, revoked)
        late = ask("status", folder, "coordinator")
        self.assertEqual(late.code, 1, late)
        self.assertIn("its certificate is revoked", late.err)

    @only_in_all
    def test_metrics_and_configuration(self):
        config = self.out / "worker.toml"
        text = 'version = 1\nlisten = "127.0.0.1:0"\nthreads = 1\nmetrics = "127.0.0.1:0"\n'
        config.write_text(text)
        daemon = self.program("worker", "--config", config)
        port = int(daemon.saw(r"page of metrics at port (\d+)").group(1))
        a = daemon.address()
        self.check(
            self.coordinator("metrics.png", "--worker", a, "--threads", "0", scene=SHORT),
            "metrics.png",
            wanted="short.png",
        )
        connection = http.client.HTTPConnection("127.0.0.1", port, timeout=HANGS_S)
        connection.request("GET", "/metrics")
        page = connection.getresponse().read().decode()
        self.assertGreaterEqual(
            float(re.search(r"^terravox_worker_tiles_total (\S+)", page, re.M).group(1)), 144, page
        )
        config.write_text(text.replace("threads = 1", "threads = 2"))
        daemon.process.send_signal(signal.SIGHUP)
        daemon.saw("changed: threads")
        config.write_text("nonsense")
        daemon.process.send_signal(signal.SIGHUP)
        daemon.saw("the configuration stays as it was")
        daemon.process.send_signal(signal.SIGTERM)
        self.assertEqual(daemon.end(), 0, daemon.log())

    @only_in_all
    def test_a_worker_that_opens_a_silent_server_ends_at_a_signal(self):
        server = Server(survey())
        self.addCleanup(server.stop)
        listening = ["--listen", "127.0.0.1:0", "--threads", "0"]
        words = ["render", server.url, *SHORT, "-o", self.out / "stalled.png", *listening]
        coordinator = self.program(*words)
        address = coordinator.address()
        server.process.send_signal(signal.SIGSTOP)
        self.addCleanup(server.process.send_signal, signal.SIGCONT)
        worker = self.program("worker", "--join", address, "--threads", "1")
        worker.saw("works for")
        wait_until(lambda: unread_bytes(server.port) > 0, "the stopped server has a request")
        worker.process.send_signal(signal.SIGTERM)
        self.assertEqual(worker.end(), 0, worker.log())
        self.assertNotIn("hole", worker.log())

    @only_in_all
    def test_paused_and_resumed(self):
        def state(address):
            members = self.status(address)["members"]
            return members[0]["state"] if members else "not there yet"

        def control(what, address, *more):
            return Run([binary("RAYTRACER"), "farm", what, address, *more], environment=ENVIRONMENT)

        # Paused before there is a picture, which then stands still until the last of these.
        _, a = self.worker()
        self.assertEqual(control("pause", a).code, 0)
        arguments = ["--worker", a, "--threads", "0", "--listen", "127.0.0.1:0"]
        coordinator = self.coordinator("paused.png", *arguments, scene=SHORT)
        b = coordinator.address()
        wait_until(lambda: state(b) == "paused", "the coordinator sees the pause")
        unknown = control("pause", b, "--worker", "nobody")
        self.assertEqual((unknown.code, "no such worker" in unknown.err), (1, True), unknown)
        self.assertEqual(control("pause", b).code, 0)
        self.assertEqual(control("resume", a).code, 0)
        self.assertEqual(state(b), "paused", "the coordinator has not let it go on")
        self.assertEqual(control("resume", b).code, 0)
        self.check(coordinator, "paused.png", wanted="short.png")

    def test_a_token_can_be_made(self):
        token = Run([binary("RAYTRACER"), "farm", "token"], environment={"TERRAVOX_FARM_TOKEN": ""})
        self.assertEqual(token.code, 0, token)
        self.assertRegex(token.out, r"^[a-z1-9]{32}\n$")
        made = {**ENVIRONMENT, "TERRAVOX_FARM_TOKEN": token.out.strip()}
        asked = Run([binary("RAYTRACER"), "farm", "status", "127.0.0.1:1"], environment=made)
        self.assertEqual(asked.code, 1, asked)

    def test_impossible_options_are_reported(self):
        for arguments, code, says in (
            (["--threads", "0"], 2, "there is no worker"),
            (["--worker", "nowhere:0"], 2, "port"),
            (["--worker", "127.0.0.1:1", "--give-up", "soon"], 2, "--give-up"),
            (["--listen", "300.1.2.3:1"], 1, "300.1.2.3"),
            (["--part", "3/2"], 2, "--part"),
            (["--resume", "--time", "5"], 2, "time_s"),
            (["--worker", "127.0.0.1:1", "--tls-ca", "x"], 2, "--tls-cert"),
            (["--discover"], 2, "--worker HOST"),
        ):
            with self.subTest(arguments):
                words = [*SCENE, *arguments, "-o", self.out / "never.png"]
                run = render(survey(), *words, environment=ENVIRONMENT)
                self.assertEqual(run.code, code, run)
                self.assertIn(says, run.err)
                self.assertEqual(run.err.count("terravox: "), 1, run)


if __name__ == "__main__":
    unittest.main()

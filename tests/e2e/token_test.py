"""Where tokens are sent: a web server records requests and their headers."""

import unittest

from static_host import StaticHost
from support import (
    Program,
    Run,
    Server,
    binary,
    make,
    render,
    secret_file,
    survey,
    temporary_folder,
)

FARM = "w8nq3vz6tk2mx9rj5hcpb4fg7dy1ks2e"
SERVER = "the-secret-of-the-server-61c0f7d3"
# Variables of the user of this machine must not reach the tests.
NOTHING = {
    "TERRAVOX_FARM_TEST": "1",
    **dict.fromkeys(
        (
            "TERRAVOX_FARM_TOKEN",
            "TERRAVOX_SERVER_TOKEN",
            "TERRAVOX_SERVER_ORIGIN",
            "TERRAVOX_TOKEN",
            "http_proxy",
            "all_proxy",
        ),
        "",
    ),
}
SCENE = ["--size", "32x18", "--samples", "1", "--quiet"]


class Tokens(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.out = temporary_folder()
        place = cls.out / "place.tvx"
        make("RAYTRACER", "convert", survey(), place)
        cls.content = place.read_bytes()

    def host(self):
        host = StaticHost({"place.tvx": self.content}, is_bare=True)
        self.addCleanup(host.stop)
        return host

    def render(self, world, environment, *arguments):
        return render(
            world,
            *SCENE,
            *arguments,
            "-o",
            self.out / "picture.png",
            environment={**NOTHING, **environment},
        )

    def worker(self, environment, *arguments):
        """A daemon that listens. Returns its address."""
        words = ["worker", "--listen", "127.0.0.1:0", "--threads", "1", *arguments]
        return Program(*words, environment={**NOTHING, **environment}, test=self).address()

    def test_the_farm_s_token_goes_to_no_web_server(self):
        web = self.host()
        environment = {"TERRAVOX_FARM_TOKEN": FARM, "TERRAVOX_SERVER_TOKEN": SERVER}
        farm = ["--worker", self.worker(environment), "--threads", "0"]
        run = self.render(web.url + "place.tvx", environment, *farm)
        self.assertEqual(run.code, 0, run)
        self.assertEqual(web.authorizations, {None})

    def test_a_coordinator_passes_the_boxes_of_a_server_on_its_own_machine_itself(self):
        web = self.host()
        place = f"{web.server.server_port}/place.tvx"
        environment = {"TERRAVOX_FARM_TOKEN": FARM}
        # The worker would send requests there if it received the address: each of these is allowed.
        allowed = [f"http://{host}:{web.server.server_port}" for host in ("127.0.0.1", "localhost")]
        flags = [word for origin in allowed for word in ("--allow-private-origins", origin)]
        farm = ["--worker", self.worker(environment, *flags), "--threads", "0"]
        for host in ("127.0.0.1", "0x7f.1", "LOCALHOST"):
            with self.subTest(host):
                web.log.clear()
                run = self.render(f"http://{host}:{place}", environment, *farm)
                self.assertEqual(run.code, 0, run)
                begun = [part for _, part, *_ in web.log if part[0] == 0]
                self.assertEqual(len(begun), 1, web.log)

    def test_a_voxel_server_that_wants_a_token_gets_it_from_clients_that_have_bound_it(self):
        server = Server(survey(), "--cache", "none", "--token-file", secret_file(SERVER))
        self.addCleanup(server.stop)
        refused = self.render(server.url, {"TERRAVOX_SERVER_TOKEN": SERVER})
        self.assertEqual(refused.code, 1, refused)
        self.assertRegex(refused.err, "401.*no token was sent.*TERRAVOX_SERVER_ORIGIN")
        run = self.render(
            server.url, {"TERRAVOX_SERVER_TOKEN": SERVER, "TERRAVOX_SERVER_ORIGIN": server.url}
        )
        self.assertEqual(run.code, 0, run)

    def test_arguments_that_would_show_a_secret_are_refused_before_any_request(self):
        web = self.host()
        url = web.url + "place.tvx"
        secret = {"TERRAVOX_SERVER_TOKEN": SERVER}
        for world, environment, says in (
            (
                url,
                {**secret, "TERRAVOX_SERVER_ORIGIN": "http://voxels.example"},
                "TERRAVOX_SERVER_ORIGIN.*http://voxels.example:80.*https",
            ),
            (url, {"TERRAVOX_SERVER_ORIGIN": web.url}, "TERRAVOX_SERVER_TOKEN is not set"),
            (url + "?key=hush", {}, r"place\.tvx'.*query"),
            (url.replace("://", "://somebody:hush@"), {}, r"place\.tvx'.*user"),
        ):
            with self.subTest(says):
                run = self.render(world, environment)
                self.assertEqual(run.code, 2, run)
                self.assertRegex(run.err, says)
                for hushed in (SERVER, "hush"):
                    self.assertNotIn(hushed, run.out + run.err)
                self.assertEqual(run.err.count("terravox: "), 1, run)
        self.assertEqual(web.log, [])

    def test_the_old_name_of_both_tokens_is_refused_by_all_that_used_it(self):
        environment = {**NOTHING, "TERRAVOX_TOKEN": "a-token-that-was-for-all"}
        picture = ("-o", self.out / "never.png")
        for program, *arguments in (
            ("VOXELSERVER", survey(), "--port", "0"),
            ("RAYTRACER", "worker", "--join", "127.0.0.1:1"),
            ("RAYTRACER", "farm", "status", "127.0.0.1:1"),
            ("RAYTRACER", "render", survey(), "--worker", "127.0.0.1:1", *picture),
            ("RAYTRACER", "world", "info", "http://127.0.0.1:1/place.tvx"),
        ):
            with self.subTest(arguments):
                run = Run([binary(program), *arguments], environment=environment, timeout_s=30)
                self.assertEqual(run.code, 2, run)
                self.assertRegex(
                    run.err, "TERRAVOX_TOKEN.*TERRAVOX_FARM_TOKEN.*TERRAVOX_SERVER_TOKEN"
                )
                self.assertNotIn("a-token-that-was-for-all", run.err)


if __name__ == "__main__":
    unittest.main()

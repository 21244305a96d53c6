#!/usr/bin/env python3
"""The voxel server with a token: clients without it get no information."""

import unittest

from support import Case, Server, survey, temporary_folder, wait_until
from wire import get, talk


class Token(Case):
    """Without the token only the page and /healthz, whatever the request looks like."""

    TOKEN = "correct-horse-battery-staple-1871"

    def token_file(self):
        file = temporary_folder() / "token"
        file.write_text(self.TOKEN + "\n")
        file.chmod(0o600)
        return file

    def test_only_the_token_opens(self):
        server = Server(survey(), "--cache", "none", "--token-file", self.token_file())
        try:
            self.assertEqual([server.get(p)[0] for p in ("/healthz", "/")], [200, 200])
            # From an address that has shown the right token, wrong ones are not limited.
            self.assertEqual(
                server.get("/v2/world", {"Authorization": "Bearer " + self.TOKEN})[0], 200
            )
            right = "Authorization: Bearer " + self.TOKEN
            wrong = [
                [],
                ["Authorization:"],
                ["Authorization: Bearer"],
                ["Authorization: Bearer "],
                [right[:-1]],
                [right + "x"],
                [right.upper()],
                ["Authorization: Basic " + self.TOKEN],
                ["Authorization: " + self.TOKEN],
                ["Authorization: Bearer x", right],
                ["Authorization: Bearer \xff\xfe"],
                ["X-" + right],
                ["Cookie: token=" + self.TOKEN],
            ]
            paths = [
                "/v2/world",
                "/v2/stats",
                "/metrics",
                "/v2/boxes/0/0/0/0",
                "/healthz/../v2/world",
                "//v2/world",
                "/page/../v2/world",
                "/v2/world?token=" + self.TOKEN,
            ]
            for headers in wrong:
                for path in paths:
                    with self.subTest(f"{path} {headers}"):
                        said = talk(server.port, get(path, *headers, "Connection: close"))
                        self.assertIn(said.statuses(), ([401], [400], [404]), str(said))
                        self.assertEqual(said.replies[0].problem(), "")
                        body = said.replies[0].body.replace(path.encode(), b"")
                        self.assertNotIn(self.TOKEN.encode(), body)
                        if said.statuses() == [401]:
                            asked = said.replies[0].headers.get("www-authenticate", "")
                            self.assertTrue(asked.startswith("Bearer"))
            said = talk(server.port, get("/v2/world", "Connection: close"))
            self.assertEqual(said.statuses(), [401])
            self.assertEqual(
                server.get("/v2/world", {"Authorization": "Bearer " + self.TOKEN})[0], 200
            )
        finally:
            self.assertEqual(server.stop(), 0)
        self.assertNotIn(self.TOKEN, server.err)

    def test_an_address_that_guesses_has_to_wait(self):
        server = Server(survey(), "--cache", "none", "--token-file", self.token_file())
        try:

            def answer(token):
                return server.get("/v2/world", {"Authorization": "Bearer " + token})

            self.assertEqual(answer("wrong-horse")[0], 401)
            wait_until(lambda: answer("wrong-horse")[0] == 429, "a refusal to judge tokens")
            status, headers, _ = answer("wrong-horse")
            self.assertIn((status, headers.get("Retry-After")), ((429, "1"), (401, None)))
            wait_until(lambda: answer(self.TOKEN)[0] == 200, "another try")
        finally:
            self.assertEqual(server.stop(), 0)

    def test_a_service_has_its_token_from_systemd(self):
        folder = temporary_folder()
        file = folder / "terravox.server-token"
        file.write_text(self.TOKEN + "\n")
        file.chmod(0o440)
        server = Server(
            survey(), "--cache", "none", program=("env", f"CREDENTIALS_DIRECTORY={folder}")
        )
        try:
            self.assertEqual(server.get("/v2/world")[0], 401)
            right = {"Authorization": "Bearer " + self.TOKEN}
            self.assertEqual(server.get("/v2/world", right)[0], 200)
        finally:
            self.assertEqual(server.stop(), 0)

    def test_a_body_is_not_read_before_the_token(self):
        flags = ["--header-timeout-s", "3600", "--drain-s", "0"]
        server = Server(survey(), "--cache", "none", "--token-file", self.token_file(), *flags)
        try:
            head = ["Content-Type: application/json", "Content-Length: 200000"]
            head.append("Expect: 100-continue")
            for headers in ([], ["Authorization: Bearer wrong-horse"]):
                said = talk(server.port, get("/v2/boxes", *head, *headers, method="POST"))
                self.assertEqual((said.statuses(), said.closed), ([401], True), str(said))
            right = "Authorization: Bearer " + self.TOKEN
            said = talk(server.port, get("/v2/boxes", *head, right, method="POST"))
            self.assertEqual(said.statuses(), [100], str(said))
        finally:
            self.assertEqual(server.stop(), 0)


if __name__ == "__main__":
    unittest.main()

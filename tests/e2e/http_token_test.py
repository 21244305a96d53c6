#!/usr/bin/env python3
"""The voxel server with a token: clients without it get no information."""

import unittest

from support import Case, Server, secret_file, survey, temporary_folder
from wire import get, talk


class Token(Case):
    """Without the token only the page and /healthz, whatever the request looks like."""

    TOKEN = "correct-horse-battery-staple-1871"

    def test_only_the_token_opens(self):
        """request_check_test.cpp has all that is no token, and the paths that are open."""
        server = Server(survey(), "--cache", "none", "--token-file", secret_file(self.TOKEN))
        right = "Authorization: Bearer " + self.TOKEN
        try:
            self.assertEqual([server.get(p)[0] for p in ("/healthz", "/")], [200, 200])
            # From an address that has shown the right token, wrong ones are not limited.
            said = talk(server.port, get("/v2/world", right, "Connection: close"))
            self.assertEqual(said.statuses(), [200])
            for headers in ([], [right[:-1]], ["Cookie: token=" + self.TOKEN]):
                for path in ("/v2/world", "//v2/world", "/page/../v2/world", "/v2/boxes/0/0/0/0"):
                    with self.subTest(f"{path} {headers}"):
                        said = talk(server.port, get(path, *headers, "Connection: close"))
                        self.assertIn(said.statuses(), ([401], [400], [404]), str(said))
                        self.assertEqual(said.replies[0].problem(), "")
                        self.assertNotIn(self.TOKEN.encode(), said.replies[0].body)
        finally:
            self.assertEqual(server.stop(), 0)
        self.assertNotIn(self.TOKEN, server.err)

    def test_a_service_has_its_token_from_systemd(self):
        folder = temporary_folder()
        file = folder / "terravox.server-token"
        file.write_text(self.TOKEN + "\n")
        file.chmod(0o440)
        with Server(
            survey(), "--cache", "none", program=("env", f"CREDENTIALS_DIRECTORY={folder}")
        ) as server:
            self.assertEqual(server.get("/v2/world")[0], 401)
            right = {"Authorization": "Bearer " + self.TOKEN}
            self.assertEqual(server.get("/v2/world", right)[0], 200)


if __name__ == "__main__":
    unittest.main()

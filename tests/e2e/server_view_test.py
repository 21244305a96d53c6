#!/usr/bin/env python3
"""The viewer of the real voxel server, in a browser, next to a site of the same data."""

import os
import subprocess
import unittest

from static_host import StaticHost
from support import HANGS_S, ROOT, Case, Run, Server, binary, survey, temporary_folder

TOKEN = "correct-horse-battery-staple-1871"


class ServerView(Case):
    @classmethod
    def setUpClass(cls):
        folder = temporary_folder() / "site"
        run = Run(
            [
                binary("PUBLISH"),
                survey(),
                "--ortho",
                survey() / "ortho",
                folder,
                "--no-preview",
                "--quiet",
            ]
        )
        assert run.code == 0, run
        cls.site = StaticHost(folder)

    @classmethod
    def tearDownClass(cls):
        cls.site.stop()

    def show(self, *arguments, **environment):
        """The squares are not prepared: the server makes its boxes while they are looked at."""
        cache = temporary_folder()
        server = Server(survey(), "--ortho", survey() / "ortho", "--cache", cache, *arguments)
        try:
            run = subprocess.run(
                [os.environ["TERRAVOX_NODE"], ROOT / "tests" / "page" / "run.mjs"],
                env={
                    **os.environ,
                    "TERRAVOX_VIEWED": server.url,
                    "TERRAVOX_VIEWED_SITE": self.site.url,
                    **environment,
                },
                capture_output=True,
                text=True,
                timeout=4 * HANGS_S,
                check=False,
            )
        finally:
            code = server.stop()
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        self.assertEqual(code, 0, server.err)
        for line in server.err.splitlines():
            self.assertFalse(line.startswith(("[warn", "[error")), server.err)

    def test_a_browser_shows_what_a_site_shows(self):
        self.show()

    def test_with_a_token_the_page_asks_for_it(self):
        file = temporary_folder() / "token"
        file.write_text(TOKEN + "\n")
        file.chmod(0o600)
        self.show("--token-file", file, TERRAVOX_VIEWED_TOKEN=TOKEN)


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
"""The viewer of the real voxel server, in a browser, next to a site of the same data."""

import unittest

from static_host import StaticHost
from support import Case, Server, make, run_page_tests, secret_file, survey, temporary_folder

TOKEN = "correct-horse-battery-staple-1871"


class ServerView(Case):
    @classmethod
    def setUpClass(cls):
        folder = temporary_folder() / "site"
        photos = ("--ortho", survey() / "ortho")
        make("PUBLISH", survey(), *photos, folder, "--no-preview", "--quiet")
        cls.site = StaticHost(folder)

    @classmethod
    def tearDownClass(cls):
        cls.site.stop()

    def show(self, *arguments, **environment):
        """The squares are not prepared: the server makes its boxes while they are looked at."""
        words = ("--ortho", survey() / "ortho", "--cache", temporary_folder())
        with Server(survey(), *words, *arguments) as server:
            run_page_tests(
                TERRAVOX_VIEWED=server.url, TERRAVOX_VIEWED_SITE=self.site.url, **environment
            ).done()
        for line in server.err.splitlines():
            self.assertFalse(line.startswith(("[warn", "[error")), server.err)

    def test_a_browser_shows_what_a_site_shows(self):
        self.show()

    def test_with_a_token_the_page_asks_for_it(self):
        self.show("--token-file", secret_file(TOKEN), TERRAVOX_VIEWED_TOKEN=TOKEN)


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
"""The web page of the real voxel server, in a browser.

Runs the page's own tests with the real server instead of a fake one.
"""

import sys
import unittest

from support import Case, Server, run_page_tests, survey, temporary_folder


class Page(Case):
    def test_the_page_works_with_the_server(self):
        flags = ["--ortho", survey() / "ortho", "--cache", temporary_folder(), "--jobs", "1"]
        with Server(survey(), *flags) as server:
            run_page_tests(TERRAVOX_URL=server.url).done()
        for line in server.err.splitlines():
            self.assertFalse(line.startswith(("[warn", "[error")), server.err)


if __name__ == "__main__":
    sys.exit(unittest.main())

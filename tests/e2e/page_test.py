#!/usr/bin/env python3
"""The web page of the real voxel server, in a browser.

Runs the page's own tests with the real server instead of a fake one.
"""

import os
import subprocess
import sys
import unittest

from support import HANGS_S, ROOT, Case, Server, survey, temporary_folder


class Page(Case):
    def test_the_page_works_with_the_server(self):
        flags = ["--ortho", survey() / "ortho", "--cache", temporary_folder(), "--jobs", "1"]
        server = Server(survey(), *flags)
        try:
            run = subprocess.run(
                [os.environ["TERRAVOX_NODE"], ROOT / "tests" / "page" / "run.mjs"],
                env={**os.environ, "TERRAVOX_URL": server.url},
                capture_output=True,
                text=True,
                timeout=2 * HANGS_S,
                check=False,
            )
        finally:
            code = server.stop()
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        self.assertEqual(code, 0, server.err)
        for line in server.err.splitlines():
            self.assertFalse(line.startswith(("[warn", "[error")), server.err)


if __name__ == "__main__":
    sys.exit(unittest.main())

#!/usr/bin/env python3
"""The static web host of these tests behaves as common hosts do."""

import gzip
import unittest
import urllib.error
import urllib.request

from static_host import StaticHost
from support import HANGS_S, Case, temporary_folder

PAGE = b"<!doctype html>" + b"x" * 5000
ARCHIVE = bytes(range(256)) * 100


class Hosts(Case):
    def setUp(self):
        self.folder = temporary_folder()
        (self.folder / "index.html").write_bytes(PAGE)
        (self.folder / "place.tvx").write_bytes(ARCHIVE)

    def host(self, **options):
        host = StaticHost(self.folder, **options)
        self.addCleanup(host.stop)
        return host

    def get(self, host, name, **headers):
        headers = {name.replace("_", "-"): value for name, value in headers.items()}
        request = urllib.request.Request(host.url + name, headers=headers)
        try:
            with urllib.request.urlopen(request, timeout=HANGS_S) as reply:
                return reply.status, reply.headers, reply.read()
        except urllib.error.HTTPError as refusal:
            return refusal.code, refusal.headers, refusal.read()

    def test_texts_are_compressed_for_clients_that_accept_it_and_ranges_never(self):
        host = self.host()
        status, headers, body = self.get(host, "", Accept_Encoding="gzip, br")
        self.assertEqual((status, headers["Content-Encoding"]), (200, "gzip"))
        self.assertEqual(gzip.decompress(body), PAGE)
        self.assertTrue(headers["ETag"].startswith('W/"'))
        self.assertEqual(host.sent, len(body))
        for name, given in (
            ("", {}),
            ("", {"Accept_Encoding": "gzip", "Range": "bytes=0-99"}),
            ("place.tvx", {"Accept_Encoding": "gzip"}),
        ):
            with self.subTest(name=name, given=given):
                _, headers, _ = self.get(host, name, **given)
                self.assertIsNone(headers["Content-Encoding"])
                self.assertTrue(headers["ETag"].startswith('"'))
        plain = self.host(compresses=False)
        self.assertEqual(self.get(plain, "", Accept_Encoding="gzip")[2], PAGE)

    def test_ranges_are_answered_as_rfc_9110_says(self):
        host = self.host()
        size = len(ARCHIVE)
        for asked, status, part, range_ in (
            ("bytes=0-9", 206, ARCHIVE[:10], f"bytes 0-9/{size}"),
            (f"bytes=9-{size + 5}", 206, ARCHIVE[9:], f"bytes 9-{size - 1}/{size}"),
            (f"bytes={size - 2}-", 206, ARCHIVE[-2:], f"bytes {size - 2}-{size - 1}/{size}"),
            (f"bytes={size}-", 416, b"", f"bytes */{size}"),
            ("bytes=x", 200, ARCHIVE, None),
        ):
            with self.subTest(asked):
                found = self.get(host, "place.tvx", Range=asked)
                self.assertEqual((found[0], found[2]), (status, part))
                self.assertEqual(found[1]["Content-Range"], range_)
        self.assertEqual(self.get(host, "../place.tvx")[0], 404)

    def test_a_host_misbehaves_as_it_is_told(self):
        asked = {"Range": "bytes=5-9"}
        whole = self.host(answers_ranges=False)
        self.assertEqual(self.get(whole, "place.tvx", **asked)[:3:2], (200, ARCHIVE))
        bare = self.host(is_bare=True, etag="")
        status, headers, body = self.get(bare, "place.tvx", **asked)
        self.assertEqual((status, body), (206, ARCHIVE[5:10]))
        self.assertIsNone(headers["Content-Range"] or headers["ETag"])
        failing = self.host(fails=lambda name, part: 503 if part == (5, 9) else None)
        self.assertEqual(self.get(failing, "place.tvx", **asked)[0], 503)
        self.assertEqual(self.get(failing, "place.tvx")[0], 200)

        def change(host):
            host.etag = f'"{host.requests}"'

        changing = self.host(before=change)
        tags = [self.get(changing, "place.tvx", **asked)[1]["ETag"] for _ in range(2)]
        self.assertEqual(tags, ['"0"', '"1"'])
        self.assertEqual([entry[:3] for entry in changing.log], [("place.tvx", (5, 9), 206)] * 2)


if __name__ == "__main__":
    unittest.main()

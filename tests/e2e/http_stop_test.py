#!/usr/bin/env python3
"""The voxel server is told to stop while clients ask, and while one reads nothing."""

import http.client
import threading
import time
import unittest

from support import Case, Server, survey
from wire import connect, get


class Stopping(Case):
    """SIGTERM under load: what runs is finished and whole, nothing new is begun."""

    MARGIN_S = 0.2  # a request sent just before the signal may be read after it

    def ask(self, server, paths, stop, log):
        """Requests on connections of their own until told to stop. @param log takes (when sent, status or error)"""
        i = 0
        while not stop.is_set():
            start = time.monotonic()
            try:
                status, _, _ = server.get(paths[i % len(paths)])
                log.append((start, status))
            except (OSError, http.client.HTTPException) as error:
                log.append((start, repr(error)))
                time.sleep(0.01)
            i += 1

    def test_running_requests_are_finished_and_new_ones_refused(self):
        server = Server(survey(), "--cache", "none", "--memory-mib", "128")
        paths = server.box_paths() + server.box_paths(1)
        stop, logs = threading.Event(), [[] for _ in range(16)]
        threads = [threading.Thread(target=self.ask, args=(server, paths[i::3], stop, logs[i]), daemon=True) for i in range(len(logs))]
        for thread in threads:
            thread.start()
        time.sleep(0.5)
        signalled = time.monotonic()
        code = server.stop(timeout_s=20)
        ended = time.monotonic()
        stop.set()
        for thread in threads:
            thread.join()
        self.assertEqual(code, 0, server.err)
        self.assertLess(ended - signalled, 10, "too long to stop")
        before = [what for log in logs for sent, what in log if sent < signalled - self.MARGIN_S]
        after = [what for log in logs for sent, what in log if sent > ended]
        self.assertGreater(len(before), 20)
        self.assertEqual([what for what in before if what not in (200, 204, 503)], [])
        self.assertEqual([what for what in after if isinstance(what, int)], [])
        for line in server.err.splitlines():
            self.assertFalse(line.startswith(("[warn", "[error")), server.err)

    def test_a_slow_reader_does_not_keep_it_from_stopping(self):
        server = Server(survey(), "--cache", "none")
        connection = connect(server.port)
        connection.sendall(b"".join(get(p) for p in server.box_paths() * 40))
        time.sleep(0.3)
        signalled = time.monotonic()
        try:
            code = server.stop(timeout_s=60)
        finally:
            connection.close()
        self.assertEqual(code, 0, server.err)
        self.assertLess(time.monotonic() - signalled, 45, "a client that reads nothing held the server up")


if __name__ == "__main__":
    unittest.main()

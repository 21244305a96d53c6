#!/usr/bin/env python3
"""The voxel server stops while clients send requests, and while one reads nothing."""

import http.client
import json
import select
import signal
import unittest

from support import HANGS_S, Case, Server, survey
from wire import connect, get


class Stopping(Case):
    """SIGTERM under load: what runs is finished and whole. host_test.cpp sees new ones refused."""

    def begun(self, server, paths):
        """Sends a request for many boxes and waits for the head of the reply.

        @return connection and reply
        """
        boxes = [[int(v) for v in path.split("/")[3:]] for path in paths]
        connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=HANGS_S)
        connection.request(
            "POST",
            "/v2/boxes",
            body=json.dumps({"boxes": boxes}),
            headers={"Content-Type": "application/json"},
        )
        reply = connection.getresponse()
        self.assertEqual(reply.status, 200, reply.headers)
        return connection, reply

    def test_running_requests_are_finished(self):
        server = Server(survey(), "--cache", "none", "--memory-mib", "128")
        paths = server.box_paths() + server.box_paths(1)
        connection, reply = self.begun(server, paths)
        whole = reply.read()
        connection.close()
        running = [self.begun(server, paths) for _ in range(4)]
        server.process.send_signal(signal.SIGTERM)
        self.assertEqual([len(reply.read()) == len(whole) for _, reply in running], [True] * 4)
        for connection, _ in running:
            connection.close()
        self.assertEqual(server.end(), 0, server.err)
        for line in server.err.splitlines():
            self.assertFalse(line.startswith(("[warn", "[error")), server.err)

    def test_a_slow_reader_does_not_keep_it_from_stopping(self):
        server = Server(survey(), "--cache", "none")
        connection = connect(server.port)
        connection.sendall(b"".join(get(p) for p in server.box_paths() * 40))
        self.assertTrue(select.select([connection], [], [], HANGS_S)[0], "no reply has begun")
        try:
            # For as long as the test may take, where a client that reads nothing holds it up.
            code = server.stop()
        finally:
            connection.close()
        self.assertEqual(code, 0, server.err)


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
"""The voxel server stops while clients send requests, and while one reads nothing."""

import http.client
import json
import select
import signal
import threading
import unittest

from support import HANGS_S, Case, Server, survey, wait_until
from wire import connect, get


class Stopping(Case):
    """SIGTERM under load: what runs is finished and whole, nothing new is begun."""

    # What a client sees of a request that the server never read: nothing at all.
    REFUSED = (
        ConnectionRefusedError,
        ConnectionResetError,
        BrokenPipeError,
        http.client.RemoteDisconnected,
    )

    def ask(self, server, paths, stop, log):
        """Sends requests on new connections until stopped.

        @param log takes status, "refused", or another error
        """
        i = 0
        while not stop.is_set():
            try:
                log.append(server.get(paths[i % len(paths)])[0])
            except self.REFUSED:
                log.append("refused")
            except (OSError, http.client.HTTPException) as error:
                log.append(repr(error))
            i += 1

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

    def test_running_requests_are_finished_and_new_ones_refused(self):
        server = Server(survey(), "--cache", "none", "--memory-mib", "128")
        paths = server.box_paths() + server.box_paths(1)
        stop = threading.Event()
        logs = [[] for _ in range(16)]
        threads = [
            threading.Thread(
                target=self.ask, args=(server, paths[i::3], stop, logs[i]), daemon=True
            )
            for i in range(len(logs))
        ]
        for thread in threads:
            thread.start()
        wait_until(lambda: all(len(log) >= 2 for log in logs), "each client has replies")
        connection, reply = self.begun(server, paths)
        whole = reply.read()
        connection.close()
        running = [self.begun(server, paths) for _ in range(4)]
        server.process.send_signal(signal.SIGTERM)
        self.assertEqual([len(reply.read()) == len(whole) for _, reply in running], [True] * 4)
        for connection, _ in running:
            connection.close()
        code = server.end()
        counts = [len(log) for log in logs]
        wait_until(
            lambda: all(len(log) >= count + 2 for log, count in zip(logs, counts)),
            "each client was refused",
        )
        stop.set()
        for thread in threads:
            thread.join()
        self.assertEqual(code, 0, server.err)
        # Each request has a whole reply, or nothing; one that is sent after the server has ended
        # has nothing.
        self.assertEqual(
            [what for log in logs for what in log if what not in (200, 204, 503, "refused")], []
        )
        self.assertEqual(
            [log[count + 1 :] for log, count in zip(logs, counts)],
            [["refused"] * (len(log) - count - 1) for log, count in zip(logs, counts)],
        )
        for line in server.err.splitlines():
            self.assertFalse(line.startswith(("[warn", "[error")), server.err)

    def test_a_slow_reader_does_not_keep_it_from_stopping(self):
        server = Server(survey(), "--cache", "none")
        connection = connect(server.port)
        connection.sendall(b"".join(get(p) for p in server.box_paths() * 40))
        self.assertTrue(select.select([connection], [], [], HANGS_S)[0], "no reply has begun")
        try:
            code = (
                server.stop()
            )  # for as long as the test may take, where a client that reads nothing holds it up
        finally:
            connection.close()
        self.assertEqual(code, 0, server.err)


if __name__ == "__main__":
    unittest.main()

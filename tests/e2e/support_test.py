#!/usr/bin/env python3
"""The shared parts of the end-to-end tests."""

import contextlib
import errno
import socket
import struct
import unittest

from support import Case, Server, hold_port, survey

IP_LOCAL_PORT_RANGE = 51  # linux/in.h


class HeldPort(Case):
    def test_no_program_listens_there(self):
        with self.assertRaises(ConnectionRefusedError):
            socket.create_connection(("127.0.0.1", hold_port()))

    def test_the_kernel_gives_it_to_no_program_that_requests_a_free_one(self):
        def ask(port):
            """For any free port of a range that is one port long."""
            with socket.socket() as other:
                other.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                try:
                    other.setsockopt(
                        socket.IPPROTO_IP, IP_LOCAL_PORT_RANGE, struct.pack("I", port | port << 16)
                    )
                except OSError:
                    self.skipTest("this kernel has no IP_LOCAL_PORT_RANGE (Linux 6.3)")
                other.bind(("127.0.0.1", 0))
                return other.getsockname()[1]

        with self.assertRaises(OSError) as refused:
            ask(hold_port())
        self.assertEqual(refused.exception.errno, errno.EADDRINUSE)
        with socket.create_server(("127.0.0.1", 0)) as closed:
            port = closed.getsockname()[1]
        with contextlib.suppress(OSError):  # another process was faster: this is why ports are held
            self.assertEqual(ask(port), port)

    def test_a_program_that_names_it_listens_there_again_and_again(self):
        port = hold_port()
        for _ in range(2):
            server = Server(survey(), port=port)
            self.assertEqual(server.port, port)
            self.assertEqual(server.get("/healthz")[0], 200)
            server.kill()


if __name__ == "__main__":
    unittest.main()

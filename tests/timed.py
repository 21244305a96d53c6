#!/usr/bin/env python3
"""Runs an entry of CTest, and writes down how much processor time it took.

    tests/timed.py NAME COMMAND [ARGUMENT...]

A line of NAME TAB SECONDS is added to the file that TERRAVOX_TIMES names: user and system time of
the command and of all that it started and waited for. Without that variable the command takes the
place of this script. The exit code is the command's, 128 and the signal's number after a signal.
"""

import os
import signal
import sys


def main():
    name, command = sys.argv[1], sys.argv[2:]
    times = os.environ.get("TERRAVOX_TIMES")
    if not times:
        os.execv(command[0], command)
    child = os.posix_spawn(command[0], command, os.environ)
    # What CTest sends when a limit has passed ends the command too.
    signal.signal(signal.SIGTERM, lambda number, _: os.kill(child, number))
    _, status, used = os.wait4(child, 0)
    line = f"{name}\t{used.ru_utime + used.ru_stime:.2f}\n"
    # One write, so that lines of entries that end at the same time do not mix.
    file = os.open(times, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o666)
    os.write(file, line.encode())
    os.close(file)
    code = os.waitstatus_to_exitcode(status)
    sys.exit(code if code >= 0 else 128 - code)


if __name__ == "__main__":
    main()

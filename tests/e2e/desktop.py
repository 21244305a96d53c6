"""A display without a screen (Xvfb), the keys and the mouse at it (xdotool), and what it shows."""

import contextlib
import os
import pathlib
import shutil
import signal
import struct
import subprocess

from support import HANGS_S, temporary_folder

MISSING = [tool for tool in ("Xvfb", "xdotool") if shutil.which(tool) is None]


class Desktop:
    def __init__(self, width=1280, height=800):
        self.folder = temporary_folder()
        read, write = os.pipe()
        words = ["Xvfb", "-displayfd", str(write), "-screen", "0", f"{width}x{height}x24"]
        words += ["-fbdir", str(self.folder), "-nolisten", "tcp", "-noreset"]
        self.server = subprocess.Popen(
            words, pass_fds=[write], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        os.close(write)
        with os.fdopen(read) as display_number:
            self.display = ":" + display_number.readline().strip()
        self.environment = {"DISPLAY": self.display, "LIBGL_ALWAYS_SOFTWARE": "1", "XAUTHORITY": ""}

    def stop(self):
        self.server.terminate()
        self.server.wait(HANGS_S)

    def do(self, *words):
        """Input of a user: words of xdotool."""
        subprocess.run(
            ["xdotool", *map(str, words)],
            env={**os.environ, **self.environment},
            check=True,
            timeout=HANGS_S,
            stdout=subprocess.DEVNULL,
        )

    def key(self, *keys):
        self.do("key", *keys)

    @contextlib.contextmanager
    def held(self, key):
        """For as long as the block lasts."""
        self.do("keydown", key)
        try:
            yield
        finally:
            self.do("keyup", key)

    def click(self, x, y, *more):
        self.do("mousemove", round(x), round(y), "sleep", "0.1", "click", *more, "1")

    @contextlib.contextmanager
    def at_once(self, program):
        """Input during the block reaches the program at once, as if it had been busy."""
        program.process.send_signal(signal.SIGSTOP)
        try:
            yield
        finally:
            program.process.send_signal(signal.SIGCONT)

    def drag(self, x0, y0, x1, y1, steps=10, button=1):
        words = ["mousemove", round(x0), round(y0), "sleep", "0.1"]
        words += ["mousedown", button, "sleep", "0.1"]
        for i in range(1, steps + 1):
            x, y = x0 + (x1 - x0) * i / steps, y0 + (y1 - y0) * i / steps
            words += ["mousemove", round(x), round(y), "sleep", "0.03"]
        self.do(*words, "mouseup", button)

    def see(self):
        """@return (width, height, rows of RGB bytes)"""
        data = pathlib.Path(self.folder / "Xvfb_screen0").read_bytes()
        # The X window dump: XWDFile.h of the X.Org Foundation.
        header = struct.unpack(">25I", data[:100])
        size = header[0]
        width = header[4]
        height = header[5]
        bits = header[11]
        row_bytes = header[12]
        colours = header[19]
        assert bits == 32, bits
        start = size + colours * 12
        rows = []
        for y in range(height):
            row = data[start + y * row_bytes : start + y * row_bytes + width * 4]
            rgb = bytearray(width * 3)
            # A pixel is blue, green, red and padding: little-endian.
            rgb[0::3] = row[2::4]
            rgb[1::3] = row[1::4]
            rgb[2::3] = row[0::4]
            rows.append(bytes(rgb))
        return width, height, rows

    def save(self, path):
        """Saves a PPM file for visual checks."""
        width, height, rows = self.see()
        pathlib.Path(path).write_bytes(b"P6 %d %d 255\n" % (width, height) + b"".join(rows))


def colours(seen, box):
    """How many different colours there are in x0, y0, x1, y1."""
    _, _, rows = seen
    x0, y0, x1, y1 = box
    return len({row[x * 3 : x * 3 + 3] for row in rows[y0:y1] for x in range(x0, x1)})


def changed(before, after, box):
    """The share of pixels in x0, y0, x1, y1 that are not the same."""
    x0, y0, x1, y1 = box
    other = sum(
        a[x * 3 : x * 3 + 3] != b[x * 3 : x * 3 + 3]
        for a, b in zip(before[2][y0:y1], after[2][y0:y1])
        for x in range(x0, x1)
    )
    return other / ((x1 - x0) * (y1 - y0))

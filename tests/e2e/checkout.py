"""Runs the commands of a Markdown page in a folder that looks like a checkout with data."""

import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import sys
import threading

import markdown
from luanti_world import write_world
from support import HANGS_S, ROOT, Run, binary, hold_port, survey, temporary_folder, wait_until

PROGRAMS = {
    "terravox-raytracer": "RAYTRACER",
    "terravox-archive": "ARCHIVE",
    "terravox-convert": "CONVERT",
    "terravox-publish": "PUBLISH",
    "terravox-view": "VIEW",
    "terravox-voxelserver": "VOXELSERVER",
    "terravox-survey": "SURVEY",
    "terravox-laz": "LAZ",
}
GRABBER = ROOT / "grabber" / "dist" / "main.js"
PORTS = ("7878", "7879", "8888")  # in the pages

# Those of the user of this machine must not reach these commands.
for variable in ("FARM_TOKEN", "SERVER_TOKEN", "SERVER_ORIGIN", "STORE"):
    os.environ.pop(f"TERRAVOX_{variable}", None)


def is_there(program):
    if program == "grabber":
        return GRABBER.exists() and is_there("node") and is_there("gdalinfo")
    return shutil.which(program) is not None


class Background:
    """A command that runs until the page ends."""

    def __init__(self, script, checkout):
        self.process = subprocess.Popen(
            ["bash", "-c", script],
            cwd=checkout.folder,
            env={**os.environ, **checkout.environment},
            text=True,
            errors="replace",
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        self.lines = []
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()

    def _read(self):
        with self.process.stdout as out:
            for line in out:
                self.lines.append(line)

    def log(self):
        return "".join(self.lines)

    def wait_for(self, text):
        wait_until(
            lambda: text in self.log() or self.process.poll() is not None,
            f"'{text}' of a command in the background",
        )
        if text in self.log():
            return
        code = self.end()
        if text not in self.log():
            raise AssertionError(f"it ended with {code}, without '{text}':\n{self.log()}")

    def end(self):
        code = self.process.wait(HANGS_S)
        self.reader.join(HANGS_S)
        return code

    def stop(self):
        if self.process.poll() is None:
            os.killpg(self.process.pid, signal.SIGTERM)
        return self.end()


class Checkout:
    """A folder as the reader of a page has it: the programs, and data under the page's names."""

    def __init__(self, page):
        self.folder = temporary_folder() / "terravox"
        self.home = self.folder.parent / "home"
        # The grabber looks for terravox-laz there, whatever the build that is tested is called.
        programs = self.folder / "build" / "release" / "bin"
        self.environment = {
            "HOME": str(self.home),
            "PATH": f"{programs}:{os.environ['PATH']}",
            "TERRAVOX_NO_BUILD": "1",
            "TERRAVOX_SKIP_PACKAGES": "1",
        }
        self.ports = {port: str(hold_port()) for port in PORTS}
        self._add_programs()
        self._add_data(page.read_text(encoding="utf-8"))

    def _add_programs(self):
        programs = self.folder / "build" / "release" / "bin"
        programs.mkdir(parents=True)
        # A copy: it looks for everything in the folder where it lies.
        shutil.copy(ROOT / "terravox", self.folder)
        for name in ("config", "grabber", "build/deps"):
            if (ROOT / name).exists():
                (self.folder / name).symlink_to(ROOT / name)
        small_run = pathlib.Path(__file__).with_name("small_run.py")
        for name, variable in PROGRAMS.items():
            words = (sys.executable, "-B", str(small_run), name, binary(variable))
            program = programs / name
            program.write_text(f'#!/bin/sh\nexec {shlex.join(words)} "$@"\n', encoding="utf-8")
            program.chmod(0o755)

    def _add_data(self, text):
        made = survey()
        square = next(made.glob("*.laz"))
        if "terravox survey" not in text:  # pages that make it themselves
            shutil.copytree(made, self.folder / "survey")
        (self.folder / "my_squares").mkdir()
        shutil.copy(square, self.folder / "my_squares" / "one.laz")
        shutil.copytree(made / "ortho", self.folder / "my_photos")
        shutil.copy(next(made.glob("ortho/*.tif")), self.folder / "photo.tif")
        shutil.copy(next(made.glob("truth/ground_*.tif")), self.folder / "dem.tif")
        self.home.mkdir()
        if ".minecraft/saves/Home" in text:
            world = self.home / ".minecraft" / "saves" / "Home"
            world.parent.mkdir(parents=True)
            Run([binary("RAYTRACER"), "convert", made, world, "--level", "1", "--quiet"]).done()
        if ".minetest/worlds/home" in text:
            write_world(self.home / ".minetest" / "worlds" / "home")

    def adapt(self, text):
        """The command of the page for this folder and this machine."""
        text = re.sub(r"\bDATA\b", "survey --ortho survey/ortho", text)
        text = re.sub(r"--listen :(\d+)", r"--listen 127.0.0.1:\1", text)
        text = re.sub(r"\bcoordinator:(\d+)", r"127.0.0.1:\1", text)
        text = re.sub(r"(--worker|farm \w+) render1\b", r"\1 127.0.0.1:7878", text)
        for port, free in self.ports.items():
            text = re.sub(rf"\b{port}\b", free, text)
        return text

    def run(self, block):
        script = "set -euo pipefail\n" + self.adapt(block.text)
        return Run(["bash", "-c", script], cwd=self.folder, environment=self.environment)

    def begin(self, block):
        return Background(self.adapt(block.text), self)

    def write(self, block):
        text = re.sub(r"^seconds = \d+$", "seconds = 0.08", block.text, flags=re.M)
        (self.folder / block.marks["file"]).write_text(text, encoding="utf-8")


def why_left_out(block):
    if "not run" in block.marks:
        return block.marks["not run"]
    missing = [name for name in block.marks.get("needs", "").split() if not is_there(name)]
    return f"not installed: {', '.join(missing)}" if missing else None


def check(block, code, wanted, log):
    if code != wanted:
        raise AssertionError(f"{block}: exit code {code}, not {wanted}\n{block.text}\n{log}")


def run_page(page):
    """Runs the commands of a page in order. @throws AssertionError with the first that fails"""
    checkout = Checkout(page)
    background = []
    try:
        for block in markdown.read(page)[1]:
            if why := why_left_out(block):
                print(f"{block}: left out: {why}", file=sys.stderr)
            elif "file" in block.marks:
                checkout.write(block)
            elif "background" in block.marks:
                background.append((block, checkout.begin(block)))
                background[-1][1].wait_for(block.marks["background"])
            else:
                run = checkout.run(block)
                check(block, run.code, int(block.marks.get("exit code", 0)), run)
                if "wait" in block.marks:
                    begun, program = background.pop()
                    check(begun, program.end(), 0, program.log())
        for begun, program in background:
            check(begun, program.stop(), 0, program.log())
    finally:
        for _, program in background:
            program.stop()

"""Programs that write files, and what must hold for each when a write fails."""

import itertools
import os
import resource
import shutil
import subprocess

from support import Case, binary, temporary_folder

LIMITS = {
    "descriptors": resource.RLIMIT_NOFILE,
    "address space": resource.RLIMIT_AS,
    "file size": resource.RLIMIT_FSIZE,
}

# Programs that write files: their arguments, the file, and what they may leave behind to resume
# from, or for the next run to remove.
WRITERS = {
    "render to PNG": ("RAYTRACER", ["render", "DATA", "-o", "OUT/a.png"], "a.png", []),
    "render to EXR": ("RAYTRACER", ["render", "DATA", "-o", "OUT/a.exr"], "a.exr", []),
    "render to TIFF": ("RAYTRACER", ["render", "DATA", "-o", "OUT/a.tif"], "a.tif", []),
    "render with a checkpoint": (
        "RAYTRACER",
        ["render", "DATA", "-o", "OUT/a.png", "--resume"],
        "a.png",
        ["a.png.tiles"],
    ),
    "animate": (
        "RAYTRACER",
        ["animate", "TURN", "DATA", "-o", "OUT/%02d.png"],
        "00.png",
        [".frames.png.done"],
    ),
    "archive": (
        "CONVERT",
        ["DATA", "OUT/a.tvx"],
        "a.tvx",
        ["a.tvx.journal", "a.tvx.part"],
    ),
    "Minecraft world": (
        "CONVERT",
        ["DATA", "OUT/mc"],
        "mc/level.dat",
        ["mc/conversion.journal"],
    ),
    "MagicaVoxel": ("CONVERT", ["DATA", "OUT/a.vox"], "a.vox", []),
    "OpenVDB": ("CONVERT", ["DATA", "OUT/a.vdb"], "a.vdb", []),
    "glTF": ("CONVERT", ["DATA", "OUT/a.glb"], "a.glb", []),
    "PLY": ("CONVERT", ["DATA", "OUT/a.ply"], "a.ply", []),
    "synthetic survey": (
        "SURVEY",
        ["--squares", "1x1", "--square-m", "64", "--density", "4", "-o", "OUT/sv"],
        "sv/TM_462464_101456.laz",
        [],
    ),
}
OF_A_PICTURE = ["--size", "160x90", "--threads", "2", "--cache", "none"]


class Ended:
    def __init__(self, arguments, limit=None, value=0, timeout_s=600, environment=None, within=()):
        """@param limit  a name of LIMITS, set to `value`
        @param within a command that runs others somewhere
        """

        def confine():
            if limit:
                resource.setrlimit(LIMITS[limit], (value, value))

        # Python ignores SIGXFSZ, and so does the child: writes fail with EFBIG, as on a full disk.
        done = subprocess.run(
            [str(a) for a in [*within, *arguments]],
            capture_output=True,
            text=True,
            errors="replace",
            timeout=timeout_s,
            preexec_fn=confine,
            restore_signals=False,
            check=False,
            env={**os.environ, **(environment or {})},
        )
        self.code = done.returncode
        self.err = done.stderr
        self.last = (self.err.strip().splitlines() or [""])[-1]

    def __str__(self):
        return f"exit code {self.code}\n{self.err}"


class Writers(Case):
    """The common part of tests of writers."""

    @classmethod
    def setUpClass(cls):
        cls.folder = temporary_folder()
        # A quarter of survey(), without its orthophotos and truth: each format still fills several
        # pages, and the writers run a hundred times.
        made = cls.folder / "survey"
        options = ["--seed", "7", "--squares", "1x1", "--square-m", "128", "--density", "4"]
        run = Ended([binary("SURVEY"), *options, "-o", made])
        assert run.code == 0, run
        cls.data = cls.folder / "data"
        cls.data.mkdir()
        for file in made.glob("*.laz"):
            shutil.copy(file, cls.data)
        cls.turn = cls.folder / "turn.toml"
        cls.turn.write_text("fps = 2\n\n[turntable]\nseconds = 1\n")
        cls.count = itertools.count()
        cls.good = {}

    def writer(self, name, out=None):
        """A run of a writer into a folder: one of its own, or another. @return arguments, folder"""
        program, words, _, _ = WRITERS[name]
        if out is None:
            out = self.folder / f"out{next(self.count)}"
            out.mkdir()
        arguments = [word.replace("OUT", str(out)) for word in words]
        arguments = [{"DATA": self.data, "TURN": self.turn}.get(word, word) for word in arguments]
        if program == "RAYTRACER":
            arguments += OF_A_PICTURE
        elif program == "CONVERT":
            arguments += ["--cache", "none"]
        return [binary(program), *arguments], out

    def whole(self, name):
        """Output of a writer without faults."""
        if name not in self.good:
            arguments, out = self.writer(name)
            run = Ended(arguments)
            self.assertEqual(run.code, 0, f"{name}: {run}")
            self.good[name] = out
        return self.good[name] / WRITERS[name][2]

    def whole_bytes(self, name):
        return self.whole(name).stat().st_size

    def whole_pages(self, name, page_bytes):
        """Of all files that a writer leaves without faults."""
        self.whole(name)
        return sum(
            -(-path.stat().st_size // page_bytes)
            for path in self.good[name].rglob("*")
            if path.is_file()
        )

    def assert_as_on_a_good_day(self, name, out):
        made = out / WRITERS[name][2]
        whole = self.whole(name)
        if whole.suffix in (
            ".exr",
            ".tif",
        ):  # these record when they were made, and how long that took
            self.assertAlike(made, whole, exact=True)
        else:
            self.assertEqual(
                made.read_bytes(), whole.read_bytes(), f"{name}: other bytes than without faults"
            )

    def assert_told(self, run, what):
        """It ended by itself: with a code, and with a line where it failed."""
        self.assertIn(run.code, (0, 1, 3), f"{what}: {run}")
        if run.code == 1:
            self.assertTrue(run.last.startswith("terravox: "), f"{what}: {run}")

    def assert_nothing_half_written(self, name, run, out):
        kept = WRITERS[name][3]
        if run.code == 0:
            self.assert_as_on_a_good_day(name, out)
        elif run.code == 1:
            self.whole(name)
            several = len([path for path in self.good[name].rglob("*") if path.is_file()]) > 1
            for path in out.rglob("*"):
                inside = str(path.relative_to(out))
                usual = self.good[name] / inside
                if inside in kept or ".part-" in path.name or (path.is_dir() and usual.is_dir()):
                    continue
                # Of several files some may be done when another one fails: then they are whole.
                self.assertTrue(several and usual.is_file(), f"{name} left {inside}: {run}")
                self.assertEqual(
                    path.read_bytes(), usual.read_bytes(), f"{name} left half of {inside}: {run}"
                )

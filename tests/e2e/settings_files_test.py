#!/usr/bin/env python3
"""A wrong TOML file on the command line is wrong usage: one line, exit code 2."""

import unittest

from support import Case, Run, binary, entries, square, temporary_folder

SMALL = ["--size", "16x9", "--samples", "1", "--quiet"]
HUNDRED_MB = 100 << 20


class SettingsFiles(Case):
    def setUp(self):
        self.inputs = temporary_folder()
        self.out = temporary_folder()

    def commands(self):
        """Commands that read a TOML file: name -> the command line with that file."""
        raytracer = binary("RAYTRACER")
        server = binary("VOXELSERVER")
        picture = self.out / "a.png"

        def render(*flags):
            return [raytracer, "render", square(), *SMALL, "-o", picture, *flags]

        return {
            "render --scene": lambda file: render("--scene", file),
            "render --materials": lambda file: render("--quality-materials", file),
            "render --classes": lambda file: render("--classes", file),
            "render --settings": lambda file: render("--world-settings", file),
            "render --look": lambda file: render("--camera-look", file),
            "animate ANIMATION": lambda file: [
                raytracer,
                "animate",
                file,
                square(),
                *SMALL,
                "-o",
                self.out / "frames",
            ],
            "worker --config": lambda file: [raytracer, "worker", "--config", file],
            "voxelserver --classes": lambda file: [
                server,
                square(),
                "--classes",
                file,
                "--port",
                "0",
            ],
            "voxelserver --settings": lambda file: [
                server,
                square(),
                "--settings",
                file,
                "--port",
                "0",
            ],
        }

    def files(self):
        """The error in the file -> the file."""
        malformed = self.inputs / "malformed.toml"
        malformed.write_text("[camera\nposition = 1\n")
        of_another = self.inputs / "another.toml"
        of_another.write_text('no_such_thing_anywhere = "x"\n')
        folder = self.inputs / "folder.toml"
        folder.mkdir()
        binary_file = self.inputs / "binary.toml"
        binary_file.write_bytes(bytes(range(256)) * 64)
        huge = self.inputs / "huge.toml"
        with huge.open("wb") as file:
            file.truncate(HUNDRED_MB)
        return {
            "malformed": malformed,
            "of another kind": of_another,
            "missing": self.inputs / "missing.toml",
            "a folder": folder,
            "binary": binary_file,
            "of 100 MB": huge,
        }

    def test_a_file_that_cannot_be_what_it_should_be(self):
        files = self.files()
        for option, command in self.commands().items():
            for wrong, file in files.items():
                with self.subTest(f"{option}: {wrong}"):
                    run = Run(command(file))
                    self.assertRefused(run, 2, file.name)
                    self.assertEqual(entries(self.out), [])


if __name__ == "__main__":
    unittest.main()

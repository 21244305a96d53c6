#!/usr/bin/env python3
"""A wrong TOML file is wrong usage, whether the command line names it, another file does, or it is
of the configuration: one line with the file, exit code 2."""

import pathlib
import shutil
import unittest

from luanti_world import write_world
from support import ROOT, Case, Run, binary, entries, square, temporary_folder

SMALL = ["--size", "16x9", "--samples", "1", "--quiet"]
MALFORMED = "# A comment.\n\n[camera\nposition = 1\n"
LINE = "(line 3)"


def malformed(file):
    pathlib.Path(file).write_text(MALFORMED)
    return file


class SettingsFiles(Case):
    def setUp(self):
        self.inputs = temporary_folder()
        self.out = temporary_folder()

    def commands(self):
        """Commands that read a TOML file: name -> the command line with that file."""
        raytracer = binary("RAYTRACER")
        server = [binary("VOXELSERVER"), square(), "--port", "0"]
        picture, outputs = self.out / "a.png", [*SMALL, "-o", self.out / "frames"]

        def render(*flags):
            return [raytracer, "render", square(), *SMALL, "-o", picture, *flags]

        return {
            "render --scene": lambda file: render("--scene", file),
            "render --materials": lambda file: render("--quality-materials", file),
            "render --classes": lambda file: render("--classes", file),
            "render --settings": lambda file: render("--world-settings", file),
            "render --look": lambda file: render("--camera-look", file),
            "animate ANIMATION": lambda file: [raytracer, "animate", file, square(), *outputs],
            "worker --config": lambda file: [raytracer, "worker", "--config", file],
            "voxelserver --classes": lambda file: [*server, "--classes", file],
            "voxelserver --settings": lambda file: [*server, "--settings", file],
        }

    def test_a_file_that_cannot_be_what_it_should_be(self):
        """toml_file_test.cpp has all that is no such file."""
        file = malformed(self.inputs / "malformed.toml")
        for option, command in self.commands().items():
            with self.subTest(option):
                self.assertRefused(Run(command(file)), 2, file.name, LINE)
                self.assertEqual(entries(self.out), [])


class FilesOfFiles(Case):
    """Malformed files that another file names."""

    def test_they_are_named_and_not_the_one_that_names_them(self):
        folder = temporary_folder()
        bad = malformed(folder / "malformed.toml")
        for option, text in {
            "--settings": f'[specialization]\npalette = "{bad}"\n',
            "--world-settings": f'[colour_variation]\ntints = "{bad}"\n',
            "--classes": 'extends = "malformed"\n',
            "--scene": f'[camera]\nlook = "{bad}"\n',
            "--scene of settings": f'[world]\nsettings = "{bad}"\n',
        }.items():
            with self.subTest(f"{option}: {text}"):
                naming = folder / "naming.toml"
                naming.write_text(text)
                flags = [option.split()[0], naming, *SMALL, "-o", folder / "a.png"]
                run = Run([binary("RAYTRACER"), "render", square(), *flags])
                self.assertRefused(run, 2, str(bad), LINE)
                self.assertNotIn(str(naming), run.err)
                self.assertFalse((folder / "a.png").exists())


class Configuration(Case):
    """Malformed files of a configuration that the user has changed."""

    @classmethod
    def setUpClass(cls):
        cls.worlds = temporary_folder()
        cls.luanti = cls.worlds / "luanti"
        write_world(cls.luanti)
        cls.minecraft = cls.worlds / "minecraft"
        flags = ["--to", "anvil", "--level", "2", "--quiet"]
        run = Run([binary("RAYTRACER"), "convert", square(), cls.minecraft, *flags])
        if run.code != 0:
            raise AssertionError(f"the Minecraft world: {run}")
        # Without a CRS of its own, so that its name is looked up.
        cls.nowhere = cls.worlds / "462_101.laz"
        whole = square().read_bytes()
        at = whole.index(b"LASF_Projection")
        cls.nowhere.write_bytes(whole[:at] + b"NONE" + whole[at + 4 :])

    def commands(self, out):
        """File of the configuration -> commands that read it."""

        def render(world, *flags):
            picture = out / "a.png"
            return [binary("RAYTRACER"), "render", world, *SMALL, "-o", picture, *flags]

        def serve(*inputs):
            return [binary("VOXELSERVER"), *inputs, "--cache", "none", "--port", "0"]

        anvil = ["convert", square(), out / "world", "--to", "anvil", "--quiet"]
        anvil = [binary("RAYTRACER"), *anvil]
        return {
            "materials.toml": [render(square())],
            "materials-clay.toml": [render(square(), "--materials", "clay")],
            "voxelize.toml": [render(square()), serve(square())],
            "classes/asprs.toml": [render(square()), serve(square(), "--classes", "asprs")],
            "palettes/default.toml": [render(square()), serve(square())],
            "tints/default.toml": [render(square())],
            "views/demo.toml": [render(square(), "--look", "demo")],
            "sources/si-lss.toml": [render(self.nowhere)],
            "blocks/blocks.toml": [render(self.minecraft), anvil],
            "blocks/old-blocks.toml": [render(self.minecraft)],
            "blocks/export.toml": [anvil],
            "blocks/luanti.toml": [render(self.luanti), serve(self.luanti)],
        }

    def test_each_is_named_with_the_line(self):
        out = temporary_folder()
        for name, commands in self.commands(out).items():
            folder = temporary_folder() / "config"
            shutil.copytree(ROOT / "config", folder)
            bad = malformed(folder / name)
            for command in commands:
                with self.subTest(f"{name}: {command[1:3]}"):
                    run = Run(command, environment={"TERRAVOX_CONFIG": str(folder)})
                    self.assertRefused(run, 2, str(bad), LINE)
                    self.assertEqual(entries(out), [])


if __name__ == "__main__":
    unittest.main()

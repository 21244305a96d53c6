#!/usr/bin/env python3
"""Packages for Debian, and the services in them.

With ./terravox test --all the packages are made twice, checked by lintian, and installed, used,
upgraded and purged in a fresh Debian (debian_root.py).
"""

import functools
import io
import pathlib
import re
import shutil
import subprocess
import tarfile
import unittest

import debian_root
from debian_root import INSTALL_S
from releasing import version
from support import ROOT, Case, Run, binary, only_in_all, survey, temporary_folder

UNITS = sorted((ROOT / "config" / "systemd").glob("*.service"))
MAX_EXPOSURE = 3.0
PICTURE = ("--size", "64x36", "--samples", "1", "--cache", "none", "--quiet")
EXAMPLES = ROOT / "docs" / "examples" / "cpp"
PYTHON = """
import terravox
picture = terravox.open("generated:5").render(fields={"output.size": "64x36"})
print(terravox.__version__, picture.rgb.shape[:2])
"""
BUILD_S = 7200
MAINTAINER = {"DEBFULLNAME": "Terravox", "DEBEMAIL": "packages@example.org"}


LIBRARY = "libterravox" + version().rpartition(".")[0]


class Services(Case):
    def test_they_are_confined(self):
        if shutil.which("systemd-analyze") is None:
            self.skipTest("systemd-analyze is not installed")
        self.assertEqual(
            [unit.name for unit in UNITS], ["terravox-serve.service", "terravox-worker.service"]
        )
        for unit in UNITS:
            with self.subTest(unit.name):
                run = Run(["systemd-analyze", "security", "--offline=true", unit])
                self.assertDone(run)
                exposure = re.search(r"exposure level for \S+ ([0-9.]+)", run.out)
                self.assertLessEqual(float(exposure[1]), MAX_EXPOSURE)

    def test_they_get_tokens_as_credentials_and_leave_memory_to_others(self):
        for unit in UNITS:
            with self.subTest(unit.name):
                text = unit.read_text(encoding="utf-8")
                self.assertRegex(text, r"(?m)^LoadCredential=(terravox\.server-)?token\b")
                self.assertRegex(text, r"(?m)^MemoryMax=\d+%$")
                self.assertRegex(text, r"(?m)^LimitCORE=0$")
                self.assertNotRegex(text, r"TERRAVOX_\w*TOKEN")
        settings = (ROOT / "config" / "debian" / "serve.env").read_text(encoding="utf-8")
        self.assertNotRegex(settings, r"TERRAVOX_\w*TOKEN")

    def test_they_start_the_installed_command(self):
        for unit in UNITS:
            text = unit.read_text(encoding="utf-8")
            self.assertRegex(text, r"(?m)^ExecStart=/usr/bin/terravox (serve|worker) ")


class Usage(Case):
    def package(self, *arguments):
        environment = {"TERRAVOX_NO_BUILD": "1"}
        return Run([ROOT / "terravox", "package", *arguments], environment=environment)

    def test_what_it_does_not_know_is_refused(self):
        self.assertRefused(self.package("rpm", "-o", "x"), 2, "'rpm'", "deb")
        self.assertRefused(self.package("deb"), 2, "-o FOLDER")
        self.assertRefused(self.package("deb", "-o", "x", "y"), 2, "'y'")
        self.assertRefused(self.package("wheel", "--arm64", "-o", "x"), 2, "--arm64", "deb")
        self.assertDone(self.package("--help"))


def make_packages(*options, **environment):
    """@return the files by the names of their packages"""
    folder = temporary_folder() / "packages"
    run = Run(
        [ROOT / "terravox", "package", "deb", *options, "-o", folder],
        environment={**MAINTAINER, **environment},
        timeout_s=BUILD_S,
    ).done()
    files = [pathlib.Path(line) for line in run.out.split() if line.endswith(".deb")]
    return {file.name.split("_")[0]: file for file in files}


@functools.cache
def made_packages():
    return make_packages(TERRAVOX_NO_BUILD="1")


@functools.cache
def made_packages_for_arm64():
    """They are compiled, as they are in no build folder of the tests."""
    return make_packages("--arm64")


def files_of(package):
    command = ["dpkg-deb", "--fsys-tarfile", package]
    done = subprocess.run(command, capture_output=True, check=True)
    with tarfile.open(fileobj=io.BytesIO(done.stdout)) as archive:
        return {entry.name for entry in archive if not entry.isdir()}


@only_in_all
class Packages(Case):
    def test_the_same_commit_makes_the_same_bytes(self):
        again = make_packages(TERRAVOX_NO_BUILD="1")
        other = make_packages(TERRAVOX_NO_BUILD="1", SOURCE_DATE_EPOCH="1000000000")
        self.assertEqual(set(made_packages()), set(again))
        for name, file in made_packages().items():
            with self.subTest(name):
                self.assertEqual(file.read_bytes(), again[name].read_bytes())
                self.assertNotEqual(file.read_bytes(), other[name].read_bytes())

    def test_lintian_has_no_errors(self):
        if shutil.which("lintian") is None:
            self.skipTest("lintian is not installed")
        command = ["lintian", "--allow-root", "--fail-on", "error"]
        self.assertDone(Run([*command, *made_packages().values()], timeout_s=INSTALL_S))

    def test_each_file_is_in_one_package(self):
        seen = {}
        for name, file in made_packages().items():
            for path in files_of(file):
                self.assertNotIn(path, seen, f"in {name} and {seen.get(path)}")
                seen[path] = name
        for path, name in (
            ("./usr/lib/terravox/terravox-preview", "terravox-preview"),
            ("./usr/share/man/man1/terravox-preview.1.gz", "terravox-preview"),
            ("./usr/share/terravox/config/materials.toml", "terravox-data"),
            ("./usr/bin/terravox", "terravox"),
            ("./usr/include/terravox/terravox.hpp", "libterravox-dev"),
            ("./usr/lib/libterravox.so", "libterravox-dev"),
        ):
            self.assertEqual(seen.get(path), name, path)

    def test_a_server_needs_no_window(self):
        for name in ("terravox", "python3-terravox"):
            control = Run(["dpkg-deb", "--field", made_packages()[name], "Depends"])
            self.assertDone(control)
            self.assertNotIn("libglfw", control.out)
            self.assertIn("libgdal", control.out)


@only_in_all
class Installed(Case):
    """In a fresh Debian. The order of the tests is that of their names."""

    architecture = ""

    @classmethod
    def make(cls):
        return made_packages()

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        missing = debian_root.missing(cls.architecture)
        if missing:
            raise unittest.SkipTest(missing)
        cls.root = debian_root.Root(cls.architecture)
        cls.before = cls.root.files()
        cls.packages = cls.make()
        for file in cls.packages.values():
            shutil.copy(file, cls.root.folder / "tmp")
        shutil.copytree(survey(), cls.root.folder / "tmp" / "survey")
        shutil.copytree(EXAMPLES, cls.root.folder / "tmp" / "examples")
        cls.root.run("apt-get", "update").done()

    def install(self, *packages):
        """Those of ours by their files, others by their names."""
        files = [self.packages.get(name, name) for name in packages]
        words = [f"/tmp/{file.name}" if isinstance(file, pathlib.Path) else file for file in files]
        command = ["apt-get", "--yes", "--no-install-recommends", "install", *words]
        self.assertDone(self.root.run(*command))

    def test_1_the_programs_make_the_picture_of_the_checkout(self):
        self.install("terravox-data", "terravox")
        words = ["/tmp/survey", "--ortho", "/tmp/survey/ortho", *PICTURE, "-o", "/tmp/p.png"]
        self.assertDone(self.root.run("terravox", "render", *words))
        ours = temporary_folder() / "p.png"
        words = [survey(), "--ortho", survey() / "ortho", *PICTURE, "-o", ours]
        self.assertDone(Run([binary("RAYTRACER"), "render", *words]))
        self.assertEqual(ours.read_bytes(), (self.root.folder / "tmp" / "p.png").read_bytes())
        run = self.root.run("terravox", "preview", "--help")
        self.assertRefused(run, 1, "not in /usr/lib/terravox", "the package terravox-preview")

    def test_2_the_window_is_a_package_of_its_own(self):
        self.install("terravox-preview")
        run = self.root.run("terravox", "preview", "--help")
        self.assertDone(run)
        self.assertIn("--scene", run.out)

    def test_3_the_examples_are_built_with_the_library(self):
        self.install("libterravox-dev", LIBRARY, "cmake", "g++", "make", "pkg-config")
        examples = "/tmp/examples"
        self.assertDone(self.root.run("cmake", "-S", examples, "-B", f"{examples}/build"))
        self.assertDone(self.root.run("cmake", "--build", f"{examples}/build"))
        square = next((self.root.folder / "tmp" / "survey").glob("*.laz")).name
        run = self.root.run(f"{examples}/build/rays_of_your_own", f"/tmp/survey/{square}")
        self.assertDone(run)
        self.assertEqual(len(run.out.splitlines()), 16)
        flags = self.root.run("pkg-config", "--libs", "terravox")
        self.assertIn("-lterravox", flags.out)

    def test_4_python_imports_the_module(self):
        self.install("python3-terravox")
        run = self.root.run("python3", "-c", PYTHON)
        self.assertDone(run)
        self.assertEqual(run.out.split(), [version(), "(36,", "64)"])

    def test_5_settings_stay_when_a_newer_version_comes(self):
        settings = self.root.folder / "etc" / "terravox" / "serve.env"
        settings.write_text('TERRAVOX_SERVE="generated:7"\n', encoding="utf-8")
        token = self.root.folder / "etc" / "terravox" / "token"
        token.write_text("secret\n", encoding="utf-8")
        for name, package in self.packages.items():
            newer(package, self.root.folder / "tmp" / f"newer-{name}.deb")
        newer_files = [f"/tmp/newer-{name}.deb" for name in self.packages]
        self.assertDone(self.root.run("dpkg", "--install", *newer_files))
        self.assertIn("generated:7", settings.read_text(encoding="utf-8"))
        self.assertDone(self.root.run("terravox", "help"))
        self.assertDone(self.root.run("python3", "-c", PYTHON))

    def test_6_nothing_stays_after_a_purge(self):
        self.assertDone(self.root.run("apt-get", "--yes", "purge", *self.packages))
        self.assertEqual(self.root.files() - self.before, set())


@only_in_all
class InstalledOnArm64(Installed):
    """On 64-bit ARM, which may be emulated: the picture has the bytes of this machine's."""

    architecture = "arm64"

    @classmethod
    def make(cls):
        return made_packages_for_arm64()

    def test_0_the_packages_are_for_that_processor(self):
        for name, file in self.packages.items():
            run = Run(["dpkg-deb", "--field", file, "Architecture"])
            self.assertEqual(run.out.strip(), "all" if name == "terravox-data" else "arm64")
            for path in files_of(file):
                self.assertNotIn("x86_64", path)


def newer(package, file):
    """Writes the same package with version 99."""
    work = temporary_folder() / "newer"
    subprocess.run(["dpkg-deb", "--raw-extract", package, work], check=True)
    control = work / "DEBIAN" / "control"
    text = control.read_text(encoding="utf-8").replace(f"(= {version()})", "(= 99)")
    control.write_text(re.sub(r"(?m)^Version: .*", "Version: 99", text), encoding="utf-8")
    words = ["dpkg-deb", "--root-owner-group", "-Zgzip", "-z1", "--build", work, file]
    subprocess.run(words, check=True, stdout=subprocess.DEVNULL)


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
"""The image for containers: what its layout holds, and whether manifests name it.

With ./terravox test --all it is made, and a picture is rendered in it as user 1000, with a root
that cannot be written.
"""

import gzip
import hashlib
import io
import json
import os
import pathlib
import shutil
import sys
import tarfile
import unittest

from support import ROOT, Case, Run, binary, only_in_all, survey, temporary_folder

MOST_MB = 250
WRITER = ROOT / "config" / "release" / "oci_image.py"
PICTURE = ("--size", "64x36", "--samples", "1", "--cache", "none", "--quiet")
TIME = 1_700_000_000
MAKE_S = 7200
RUN_S = 600


def entry(name, kind=tarfile.REGTYPE, **fields):
    made = tarfile.TarInfo(name)
    made.type = kind
    made.mtime = 1_600_000_000.5
    made.uname = "somebody"
    for field, value in fields.items():
        setattr(made, field, value)
    return made


SYSTEM = [
    (entry("./", tarfile.DIRTYPE, mode=0o755), None),
    (entry("./usr/bin/sh", mode=0o755), b"shell"),
    (entry("./usr/bin/ash", tarfile.LNKTYPE, linkname="./usr/bin/sh"), None),
    (entry("./usr/share/ca/Ő.crt"), b"certificate"),
    (entry("./usr/bin/terravox", mode=0o755), b"commands"),
    (entry("./usr/lib/terravox/terravox-raytracer", mode=0o755), b"program"),
    (entry("./dev/null", tarfile.CHRTYPE, devmajor=1, devminor=3), None),
    (entry("./lib", tarfile.SYMTYPE, linkname="usr/lib"), None),
]


def write_root(file, entries):
    with tarfile.open(file, "w") as archive:
        for member, data in entries:
            member.size = len(data or b"")
            archive.addfile(member, io.BytesIO(data) if data is not None else None)


class Image:
    """An image layout, read and checked against its own hashes."""

    def __init__(self, file):
        self.size = file.stat().st_size
        with tarfile.open(file) as archive:
            self._files = {each.name: archive.extractfile(each).read() for each in archive}
        assert json.loads(self._files["oci-layout"]) == {"imageLayoutVersion": "1.0.0"}
        self.index = json.loads(self._files["index.json"])
        self.manifest = json.loads(self.blob(self.index["manifests"][0]))
        self.settings = json.loads(self.blob(self.manifest["config"]))
        self.layers = [gzip.decompress(self.blob(each)) for each in self.manifest["layers"]]

    def blob(self, descriptor):
        algorithm, digest = descriptor["digest"].split(":")
        data = self._files[f"blobs/{algorithm}/{digest}"]
        assert hashlib.sha256(data).hexdigest() == digest
        assert len(data) == descriptor["size"]
        return data

    def file(self, name):
        return json.loads(self._files[name])

    def archive(self, layer):
        return tarfile.open(fileobj=io.BytesIO(self.layers[layer]))


class Layout(Case):
    def make(self, entries, *, time=TIME):
        folder = temporary_folder()
        write_root(folder / "root.tar", entries)
        words = [sys.executable, "-B", WRITER, folder / "root.tar", "-o", folder / "image.tar"]
        words += ["--version", "1.2.3", "--revision", "abc", "--architecture", "arm64"]
        self.assertDone(Run([*words, "--time", str(time)]))
        return folder / "image.tar"

    def test_it_names_its_layers_and_how_it_is_started(self):
        image = Image(self.make(SYSTEM))
        self.assertEqual(image.manifest["schemaVersion"], 2)
        plain = ["sha256:" + hashlib.sha256(layer).hexdigest() for layer in image.layers]
        self.assertEqual(image.settings["rootfs"]["diff_ids"], plain)
        self.assertEqual(len(image.settings["history"]), len(plain))
        self.assertEqual(image.settings["architecture"], "arm64")
        started = image.settings["config"]
        self.assertEqual(started["User"], "1000:1000")
        self.assertEqual((started["Entrypoint"], started["Cmd"]), (["terravox"], ["help"]))
        labels = started["Labels"]
        self.assertEqual(labels["org.opencontainers.image.version"], "1.2.3")
        self.assertEqual(labels["org.opencontainers.image.revision"], "abc")
        self.assertEqual(labels["org.opencontainers.image.created"], "2023-11-14T22:13:20Z")
        self.assertEqual(image.file("manifest.json")[0]["RepoTags"], ["terravox:1.2.3"])

    def test_layers_hold_what_the_root_holds(self):
        image = Image(self.make(SYSTEM))
        with image.archive(0) as base, image.archive(1) as own:
            self.assertEqual(
                base.getnames(), ["lib", "usr/bin/ash", "usr/bin/sh", "usr/share/ca/Ő.crt"]
            )
            self.assertEqual(
                own.getnames(),
                ["data", "usr/bin/terravox", "usr/lib/terravox/terravox-raytracer"],
            )
            self.assertEqual(own.extractfile("usr/bin/terravox").read(), b"commands")
            self.assertEqual(own.getmember("data").uid, 1000)
            for member in (*base, *own):
                self.assertEqual(member.uname, "")
            self.assertEqual({member.mtime for member in base}, {0})
            self.assertEqual({member.mtime for member in own}, {TIME})

    def test_a_link_comes_behind_what_it_leads_to(self):
        with Image(self.make(SYSTEM)).archive(0) as base:
            link = next(member for member in base if member.islnk())
            names = base.getnames()
            self.assertLess(names.index(link.linkname), names.index(link.name))
            for name in ("usr/bin/sh", "usr/bin/ash"):
                self.assertEqual(base.extractfile(name).read(), b"shell")
                self.assertEqual(base.getmember(name).mode, 0o755)

    def test_the_same_files_make_the_same_bytes(self):
        first = self.make(SYSTEM)
        again = [(entry(each.name, each.type, **fields(each)), data) for each, data in SYSTEM]
        self.assertEqual(first.read_bytes(), self.make(again[::-1]).read_bytes())
        other = Image(self.make(SYSTEM, time=TIME + 1))
        self.assertNotEqual(Image(first).layers[1], other.layers[1])
        # Hosts that have the system of one version have that of the next.
        self.assertEqual(Image(first).layers[0], other.layers[0])


def fields(member):
    names = ("mode", "linkname", "devmajor", "devminor")
    return {name: getattr(member, name) for name in names}


# Arguments: root, folder of data, user:group, the place of the data, and what is run there.
CONTAINER = """
set -eu
root=$1 data=$2 user=$3 place=$4
shift 4
mount --bind "$root" "$root"
mount -o remount,bind,ro "$root"
mount -t proc proc "$root/proc"
mount -t tmpfs -o mode=755 dev "$root/dev"
touch "$root/dev/null"
mount --bind /dev/null "$root/dev/null"
mount -t tmpfs -o mode=1777 tmp "$root/tmp"
mount --bind "$data" "$root$place"
exec chroot --userspec="$user" --groups= "$root" /usr/bin/env -i -C "$place" "$@"
"""


class Container:
    """Runs commands in an image as a cluster would: its user and environment, a root that cannot be
    written, no network, memory for /tmp. With the system's own tools: what runs images wants
    control groups, which are not everywhere."""

    def __init__(self, image):
        self._started = image.settings["config"]
        self.root = temporary_folder() / "root"
        self.data = temporary_folder() / "data"
        self.data.mkdir()
        # Others may enter what leads there.
        self.data.parent.chmod(0o755)
        os.chown(self.data, 1000, 1000)
        for layer in range(len(image.layers)):
            with image.archive(layer) as archive:
                archive.extractall(self.root, numeric_owner=True, filter="fully_trusted")

    def run(self, *arguments):
        started = self._started
        place = started["WorkingDir"]
        words = [*started["Entrypoint"], *(arguments or started["Cmd"])]
        spaces = ("--mount", "--pid", "--fork", "--ipc", "--uts", "--net")
        command = ["unshare", *spaces, "sh", "-c", CONTAINER, "sh"]
        command += [self.root, self.data, started["User"], place, *started["Env"], *words]
        return Run(command, timeout_s=RUN_S)


@only_in_all
class Made(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        if shutil.which("mmdebstrap") is None or os.geteuid() != 0:
            raise unittest.SkipTest("not root, or mmdebstrap is not installed")
        cls.file = cls.make()
        cls.image = Image(cls.file)
        cls.container = Container(cls.image)

    @classmethod
    def make(cls):
        run = Run(
            [ROOT / "terravox", "package", "image", "-o", temporary_folder()],
            environment={"TERRAVOX_NO_BUILD": "1"},
            timeout_s=MAKE_S,
        ).done()
        return pathlib.Path(run.out.strip())

    def test_it_is_small(self):
        self.assertLess(self.file.stat().st_size, MOST_MB * 1e6)
        sizes = [round(len(layer) / 1e6) for layer in self.image.layers]
        print(f"{self.file.stat().st_size / 1e6:.0f} MB; layers {sizes} MB", file=sys.stderr)

    def test_the_same_commit_makes_the_same_bytes(self):
        self.assertEqual(self.file.read_bytes(), self.make().read_bytes())

    def test_it_explains_itself(self):
        run = self.container.run()
        self.assertDone(run)
        self.assertIn("Usage: terravox COMMAND", run.out)

    def test_a_picture_has_the_bytes_of_the_checkouts(self):
        shutil.copytree(survey(), self.container.data / "survey")
        words = ("--ortho", "survey/ortho", *PICTURE, "-o", "picture.png")
        self.assertDone(self.container.run("render", "survey", *words))
        ours = temporary_folder() / "ours.png"
        words = ("--ortho", survey() / "ortho", *PICTURE, "-o", ours)
        self.assertDone(Run([binary("RAYTRACER"), "render", survey(), *words]))
        theirs = self.container.data / "picture.png"
        self.assertEqual(ours.read_bytes(), theirs.read_bytes())
        self.assertEqual(theirs.stat().st_uid, 1000)

    def test_a_cache_has_its_place_and_the_root_none(self):
        words = ("--size", "64x36", "--samples", "1", "--quiet")
        self.assertDone(self.container.run("render", "generated:5", *words, "-o", "p.png"))
        run = self.container.run("render", "generated:5", *words, "-o", "/p.png")
        self.assertEqual(run.code, 1, run)

    def test_every_library_is_there(self):
        programs = (self.container.root / "usr" / "lib" / "terravox").glob("terravox-*")
        names = [f"/usr/lib/terravox/{program.name}" for program in programs]
        self.assertGreater(len(names), 6)
        run = Run(["chroot", self.container.root, "ldd", *names])
        self.assertDone(run)
        self.assertNotIn("not found", run.out)


if __name__ == "__main__":
    unittest.main()

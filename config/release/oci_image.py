#!/usr/bin/env python3
"""Writes an image for containers of a root file system: a tar archive with an OCI image layout,
which podman, docker, containerd and skopeo read. Run by `./terravox package image`.

The same root makes the same bytes: entries are sorted, have one time and no names of users.
Ref: Open Container Initiative, "Image Format Specification" 1.1.
"""

import argparse
import copy
import datetime
import gzip
import hashlib
import io
import json
import pathlib
import tarfile
import tempfile

MEDIA = "application/vnd.oci.image"
# What changes with each version. The rest is a layer of its own, so that hosts that have it fetch
# little, and its times are all 0, so that it is the same as long as Debian's packages are.
OWN = (
    "etc/ld.so.cache",
    "etc/terravox",
    "lib/systemd/system/terravox",
    "usr/bin/terravox",
    "usr/lib/systemd/system/terravox",
    "usr/lib/terravox",
    "usr/share/bash-completion/completions/terravox",
    "usr/share/doc/terravox",
    "usr/share/fish/vendor_completions.d/terravox",
    "usr/share/terravox",
    "usr/share/zsh/vendor-completions/_terravox",
    "var/lib/dpkg",
)
# The user that Kubernetes' manifests name, too; it owns the folder where data are mounted.
USER = 1000
DATA = "data"
COMPRESSION = 6


def canonical(name):
    """Without ./ and / around it; "" of the root."""
    return name.removeprefix(".").strip("/")


def is_own(name):
    return name.startswith(OWN) or name == DATA


def blob_name(digest):
    return f"blobs/sha256/{digest}"


class Layer:
    """A layer under way: a compressed tar archive in a temporary file."""

    def __init__(self, time):
        self._time = time
        self.file = tempfile.TemporaryFile()  # noqa: SIM115 - it outlives this function
        self._compressed = gzip.GzipFile("", "wb", COMPRESSION, self.file, mtime=0)
        self._plain = hashlib.sha256()
        self._tar = tarfile.TarFile(mode="w", fileobj=self, format=tarfile.PAX_FORMAT)
        self._names = {}

    def write(self, data):
        self._plain.update(data)
        return self._compressed.write(data)

    def tell(self):
        return self._compressed.tell()

    def add(self, name, entry, data=None):
        """@param data of a file; the second name of one becomes a link to the first, as which of
        them the root's archive calls the link depends on the order it was written in"""
        entry = copy.copy(entry)
        if entry.isreg():
            first = self._names.setdefault(canonical(entry.name), name)
            if first != name:
                entry.type = tarfile.LNKTYPE
                entry.linkname = first
                entry.size = 0
        entry.name = name
        entry.mtime = self._time
        entry.uname = ""
        entry.gname = ""
        entry.pax_headers = {}
        self._tar.addfile(entry, data if entry.isreg() else None)

    def finish(self):
        self._tar.close()
        self._compressed.close()
        self.diff_id = "sha256:" + self._plain.hexdigest()
        self.size = self.file.tell()
        self.file.seek(0)
        self.digest = hashlib.file_digest(self.file, "sha256").hexdigest()
        self.file.seek(0)
        return self


def data_folder():
    folder = tarfile.TarInfo(DATA)
    folder.type = tarfile.DIRTYPE
    folder.mode = 0o755
    folder.uid = USER
    folder.gid = USER
    return folder


def layers_of(root, time):
    """@param root path of a tar archive, not compressed @return that of the system, ours"""
    base = Layer(0)
    own = Layer(time)
    with tarfile.open(root, "r:") as archive:
        entries = {canonical(each.name): each for each in archive if not each.isdev()}
        entries.pop("", None)
        entries[DATA] = data_folder()
        for name, entry in sorted(entries.items()):
            file = archive.getmember(entry.linkname) if entry.islnk() else entry
            data = archive.extractfile(file) if file.isreg() else None
            (own if is_own(name) else base).add(name, file, data)
    return base.finish(), own.finish()


def utc(time):
    moment = datetime.datetime.fromtimestamp(time, datetime.UTC)
    return moment.strftime("%Y-%m-%dT%H:%M:%SZ")


def labels(args):
    prefix = "org.opencontainers.image"
    return {
        f"{prefix}.title": "Terravox",
        f"{prefix}.description": "Real places as ray-traced voxel landscapes",
        f"{prefix}.licenses": "Apache-2.0",
        f"{prefix}.version": args.version,
        f"{prefix}.revision": args.revision,
        f"{prefix}.created": utc(args.time),
    }


def settings(args, layers):
    """What runtimes read of an image: how it is started, and of which layers it is made."""
    created = utc(args.time)
    steps = ("packages of the system", "packages of Terravox")
    return {
        "created": created,
        "architecture": args.architecture,
        "os": "linux",
        "config": {
            "User": f"{USER}:{USER}",
            # The programs themselves, too: generated jobs of a cluster name them.
            "Env": [
                "PATH=/usr/local/bin:/usr/bin:/bin:/usr/lib/terravox",
                "HOME=/tmp",
                "LANG=C.UTF-8",
            ],
            "Entrypoint": ["terravox"],
            "Cmd": ["help"],
            "WorkingDir": f"/{DATA}",
            "Labels": labels(args),
        },
        "rootfs": {"type": "layers", "diff_ids": [layer.diff_id for layer in layers]},
        "history": [{"created": created, "created_by": step} for step in steps],
    }


def packed(value):
    return json.dumps(value, sort_keys=True, separators=(",", ":")).encode()


def descriptor(media, digest, size):
    return {"mediaType": f"{MEDIA}.{media}", "digest": f"sha256:{digest}", "size": size}


class Layout:
    """The files of an image layout, in an archive."""

    def __init__(self, file, time):
        self._tar = tarfile.TarFile(file, "w", format=tarfile.USTAR_FORMAT)
        self._time = time

    def add(self, name, file, size):
        entry = tarfile.TarInfo(name)
        entry.size = size
        entry.mode = 0o644
        entry.mtime = self._time
        self._tar.addfile(entry, file)

    def add_bytes(self, name, data):
        self.add(name, io.BytesIO(data), len(data))

    def add_blob(self, media, data):
        """@return its descriptor"""
        digest = hashlib.sha256(data).hexdigest()
        self.add_bytes(blob_name(digest), data)
        return descriptor(media, digest, len(data))

    def close(self):
        self._tar.close()


def write_image(args, layers):
    layout = Layout(args.output, args.time)
    layout.add_bytes("oci-layout", packed({"imageLayoutVersion": "1.0.0"}))
    config = layout.add_blob("config.v1+json", packed(settings(args, layers)))
    manifest = {
        "schemaVersion": 2,
        "mediaType": f"{MEDIA}.manifest.v1+json",
        "config": config,
        "layers": [descriptor("layer.v1.tar+gzip", layer.digest, layer.size) for layer in layers],
        "annotations": labels(args),
    }
    entry = layout.add_blob("manifest.v1+json", packed(manifest))
    # Tools read the tag from the first, containerd the name from the second.
    entry["annotations"] = {
        "org.opencontainers.image.ref.name": args.version,
        "io.containerd.image.name": f"docker.io/library/terravox:{args.version}",
    }
    index = {
        "schemaVersion": 2,
        "mediaType": f"{MEDIA}.index.v1+json",
        "manifests": [entry],
    }
    layout.add_bytes("index.json", packed(index))
    for layer in layers:
        layout.add(blob_name(layer.digest), layer.file, layer.size)
    # `docker load` before version 25 and podman take the name from here.
    docker = {
        "Config": blob_name(config["digest"].removeprefix("sha256:")),
        "RepoTags": [f"terravox:{args.version}"],
        "Layers": [blob_name(layer.digest) for layer in layers],
    }
    layout.add_bytes("manifest.json", packed([docker]))
    layout.close()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("root", type=pathlib.Path, help="tar archive of the root file system")
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True)
    parser.add_argument("--version", required=True, help="of Terravox")
    parser.add_argument("--revision", required=True, help="the commit")
    parser.add_argument("--architecture", required=True, help="as Go names it: amd64, arm64")
    parser.add_argument("--time", type=int, required=True, help="seconds since 1970")
    args = parser.parse_args()
    write_image(args, layers_of(args.root, args.time))


if __name__ == "__main__":
    main()

"""Rows of the fault bench: who has no business here, in very large numbers or with the wrong papers."""

import os
import pathlib
import re
import resource
import socket
import subprocess
import sys
import time

from farming import ENVIRONMENT, FOLDER, RAYTRACER, Render, Worker, of, path_scene, wanted
from flood import Idle, flood, more_descriptors

_DESCRIPTORS = 256


def _few_descriptors():
    resource.setrlimit(resource.RLIMIT_NOFILE, (_DESCRIPTORS, _DESCRIPTORS))


def _joined(scene, render, worker, out, name):
    out[f"{name}_joined_s"] = render.watch.saw(f"worker {worker.name} at", 60)[0] - max(
        render.start, worker.start
    )
    out["wrong"] += render.end().bytes != wanted(scene)
    out["lost"] += render.farm["lost"]


def _storm_at_worker(args, scene, out):
    worker = Worker(limits=[_few_descriptors])
    calm = Render(*scene, *of([worker]), log="info")
    _joined(scene, calm, worker, out, "worker_calm")
    with Idle(worker.port, args.idle):
        out["worker_tried"] = flood(worker.port, args.flood_s)
        _joined(scene, Render(*scene, *of([worker]), log="info"), worker, out, "worker")
    with Idle(worker.port, args.idle, stubborn=True) as idle:
        _joined(scene, Render(*scene, *of([worker]), log="info"), worker, out, "worker_meanwhile")
    out["worker_stubborn"] = idle.opened
    out["worker_descriptors"] = worker.status()[1]
    worker.kill()


def _storm_at_coordinator(args, scene, out):
    for name, stubborn in (("coordinator", False), ("coordinator_meanwhile", True)):
        render = Render(
            *scene,
            "--threads",
            "0",
            "--listen",
            "127.0.0.1:0",
            log="info",
            limits=[_few_descriptors],
        )
        port = int(render.watch.saw(r"on port (\d+)", 60)[1].group(1))
        with Idle(port, args.idle, stubborn=stubborn):
            if not stubborn:
                out["coordinator_tried"] = flood(port, args.flood_s)
            worker = Worker(join=f"127.0.0.1:{port}")
            _joined(scene, render, worker, out, name)
        worker.kill()


def storm(args):
    """Idle connections and then a flood, at a program that may have 256 descriptors: afterwards a peer that may joins, and the picture is right. And one
    that joins while those who are hung up on come again at once."""
    scene = path_scene(32)
    out = {"wrong": 0, "lost": 0}
    _storm_at_worker(args, scene, out)
    _storm_at_coordinator(args, scene, out)
    return out


def _altered(name, alter):
    """A copy of the program that says something else of itself; None: there is nothing to alter in it."""
    data = pathlib.Path(RAYTRACER).read_bytes()
    other = alter(data)
    if other == data:
        return None
    path = FOLDER / name
    path.write_bytes(other)
    path.chmod(0o755)
    return path


def _other_version(data):
    """The compiler puts so short a text into its instructions. Where it stands as a text it stays: linkers let the ends of texts stand for others."""
    version = subprocess.run(
        [RAYTRACER, "--version"], check=True, capture_output=True
    ).stdout.split()[-1]
    begin, end = version[:4], version[4:]
    return re.sub(
        re.escape(begin) + b"(?!" + re.escape(end) + rb"\0)",
        begin[:2] + (b"9" if begin[2:3] != b"9" else b"8") + begin[3:],
        data,
    )


def _build():
    """The name of this program's build, as its checkpoints tell."""
    picture = FOLDER / "build.png"
    subprocess.run(
        [
            RAYTRACER,
            "render",
            *(str(a) for a in path_scene(1, size="16x16")),
            "--part",
            "1/1",
            "--quiet",
            "-o",
            picture,
        ],
        env=ENVIRONMENT,
        check=True,
        capture_output=True,
    )
    head = picture.with_name("build.png.part-1-of-1.tiles").read_bytes()[:65536]
    return re.search(rb'build["\' :=]+([0-9a-f]{16})', head).group(1)


def unwelcome(args):
    """Wrong version, build, token or certificate, from either side: how long from dialling, or the start of the program that dials, until both ends
    have said why."""
    build = _build()
    other_version, other_build = (
        _altered("other-version", _other_version),
        _altered("other-build", lambda data: data.replace(build, build[::-1])),
    )
    bare = {**ENVIRONMENT, "TERRAVOX_FARM_TOKEN": ""}
    papers = {}
    for name in ("ours", "theirs"):
        subprocess.run(
            [RAYTRACER, "farm", "certs", "-o", FOLDER / name],
            check=True,
            capture_output=True,
            env=bare,
        )
        papers[name] = [
            "--tls-ca",
            FOLDER / name / "ca.pem",
            "--tls-cert",
            FOLDER / name / "worker.pem",
            "--tls-key",
            FOLDER / name / "worker.key",
        ]
    # A copy stands elsewhere, and would not find its configuration.
    config = {
        **ENVIRONMENT,
        "TERRAVOX_CONFIG": str(pathlib.Path(__file__).resolve().parents[3] / "config"),
    }
    other_token = {**ENVIRONMENT, "TERRAVOX_FARM_TOKEN": "y3bw6fj8nq2xs5gm9tzk"}
    # (case, of who dials: options and flags; of who listens; what both say)
    cases = (
        (
            "version",
            {"program": other_version, "environment": config},
            (),
            {},
            (),
            "version terravox",
            "version terravox",
        ),
        (
            "build",
            {"program": other_build, "environment": config},
            (),
            {},
            (),
            "build [0-9a-f]{16}",
            "build [0-9a-f]{16}",
        ),
        ("token", {"environment": other_token}, (), {}, (), "token", "wrong token"),
        (
            "certificate",
            {"environment": bare},
            papers["theirs"],
            {"environment": bare},
            papers["ours"],
            "certificate",
            "certificate",
        ),
        (
            "token_for_certificate",
            {},
            (),
            {"environment": bare},
            papers["ours"],
            "certificates",
            "certificates are wanted",
        ),
        (
            "certificate_for_token",
            {"environment": bare},
            papers["ours"],
            {},
            (),
            "connect to",
            "a token is wanted",
        ),
    )
    scene = path_scene(32)
    out = {"cases": 0, "most_s": 0.0, "let_in": 0}
    for (
        name,
        dialler,
        dialler_flags,
        listener,
        listener_flags,
        dialler_says,
        listener_says,
    ) in cases:
        if dialler.get("program", RAYTRACER) is None:
            print(
                f"unwelcome: no program of another {name} can be made of {RAYTRACER}",
                file=sys.stderr,
                flush=True,
            )
            continue
        for way in ("render_dials", "worker_joins"):
            if way == "render_dials":
                there = Worker(arguments=listener_flags, **listener)
                here = Render(*scene, *of([there]), *dialler_flags, log="info", **dialler)
            else:
                there = Render(
                    *scene,
                    "--threads",
                    "0",
                    "--listen",
                    "127.0.0.1:0",
                    *listener_flags,
                    log="info",
                    **listener,
                )
                port = int(there.watch.saw(r"on port (\d+)", 60)[1].group(1))
                here = Worker(join=f"127.0.0.1:{port}", arguments=dialler_flags, **dialler)
            told = max(
                here.watch.saw(rf"(warning|error)\].*{dialler_says}", 30)[0],
                there.watch.saw(rf"(warning|error)\].*{listener_says}", 30)[0],
            )
            # A render has its inputs open when it dials, and says so.
            opened = here.watch.look("points in .* files")
            told_s = told - (opened[0] if opened else here.start)
            out["cases"] += 1
            out["let_in"] += any(
                p.watch.look(r"\[info\] (worker|works for) ") is not None for p in (here, there)
            )
            out[f"{name}_{way}_s"] = told_s
            out["most_s"] = max(out["most_s"], told_s)
            here.kill()
            there.kill()
    # Nobody else speaks another version of the handshake yet.
    there = Worker()
    at = time.monotonic()
    with socket.create_connection(("127.0.0.1", there.port)) as stranger:
        stranger.sendall(b"TVX-FARM\x07" + os.urandom(32))
        out["handshake_s"] = (
            there.watch.saw("shakes hands by version 7, this end by", 30, after=at)[0] - at
        )
    out["most_s"] = max(out["most_s"], out["handshake_s"])
    out["cases"] += 1
    there.kill()
    return out


def descriptors_missing():
    """Why so many connections cannot be made here; empty: they can."""
    most = more_descriptors(6000)
    return (
        ""
        if most >= 6000
        else f"this process may have {most} descriptors (ulimit -Hn); wanted: 6000"
    )


MISSING = {"storm": descriptors_missing}
ROWS = {"storm": storm, "unwelcome": unwelcome}

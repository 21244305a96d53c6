"""Rows of the fault bench: unauthorised peers, in very large numbers or with wrong credentials."""

import dataclasses
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
    """Idle connections and then a flood, at a program that is limited to 256 descriptors.

    Afterwards an authorised peer joins, and the picture is right. Another one joins while peers
    that were disconnected reconnect at once.
    """
    scene = path_scene(32)
    out = {"wrong": 0, "lost": 0}
    _storm_at_worker(args, scene, out)
    _storm_at_coordinator(args, scene, out)
    return out


def _altered(name, alter):
    """Makes a copy of the program that reports something else about itself.

    @return None when it has nothing to alter
    """
    data = pathlib.Path(RAYTRACER).read_bytes()
    other = alter(data)
    if other == data:
        return None
    path = FOLDER / name
    path.write_bytes(other)
    path.chmod(0o755)
    return path


def _other_version(data):
    """Alters the version in a program.

    The compiler puts so short a text into its instructions. Where it stands as a text it stays,
    since linkers merge texts with the ends of other texts.
    """
    version = subprocess.run(
        [RAYTRACER, "--version"], check=True, capture_output=True
    ).stdout.split()[-1]
    begin = version[:4]
    end = version[4:]
    return re.sub(
        re.escape(begin) + b"(?!" + re.escape(end) + rb"\0)",
        begin[:2] + (b"9" if begin[2:3] != b"9" else b"8") + begin[3:],
        data,
    )


def _build():
    """@return the name of the program's build, from one of its checkpoints"""
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


@dataclasses.dataclass
class _Side:
    """One end of a connection that is refused."""

    reports: str  # a pattern of its warning or error
    options: dict = dataclasses.field(default_factory=dict)  # of Worker or Render
    flags: list = dataclasses.field(default_factory=list)


def _certificate_flags(name):
    """Makes a certificate authority. @return flags for a program with a certificate of it"""
    folder = FOLDER / name
    bare = {**ENVIRONMENT, "TERRAVOX_FARM_TOKEN": ""}
    subprocess.run(
        [RAYTRACER, "farm", "certs", "-o", folder], check=True, capture_output=True, env=bare
    )
    files = {"ca": "ca.pem", "cert": "worker.pem", "key": "worker.key"}
    return [word for flag, file in files.items() for word in (f"--tls-{flag}", folder / file)]


def _unwelcome_pairs():
    """@return {case: (the side that dials, the side that listens)}"""
    build = _build()
    other_version = _altered("other-version", _other_version)
    other_build = _altered("other-build", lambda data: data.replace(build, build[::-1]))
    ours = _certificate_flags("ours")
    theirs = _certificate_flags("theirs")
    # A copy is in another folder, and would not find its configuration.
    config_folder = pathlib.Path(__file__).resolve().parents[3] / "config"
    config = {**ENVIRONMENT, "TERRAVOX_CONFIG": str(config_folder)}
    bare = {"environment": {**ENVIRONMENT, "TERRAVOX_FARM_TOKEN": ""}}
    other_token = {
        "environment": {**ENVIRONMENT, "TERRAVOX_FARM_TOKEN": "y3bw6fj8nq2xs5gm9tzkc7dv1hr4pe8u"}
    }
    return {
        "version": (
            _Side("version terravox", {"program": other_version, "environment": config}),
            _Side("version terravox"),
        ),
        "build": (
            _Side("build [0-9a-f]{16}", {"program": other_build, "environment": config}),
            _Side("build [0-9a-f]{16}"),
        ),
        "token": (_Side("token", other_token), _Side("wrong token")),
        "certificate": (_Side("certificate", bare, theirs), _Side("certificate", bare, ours)),
        "token_for_certificate": (
            _Side("certificates"),
            _Side("certificates are required", bare, ours),
        ),
        "certificate_for_token": (
            _Side("connect to", bare, ours),
            _Side("a token is required"),
        ),
    }


def _render_dials(dialler, listener):
    """@return the program that dials, and the one that listens"""
    there = Worker(arguments=listener.flags, **listener.options)
    here = Render(*path_scene(32), *of([there]), *dialler.flags, log="info", **dialler.options)
    return here, there


def _worker_joins(dialler, listener):
    """@return the program that dials, and the one that listens"""
    listens = ["--threads", "0", "--listen", "127.0.0.1:0", *listener.flags]
    there = Render(*path_scene(32), *listens, log="info", **listener.options)
    port = int(there.watch.saw(r"on port (\d+)", 60)[1].group(1))
    here = Worker(join=f"127.0.0.1:{port}", arguments=dialler.flags, **dialler.options)
    return here, there


def _refusal(connect, dialler, listener):
    """@return seconds until both sides have reported the reason, and whether a peer was let in"""
    here, there = connect(dialler, listener)
    reported = max(
        here.watch.saw(rf"(warning|error)\].*{dialler.reports}", 30)[0],
        there.watch.saw(rf"(warning|error)\].*{listener.reports}", 30)[0],
    )
    # A render has opened its inputs when it dials, and logs that.
    opened = here.watch.look("points in .* files")
    let_in = any(p.watch.look(r"\[info\] (worker|works for) ") is not None for p in (here, there))
    here.kill()
    there.kill()
    return reported - (opened[0] if opened else here.start), let_in


def _other_handshake_s():
    """@return seconds until a worker has reported an unknown version of the handshake

    No program has another version yet, so this sends its bytes.
    """
    there = Worker()
    at = time.monotonic()
    with socket.create_connection(("127.0.0.1", there.port)) as peer:
        peer.sendall(b"TVX-FARM\x07" + os.urandom(32))
        reported = there.watch.saw("uses handshake version 7; allowed: ", 30, after=at)[0]
    there.kill()
    return reported - at


def unwelcome(args):
    """Wrong version, build, token or certificate, from either side.

    Measures the time from dialling, or from the start of the program that dials, until both ends
    have reported the reason.
    """
    out = {"cases": 0, "most_s": 0.0, "let_in": 0}
    for name, (dialler, listener) in _unwelcome_pairs().items():
        if dialler.options.get("program", RAYTRACER) is None:
            print(
                f"unwelcome: no program of another {name} can be made of {RAYTRACER}",
                file=sys.stderr,
                flush=True,
            )
            continue
        for way, connect in (("render_dials", _render_dials), ("worker_joins", _worker_joins)):
            reported_s, let_in = _refusal(connect, dialler, listener)
            out["cases"] += 1
            out["let_in"] += let_in
            out[f"{name}_{way}_s"] = reported_s
            out["most_s"] = max(out["most_s"], reported_s)
    out["handshake_s"] = _other_handshake_s()
    out["most_s"] = max(out["most_s"], out["handshake_s"])
    out["cases"] += 1
    return out


def descriptors_missing():
    """@return why so many connections are not possible here, or an empty string"""
    most = more_descriptors(6000)
    return (
        ""
        if most >= 6000
        else f"this process may have {most} descriptors (ulimit -Hn); wanted: 6000"
    )


MISSING = {"storm": descriptors_missing}
ROWS = {"storm": storm, "unwelcome": unwelcome}

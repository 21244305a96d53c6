"""Rows of the fault bench: a network that loses packets, is narrow or slow, or resets."""

import re
import time
import urllib.request

from farming import DEFAULTS, Render, Worker, path_scene, wanted
from networks import Namespace, Payload, networks_missing
from proxy import Proxy, proxy_missing


def loss(args):
    """5 % packet loss each way, at 20 Mbit/s.

    The same picture twice: traffic compared with the bytes of the tiles.
    """
    scene = path_scene(8, size="1280x720", tile=32)
    space = Namespace()
    try:
        space.limit(20)
        space.lose(5)
        worker = Worker(
            host=space.there,
            within=space,
            arguments=["--metrics", f"{space.there}:9187"],
            environment=DEFAULTS,
        )
        out = {"wrong": 0}
        results_before = 0
        for name in ("first", "second"):
            there_before, here_before = space.link_bytes()
            render = Render(
                *scene, "--threads", "0", "--worker", worker.address, environment=DEFAULTS
            )
            payload = Payload(0, 0, 0)
            while render.has_ended(0.05) is None:
                payload = max(payload, space.payload(worker.port))
            render.end()
            out["wrong"] += render.bytes != wanted(scene)
            page = (
                urllib.request.urlopen(f"http://{space.there}:9187/metrics", timeout=60)
                .read()
                .decode()
            )
            results = int(
                float(re.search(r"^terravox_worker_results_bytes_total (\S+)", page, re.M).group(1))
            )
            tiles = results - results_before
            results_before = results
            there, here = (
                now - before for now, before in zip(space.link_bytes(), (there_before, here_before))
            )
            out.update(
                {
                    f"{name}_s": render.tracing_s,
                    f"{name}_tiles_bytes": tiles,
                    f"{name}_answers_ratio": payload.confirmed / tiles,
                    f"{name}_to_worker_bytes": payload.received,
                    f"{name}_traffic_ratio": (payload.confirmed + payload.received) / tiles,
                    f"{name}_again_share": payload.again / payload.confirmed,
                    f"{name}_link_ratio": there / tiles,
                    f"{name}_link_to_worker_bytes": here,
                    f"{name}_lost": render.farm["lost"],
                }
            )
        worker.kill()
    finally:
        space.heal()
        space.remove()
    return out


def latency(args):
    """200 +- 50 ms each way, then also occasional resets: the picture is finished and unchanged."""
    out = {}
    for name, samples, every_s in (("latency", 50, None), ("resets", 100, 3)):
        scene = path_scene(samples)
        worker = Worker(environment=DEFAULTS)
        with Proxy(worker.port) as proxy:
            proxy.delay(200, 50)
            start = time.monotonic()
            render = Render(
                *scene,
                "--threads",
                "0",
                "--worker",
                f"127.0.0.1:{proxy.port}",
                environment=DEFAULTS,
            )
            if every_s:
                proxy.reset_every(every_s)
            try:
                render.end(args.network_timeout_s)
            finally:
                render.kill()
                if every_s:
                    proxy.calm()
            direct = Render(
                *scene, "--threads", "0", "--worker", worker.address, environment=DEFAULTS
            ).end()
            out.update(
                {
                    f"{name}_s": render.wall_s,
                    f"{name}_without_s": direct.wall_s,
                    f"{name}_wrong": int(render.bytes != wanted(scene)),
                    f"{name}_lost": render.farm["lost"],
                    f"{name}_done_s": time.monotonic() - start,
                }
            )
            if every_s:
                out["resets"] = proxy.resets
        worker.kill()
    return out


MISSING = {"loss": networks_missing, "latency": proxy_missing}
ROWS = {"loss": loss, "latency": latency}

"""Rows of the fault bench: what grows with time."""

import random
import statistics
import time

from farming import Render, Worker, of, path_scene, wanted
from observe import quantile

_KILL_EVERY_S = 30


def soak(args):
    """Daemons work for one picture after the other; one of them is killed every 30 s, and started again. The two others: do they grow?"""
    numbers = random.Random(args.seed)
    scenes = [path_scene(16), path_scene(4, size="640x360", tile=32)]
    for scene in scenes:
        wanted(scene)
    crew = [Worker(), Worker(), Worker()]
    start = time.monotonic()
    next_kill, kills, pictures, wrong, lost = start + _KILL_EVERY_S, 0, 0, 0, 0
    samples = []  # when, of whom, resident KiB, descriptors
    while time.monotonic() - start < args.soak_s:
        scene = scenes[pictures % len(scenes)]
        render = Render(*scene, *of(crew))
        due = next_kill if next_kill > time.monotonic() else time.monotonic() + numbers.uniform(0.2, 1)
        while render.has_ended(0.2) is None:
            samples += [(time.monotonic() - start, w.name, *w.status()) for w in crew[:2]]
            if next_kill <= due <= time.monotonic():
                crew[2].kill()
                crew[2] = Worker(port=crew[2].port)
                kills, next_kill = kills + 1, next_kill + _KILL_EVERY_S
        render.end()
        pictures, wrong, lost = pictures + 1, wrong + (render.bytes != wanted(scene)), lost + render.farm["lost"]
    out = {"seconds": time.monotonic() - start, "pictures": pictures, "kills": kills, "lost": lost, "wrong": wrong}
    growth, more = [], []
    for worker in crew[:2]:
        own = [s for s in samples if s[1] == worker.name]
        first, last = ([s for s in own if begin <= s[0] / args.soak_s < end] for begin, end in ((0.05, 0.35), (0.67, 2)))
        growth.append(quantile([s[2] for s in last], 0.5) / quantile([s[2] for s in first], 0.5))
        more.append(quantile([s[3] for s in last], 0.5) - quantile([s[3] for s in first], 0.5))
        out["rss_mib"] = quantile([s[2] for s in last], 0.5) / 1024
        worker.kill()
    crew[2].kill()
    out["growth"], out["more_descriptors"] = max(growth), max(more)
    return out


def tasks(args):
    """Very many small tiles through one daemon: its memory after a fifth of them, and in the end."""
    edge = int((args.tasks ** 0.5) + 0.999) * 16
    scene = path_scene(1, size=f"{edge}x{edge}")
    worker = Worker()
    # What it keeps for any picture of this size is there after the first.
    Render(*path_scene(1), *of([worker])).end()
    render = Render(*scene, *of([worker]), log="debug")
    def resident_mib(answers):
        render.watch.saw_times("answer: ", answers, 600)
        return statistics.median(worker.status()[0] for _ in range(5)) / 1024

    fifth_mib, end_mib = resident_mib(args.tasks // 5), resident_mib(args.tasks)
    render.end()
    out = {"tiles": render.told["tiles"], "fifth_mib": fifth_mib, "end_mib": end_mib, "growth_mib": end_mib - fifth_mib, "wrong": int(render.bytes != wanted(scene))}
    worker.kill()
    return out


MISSING = {}
ROWS = {"soak": soak, "tasks": tasks}

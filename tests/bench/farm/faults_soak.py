"""Rows of the fault bench: what grows with time."""

import random
import statistics
import time

from farming import Render, Worker, of, path_scene, wanted

_KILL_EVERY_S = 30
_WARM_UP = 40  # pictures


def _warm_up(workers):
    """Allocators and pools take what they need for good."""
    scene = path_scene(1, size="640x360", tile=32)
    for _ in range(_WARM_UP):
        Render(*scene, *of(workers)).end()


def soak(args):
    """Daemons work for one picture after the other; one of them is killed every 30 s and restarted.

    Does the memory of the two others grow? One has the usual limit, the other one so low that its
    caches are full from the start.
    """
    numbers = random.Random(args.seed)
    scenes = [path_scene(16), path_scene(4, size="640x360", tile=32)]
    for scene in scenes:
        wanted(scene)
    workers = [Worker(), Worker(arguments=["--memory-mib", 64]), Worker()]
    _warm_up(workers)
    start = time.monotonic()
    next_kill = start + _KILL_EVERY_S
    kills = 0
    pictures = 0
    wrong = 0
    lost = 0
    samples = {w.name: [] for w in workers[:2]}  # when, resident KiB, descriptors
    while time.monotonic() - start < args.soak_s:
        scene = scenes[pictures % len(scenes)]
        render = Render(*scene, *of(workers))
        if time.monotonic() > next_kill:
            render.has_ended(numbers.uniform(0.5, 1.5))
            workers[2].kill()
            workers[2] = Worker(port=workers[2].port)
            kills += 1
            next_kill += _KILL_EVERY_S
        while render.has_ended(0.2) is None:
            for worker in workers[:2]:
                samples[worker.name].append((time.monotonic() - start, *worker.status()))
        render.end()
        pictures += 1
        wrong += render.bytes != wanted(scene)
        lost += render.farm["lost"]
    end_s = time.monotonic() - start
    out = {
        "seconds": end_s,
        "pictures": pictures,
        "kills": kills,
        "lost": lost,
        "wrong": wrong,
        "more_descriptors": 0,
    }
    for name, worker in zip(("", "small_"), workers):
        first, last = (
            [s for s in samples[worker.name] if begin <= s[0] / end_s <= end]
            for begin, end in ((0, 1 / 3), (2 / 3, 1))
        )
        (first_kib, first_files), (last_kib, last_files) = (
            [statistics.median(s[i] for s in third) for i in (1, 2)] for third in (first, last)
        )
        out[f"{name}rss_mib"] = last_kib / 1024
        out[f"{name}growth"] = last_kib / first_kib
        out["more_descriptors"] = max(out["more_descriptors"], last_files - first_files)
    for worker in workers:
        worker.kill()
    return out


def tasks(args):
    """Very many small tiles through one daemon: its memory after a fifth, and at the end."""
    edge = int((args.tasks**0.5) + 0.999) * 16
    scene = path_scene(1, size=f"{edge}x{edge}")
    worker = Worker()
    # What it keeps for any picture of this size is there after the first.
    Render(*path_scene(1), *of([worker])).end()
    render = Render(*scene, *of([worker]), log="debug")

    def resident_mib(answers):
        render.watch.saw_times("answer: ", answers, 600)
        return statistics.median(worker.status()[0] for _ in range(5)) / 1024

    fifth_mib = resident_mib(args.tasks // 5)
    end_mib = resident_mib(args.tasks)
    render.end()
    out = {
        "tiles": render.results["tiles"],
        "fifth_mib": fifth_mib,
        "end_mib": end_mib,
        "growth_mib": end_mib - fifth_mib,
        "wrong": int(render.bytes != wanted(scene)),
    }
    worker.kill()
    return out


MISSING = {}
ROWS = {"soak": soak, "tasks": tasks}

#!/usr/bin/env python3
"""kill -9 of some of the workers at random times, repeatedly: the picture stays the same.

Prints the cost as one line of JSON.

Each worker has a share of a core, so that its speed does not depend on how many others are alive.
The ideal follows from pictures without kills: each worker prepares (boxes, tables) and works at its
speed until it is killed, no work is lost, the rest is divided among the remaining workers, and the
coordinator writes the picture. `allowance`: 1 tile and 1 s.
"""

import argparse
import os
import random
import statistics
import time
from typing import NamedTuple

from farming import Render, Worker, of, path_scene, print_figures, shares_missing, wanted
from ideal import ideal_s

SAMPLES = 16
SHARE = 0.25  # of a core: a small share, so that other work of the machine matters less
_BASE_EVERY = 10  # what else the machine does changes


class Undisturbed(NamedTuple):
    """Of a picture without kills, seconds."""

    ready: float  # from the first lease to a worker's first answer, mean
    working: float  # from there to the last answer of all
    end: float  # from there to the end of the coordinator


def undisturbed(scene, share, workers):
    members = [Worker(share) for _ in range(workers)]
    render = Render(*scene, *of(members), log="debug").end()
    for worker in members:
        worker.kill()
    events = render.watch.events()
    answers = {
        w.name: [e.when for e in events if e.kind == "answer" and e.worker == w.name]
        for w in members
    }
    start = events[0].when
    ready = statistics.mean(a[0] for a in answers.values())
    last = max(a[-1] for a in answers.values())
    return Undisturbed(ready - start, last - ready, render.start + render.wall_s - last)


def one_run(numbers, scene, share, workers, most_s):
    """@param most_s all kills happen within that time

    @return the render, times of the kills since the first lease, wall time since then
    """
    members = [Worker(share) for _ in range(workers)]
    victims = numbers.sample(members, numbers.randint(1, workers - 1))
    plan = sorted(
        ((numbers.uniform(0.1, most_s), victim) for victim in victims), key=lambda one: one[0]
    )
    render = Render(*scene, *of(members), log="debug")
    start = render.watch.saw("lease: ", 60)[0]
    killed_at_s = []
    for at, victim in plan:
        if render.has_ended(max(0.0, start + at - time.monotonic())) is not None:
            break
        killed_at_s.append(time.monotonic() - start)
        victim.kill()
    render.end()
    wall_s = time.monotonic() - start
    for worker in members:
        worker.kill()
    return render, killed_at_s, wall_s


def measure(runs, workers, seed):
    numbers = random.Random(seed)
    scene = path_scene(SAMPLES)
    share = None if shares_missing() else SHARE
    most_at_once = workers if share else min(workers, os.cpu_count())
    base = []
    over = []
    wrong = 0
    lost = 0
    kills = 0
    for i in range(runs):
        if i % _BASE_EVERY == 0:
            base.append(undisturbed(scene, share, workers))
            ready_s, working_s, end_s = (statistics.median(values) for values in zip(*base))
        render, killed_at_s, wall_s = one_run(
            numbers, scene, share, workers, ready_s + 0.9 * working_s
        )
        over.append(
            wall_s
            - end_s
            - ideal_s(working_s * most_at_once, ready_s, workers, killed_at_s, most_at_once)
        )
        wrong += render.bytes != wanted(scene)
        kills += len(killed_at_s)
        lost += render.farm["lost"]
    tile_s = working_s * most_at_once / render.results["tiles"]
    return {
        "runs": runs,
        "seed": seed,
        "wrong": wrong,
        "kills": kills,
        "lost": lost,
        "ready_s": ready_s,
        "working_s": working_s,
        "end_s": end_s,
        "share": share or 0,
        "tile_s": tile_s,
        "over_median_s": statistics.median(over),
        "over_most_s": max(over),
        "over_allowance": sum(o > 1 + tile_s for o in over),
    }


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--runs", type=int, default=50)
    parser.add_argument("--workers", type=int, default=3)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    print_figures(measure(args.runs, args.workers, args.seed))


if __name__ == "__main__":
    main()

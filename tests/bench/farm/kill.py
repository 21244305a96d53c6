#!/usr/bin/env python3
"""kill -9 of some of the workers at random times, again and again: the picture stays the same, and what it costs is told. One line of JSON."""

import argparse
import random
import statistics
import threading

from farming import Render, Worker, invented_survey, tell


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--runs", type=int, default=50)
    parser.add_argument("--workers", type=int, default=3)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    numbers = random.Random(args.seed)
    scene = [invented_survey(), "--size", "320x180", "--tile", "16", "--integrator", "path", "--samples", "16", "--bounces", "4"]
    wanted = Render(*scene, "--threads", "1").end()
    one_core_s = wanted.tracing_s
    wrong, killed, over = 0, 0, []
    for _ in range(args.runs):
        workers = [Worker() for _ in range(args.workers)]
        victims = numbers.sample(workers, numbers.randint(1, args.workers - 1))
        timers = [threading.Timer(numbers.uniform(0.1, one_core_s / 2), v.kill) for v in victims]
        render = Render(*scene, "--threads", "0", *[a for w in workers for a in ("--worker", w.address)])
        for t in timers:
            t.start()
        render.end()
        for t in timers:
            t.cancel()
            t.join()
        wrong += render.bytes != wanted.bytes
        killed += render.told["farm"]["lost"]
        # All run on two cores: whoever is left can use them up to one each.
        ideal = one_core_s / max(min(args.workers - len(victims), 2), 1)
        over.append(render.tracing_s - ideal)
        for w in workers:
            w.kill()
    tell({"runs": args.runs, "wrong": wrong, "lost": killed, "one_core_s": one_core_s, "over_median_s": statistics.median(over), "over_most_s": max(over)})


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""The same picture by green threads, threads and socket workers.

Cold and warm, and by workers with a fixed share of a core each, compared with one of those. Prints
one line of JSON.
"""

import argparse
import statistics

from farming import Render, Worker, print_figures, synthetic_survey

_ONE_THREAD = ("--threads", "1", "--quality-coarse-step", "1")


def scene_of(samples):
    """@return the inputs and flags of a render whose work is in proportion to `samples`"""
    return [
        synthetic_survey(),
        *("--size", "640x360", "--tile", "32", "--integrator", "path"),
        *("--samples", samples, "--bounces", "4", "--processing-memory-mib", "512"),
    ]


def by_workers(workers):
    """@return flags of a render by these workers alone"""
    return ["--threads", "0", *(a for w in workers for a in ("--worker", w.address))]


class Scale:
    """The measurements: `figures` by name, and the `pictures`, which must all be the same."""

    def __init__(self, runs):
        self.runs = runs
        self.figures = {}
        self.pictures = set()

    def render(self, samples, *flags):
        """@return seconds of tracing"""
        done = Render(*scene_of(samples), *flags).end()
        if samples == 64:
            self.pictures.add(done.bytes)
        return done.tracing_s

    def times(self, name, *flags):
        self.figures[name] = statistics.median(self.render(64, *flags) for _ in range(self.runs))

    def loopback(self):
        """Two workers on this machine compared with two threads."""
        workers = [Worker(), Worker()]
        there = by_workers(workers)
        self.figures["workers_2_cold_s"] = self.render(64, *there)
        local = []
        far = []
        # In turns, so that other load of the machine affects both alike.
        for _ in range(max(self.runs, 3)):
            local.append(self.render(64, "--threads", "2", "--quality-coarse-step", "1"))
            far.append(self.render(64, *there))
        self.figures["threads_2_s"] = statistics.median(local)
        self.figures["workers_2_s"] = statistics.median(far)
        efficiency = statistics.median(a / b for a, b in zip(local, far))
        self.figures["loopback_efficiency"] = efficiency
        for worker in workers:
            worker.kill()

    def shared(self, count, share):
        """Workers with a fixed share of a core each.

        @return work per worker and second, in units of the machine's speed at that time
        """
        workers = [Worker(share) for _ in range(count)]
        took = []
        speeds = []
        for run in range(1 + (self.runs if count > 1 else min(self.runs, 3))):
            # The speed of the machine varies: before each picture a small one on one thread
            # measures it.
            now = self.render(8, *_ONE_THREAD)
            far = self.render(64, *by_workers(workers))
            if run > 0:  # boxes have been sent
                took.append(far)
                speeds.append(now / (count * far))
        self.figures[f"shared_{count}_s"] = statistics.median(took)
        for worker in workers:
            worker.kill()
        return statistics.median(speeds)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--share", type=float, default=0.14)
    parser.add_argument("--counts", default="1,2,4,6,12")
    args = parser.parse_args()
    scale = Scale(args.runs)
    scale.times("green_s", "--green")
    scale.times("threads_1_s", *_ONE_THREAD)
    scale.loopback()
    base = None
    for count in (int(c) for c in args.counts.split(",")):
        speed = scale.shared(count, args.share)
        base = base or speed
        scale.figures[f"shared_{count}_efficiency"] = speed / base
    scale.figures["pictures"] = len(scale.pictures)
    print_figures(scale.figures)


if __name__ == "__main__":
    main()

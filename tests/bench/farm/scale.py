#!/usr/bin/env python3
"""The same picture by green, threads and socket workers, cold and warm, and by workers with a fixed share of a core each (against one
of those). One line of JSON."""

import argparse
import statistics

from farming import Render, Worker, invented_survey, tell


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--share", type=float, default=0.14)
    parser.add_argument("--counts", default="1,2,4,6,12")
    args = parser.parse_args()

    def of_samples(samples):
        return [
            invented_survey(),
            "--size",
            "640x360",
            "--tile",
            "32",
            "--integrator",
            "path",
            "--samples",
            samples,
            "--bounces",
            "4",
            "--processing-memory-mib",
            "512",
        ]

    scene, small = of_samples(64), of_samples(8)
    figures, pictures = {}, set()

    def times(name, *arguments):
        runs = [Render(*scene, *arguments).end() for _ in range(args.runs)]
        pictures.update(r.bytes for r in runs)
        figures[name] = statistics.median(r.tracing_s for r in runs)
        return figures[name]

    times("green_s", "--green")
    times("threads_1_s", "--threads", "1", "--quality-coarse-step", "1")
    # Turn by turn, so that what else the machine does hits both alike.
    workers = [Worker(), Worker()]
    there = [a for w in workers for a in ("--worker", w.address)]
    cold = Render(*scene, "--threads", "0", *there).end()
    pictures.add(cold.bytes)
    figures["workers_2_cold_s"] = cold.tracing_s
    local, far = [], []
    for _ in range(max(args.runs, 3)):
        a, b = (
            Render(*scene, "--threads", "2", "--quality-coarse-step", "1").end(),
            Render(*scene, "--threads", "0", *there).end(),
        )
        pictures.update((a.bytes, b.bytes))
        local.append(a.tracing_s), far.append(b.tracing_s)
    figures["threads_2_s"], figures["workers_2_s"] = (
        statistics.median(local),
        statistics.median(far),
    )
    figures["loopback_efficiency"] = statistics.median(l / f for l, f in zip(local, far))
    for w in workers:
        w.kill()

    # The machine is not equally fast all the time: before each picture a small one on one thread says how fast it is now.
    base = None
    for count in (int(c) for c in args.counts.split(",")):
        workers = [Worker(args.share) for _ in range(count)]
        there = [a for w in workers for a in ("--worker", w.address)]
        took, speeds = [], []
        for run in range(1 + (args.runs if count > 1 else min(args.runs, 3))):
            now = Render(*small, "--threads", "1", "--quality-coarse-step", "1").end().tracing_s
            far = Render(*scene, "--threads", "0", *there).end()
            pictures.add(far.bytes)
            if run > 0:  # boxes have been sent
                took.append(far.tracing_s), speeds.append(now / (count * far.tracing_s))
        figures[f"shared_{count}_s"] = statistics.median(took)
        base = base or statistics.median(speeds)
        figures[f"shared_{count}_efficiency"] = statistics.median(speeds) / base
        for w in workers:
            w.kill()
    figures["pictures"] = len(pictures)
    tell(figures)


if __name__ == "__main__":
    main()

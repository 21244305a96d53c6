#!/usr/bin/env python3
"""Breaks a farm in a different way in each row, and measures what that costs.

Prints one line of JSON: figures as ROW_FIGURE; `skipped` and `failed`, with the reason for each row
that cannot run here or did not finish.
"""

import argparse
import sys
import time
import traceback

import faults_coordinator
import faults_network
import faults_soak
import faults_strangers
import faults_workers
import kill
from farming import kill_all, print_figures

MODULES = (faults_workers, faults_coordinator, faults_network, faults_strangers, faults_soak)
ROWS = {"kill": lambda args: kill.measure(args.kill_runs, 3, args.seed)}
MISSING = {}
for module in MODULES:
    ROWS.update(module.ROWS)
    MISSING.update(module.MISSING)


def arguments():
    parser = argparse.ArgumentParser()
    parser.add_argument("--rows", default=",".join(ROWS), help="of: " + ", ".join(ROWS))
    parser.add_argument("--seed", type=int, default=1, help="of the times at which things happen")
    parser.add_argument("--kill-runs", type=int, default=50)
    parser.add_argument(
        "--lost-leases",
        type=int,
        default=120,
        help="bands that victims of the row lease had, at least",
    )
    parser.add_argument(
        "--silent-samples",
        type=int,
        default=30,
        help=(
            "work of a picture in which a worker falls silent; "
            "twice that where its thread hangs, three times with the default times"
        ),
    )
    parser.add_argument(
        "--silent-defaults",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="with the default times, too",
    )
    parser.add_argument("--late-answers", type=int, default=100)
    parser.add_argument("--slow-runs", type=int, default=3)
    parser.add_argument("--term-runs", type=int, default=6)
    parser.add_argument("--resume-kills", type=int, default=20)
    parser.add_argument(
        "--network-timeout-s",
        type=float,
        default=600,
        help="for a picture through a slow network that is cut off",
    )
    parser.add_argument("--idle", type=int, default=5000, help="connections that send nothing")
    parser.add_argument("--flood-s", type=float, default=5)
    parser.add_argument("--soak-s", type=float, default=120)
    parser.add_argument("--tasks", type=int, default=10_000, help="tiles through one daemon")
    args = parser.parse_args()
    args.rows = args.rows.split(",")
    for row in args.rows:
        if row not in ROWS:
            parser.error(f"--rows: '{row}'; allowed: {', '.join(ROWS)}")
    return args


def main():
    args = arguments()
    figures = {}
    skipped = {}
    failed = {}
    for row in args.rows:
        reason = MISSING[row]() if row in MISSING else ""
        if reason:
            skipped[row] = reason
            print(f"{row}: skipped: {reason}", file=sys.stderr, flush=True)
            continue
        start = time.monotonic()
        try:
            figures_of_row = ROWS[row](args)
            figures.update({f"{row}_{name}": value for name, value in figures_of_row.items()})
        except Exception as e:  # the other rows still run
            failed[row] = figures_of_row = f"{type(e).__name__}: {e}"
            traceback.print_exc()
        kill_all()
        print(
            f"{row}: {time.monotonic() - start:.0f} s: {figures_of_row}",
            file=sys.stderr,
            flush=True,
        )
    print_figures({**figures, "skipped": skipped, "failed": failed})


if __name__ == "__main__":
    main()

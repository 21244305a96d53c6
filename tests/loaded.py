#!/usr/bin/env python3
"""Runs tests repeatedly on a busy machine, and lists those that fail by chance.

    ./terravox test --loaded 5 e2e_farm_test net_test
        five times each, with four busy processes and two that write
    tests/loaded.py --times 20 'e2e_http.*'
        names are regular expressions; without any: the default tier
    tests/loaded.py --times 2 --one-core
        at the lowest priority, on one core
    tests/loaded.py --no-load --jobs 4 net_test e2e_farm_test
        four at a time, without a load of its own

A test that depends on a clock, on luck or on the speed of another process fails here sooner or
later. The output of each round with a failed test is kept in build/logs/loaded/. The exit code is 1
when a run failed.
"""

import argparse
import contextlib
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
LOGS = ROOT / "build" / "logs" / "loaded"
BUSY = 4
WRITING = 2
# A line of ctest: "  3/80 Test #12: net_test ........***Failed   1.23 sec".
RESULT = re.compile(r"\s*\d+/\d+ Test +#\d+: (\S+) \.*\s*(.*?) +([\d.]+) sec")
WRITER = (
    "import os, tempfile\nwith tempfile.TemporaryFile() as f:\n while True:\n  "
    "f.write(bytes(1 << 20)); f.flush(); os.fsync(f.fileno()); f.seek(0)"
)


def load_commands():
    """stress-ng where there is one, else as many processes of Python's."""
    if shutil.which("stress-ng"):
        return [["stress-ng", "--quiet", "--cpu", str(BUSY), "--io", str(WRITING)]]
    return [[sys.executable, "-c", "while True: pass"]] * BUSY + [
        [sys.executable, "-c", WRITER]
    ] * WRITING


@contextlib.contextmanager
def load(wanted):
    processes = []
    try:
        for command in load_commands() if wanted else []:
            processes.append(
                subprocess.Popen(command, start_new_session=True, stdout=subprocess.DEVNULL)
            )
        yield
    finally:
        for process in processes:
            os.killpg(process.pid, signal.SIGTERM)
        for process in processes:
            process.wait()


def ctest(folder, *arguments):
    return ["ctest", "--test-dir", str(folder), *arguments]


def names_of(folder, patterns):
    """@return the tests that a pattern matches as a whole

    @throws SystemExit where a pattern matches none
    """
    listing = json.loads(
        subprocess.run(
            ctest(folder, "--show-only=json-v1"), capture_output=True, text=True, check=True
        ).stdout
    )
    names = {}
    for test in listing["tests"]:
        properties = {p["name"]: p["value"] for p in test.get("properties", [])}
        names[test["name"]] = "default" in properties.get("LABELS", [])
    if not patterns:
        return [name for name, is_default in names.items() if is_default]
    out = []
    for pattern in patterns:
        found = [name for name in names if re.fullmatch(pattern, name)]
        if not found:
            sys.exit(
                f"loaded.py: no test is called '{pattern}'; "
                f"`ctest --test-dir {folder} -N` lists them"
            )
        out += [name for name in found if name not in out]
    return out


def run_round(folder, names, round_number, prefix, jobs):
    """Runs each test once, `jobs` at a time, in random order.

    Yields name, seconds, and whether it passed.
    """
    pattern = "^(" + "|".join(re.escape(name) for name in names) + ")$"
    command = ctest(
        folder,
        "--parallel",
        str(jobs),
        "--schedule-random",
        "--output-on-failure",
        "--tests-regex",
        pattern,
    )
    # Written as it comes: a long round can be looked into while it runs.
    LOGS.mkdir(parents=True, exist_ok=True)
    log = LOGS / f"round-{round_number}.log"
    all_passed = True
    process = subprocess.Popen(
        [*prefix, *command],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
    )
    with process, log.open("w", encoding="utf-8") as out:
        for line in process.stdout:
            out.write(line)
            out.flush()
            found = RESULT.match(line)
            if found:
                passed = found[2] == "Passed" or found[2].endswith("Skipped")
                all_passed = all_passed and passed
                yield found[1], float(found[3]), passed
    if all_passed and process.returncode == 0:
        log.unlink()


def table(runs):
    lines = [f"{'test':32} {'runs':>5} {'failed':>7} {'slowest_s':>10}"]
    for name, results in runs.items():
        failed = sum(not passed for _, passed in results)
        lines.append(
            f"{name:32} {len(results):5} {failed:7} {max(seconds for seconds, _ in results):10.1f}"
        )
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*", help="names of CTest entries, as regular expressions")
    parser.add_argument("--times", type=int, default=5, help="runs of each test (default: 5)")
    parser.add_argument("--jobs", type=int, default=1, help="tests at a time (default: 1)")
    parser.add_argument(
        "--build",
        type=pathlib.Path,
        default=ROOT / "build" / "release",
        help="folder that was built (default: build/release)",
    )
    parser.add_argument(
        "--one-core", action="store_true", help="tests have one core and the lowest priority"
    )
    parser.add_argument(
        "--no-load", action="store_true", help="start no load: the machine has some"
    )
    args = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    prefix = ["taskset", "--cpu-list", "0", "nice", "-n", "19"] if args.one_core else []
    runs = {}
    with load(not args.no_load):
        names = names_of(args.build, args.names)
        # Round by round: what fails seldom fails in some of them, whenever this is stopped.
        try:
            for round_number in range(1, args.times + 1):
                for name, seconds, passed in run_round(
                    args.build, names, round_number, prefix, args.jobs
                ):
                    runs.setdefault(name, []).append((seconds, passed))
                    print(
                        f"{round_number}/{args.times} {name}: "
                        f"{'passed' if passed else 'FAILED'}, {seconds:.1f} s",
                        flush=True,
                    )
        except KeyboardInterrupt:
            print("stopped", file=sys.stderr)
    if not runs:
        return 130
    print(table(runs))
    return 0 if all(passed for results in runs.values() for _, passed in results) else 1


if __name__ == "__main__":
    sys.exit(main())

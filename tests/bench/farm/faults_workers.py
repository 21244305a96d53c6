"""Rows of the fault bench: workers that are killed, stopped, cut off, hung, slow, or terminated."""

import contextlib
import os
import random
import signal
import time

from farming import DEFAULTS, ENVIRONMENT, Render, Worker, of, path_scene, shares_missing, wanted
from halt import Halted, busiest_thread
from networks import Namespace, networks_missing
from observe import fates, held, lease_delays_s, quantile
from pump import Pump

_MOST_SILENT = 2
_SHARE = 0.6  # of a core: two such workers and the coordinator fit on two


def _kills(args, scene, wanted_bands):
    """Renders pictures and kills workers until so many bands were lost. @return figures"""
    numbers = random.Random(args.seed)
    bands_s = []
    first_s = []
    reported_s = []
    wrong = 0
    pictures = 0
    while len(bands_s) < wanted_bands:
        workers = [Worker(environment=DEFAULTS) for _ in range(3)]
        render = Render(*scene, *of(workers), log="debug", environment=DEFAULTS)
        start = render.watch.saw("lease: ", 60)[0]
        killed = []
        while render.has_ended(numbers.uniform(0.7, 1.5)) is None and time.monotonic() - start < 40:
            victim = numbers.choice(workers)
            if not held(render.watch.events(), victim.name, time.monotonic()):
                continue
            at = time.monotonic()
            victim.kill()
            killed.append((victim.name, at))
            workers.remove(victim)
            workers.append(Worker(port=victim.port, environment=DEFAULTS))
        render.end()
        pictures += 1
        wrong += render.bytes != wanted(scene)
        for worker in workers:
            worker.kill()
        events = render.watch.events()
        for name, at in killed:
            delays_s = lease_delays_s(events, name, at)
            bands_s += delays_s
            first_s += [min(delays_s)] if delays_s else []
            lost = render.watch.look(f"worker {name} at .* is lost", after=at)
            if lost or delays_s:  # else its answers were on the way, and the picture was finished
                reported_s.append(lost[0] - at if lost else float("inf"))
    return {
        "pictures": pictures,
        "wrong": wrong,
        "kills": len(reported_s),
        "bands": len(bands_s),
        "told_most_s": max(reported_s),
        "first_p99_s": quantile(first_s, 0.99),
        "median_s": quantile(bands_s, 0.5),
        "p99_s": quantile(bands_s, 0.99),
        "most_s": max(bands_s),
    }


def lease(args):
    """kill -9 to the new lease of each band of the victim: the kernel closes its connection.

    Measured with tiles of about 10 ms and, for comparison, with heavy ones, which wait until a
    worker has room for them.
    """
    heavy = _kills(args, path_scene(400), args.lost_leases // 4)
    return {
        **_kills(args, path_scene(16, size="1280x720"), args.lost_leases),
        **{f"heavy_{name}": value for name, value in heavy.items()},
    }


def silent_one(environment, samples, silence, harm, mend, victim, others):
    """A worker falls silent with bands of a picture, and comes back. @return figures"""
    scene = path_scene(samples, size="1280x720")
    render = Render(*scene, *of([victim, *others]), log="debug", environment=environment)
    render.watch.saw_times(f"answer: .* of {victim.name}$", 5, 120)
    at = time.monotonic()
    harm()
    # Waits until every band that it had is leased to another worker, then a while longer, so that
    # it returns to a picture in progress.
    end = at + 3 * silence
    while True:
        delays_s = lease_delays_s(render.watch.events(), victim.name, at)
        if (
            all(d < float("inf") for d in delays_s)
            or time.monotonic() > end
            or render.has_ended(0) is not None
        ):
            break
        time.sleep(0.1)
    render.has_ended(1)
    back = time.monotonic()
    mend()
    answer = None
    with contextlib.suppress(RuntimeError):  # a missing answer is a figure of the row below
        answer = render.watch.saw(f"answer: .* of {victim.name}$", 120, after=back)[0] - back
    render.end()
    # All lines of the log have been read by now.
    delays_s = lease_delays_s(render.watch.events(), victim.name, at)
    figures = {
        "bands": len(delays_s),
        "most_s": max(delays_s, default=0.0),
        "back_s": answer if answer is not None else -1,
        "wrong": int(render.bytes != wanted(scene)),
        "expelled": render.farm["expelled"],
        "late": render.farm["late_answers"],
    }
    again = path_scene(16)
    after = Render(*again, *of([victim, *others]), environment=environment).end()
    figures["next_wrong"] = int(after.bytes != wanted(again))
    return figures


def _silent(args, make):
    out = {}
    for name, environment, samples, silence in (
        ("tests", ENVIRONMENT, args.silent_samples, 5),
        ("defaults", DEFAULTS, 3 * args.silent_samples, 15),
    ):
        if name == "defaults" and not args.silent_defaults:
            continue
        victim, others, harm, mend = make(environment)
        try:
            out.update(
                {
                    f"{name}_{key}": value
                    for key, value in silent_one(
                        environment, samples, silence, harm, mend, victim, others
                    ).items()
                }
            )
        finally:
            for worker in (victim, *others):
                worker.kill()
    return out


def stopped(args):
    """SIGSTOP: its connection stays open and silent."""

    def make(environment):
        victim = Worker(environment=environment)
        return (
            victim,
            [Worker(environment=environment)],
            lambda: os.kill(victim.pid, signal.SIGSTOP),
            lambda: os.kill(victim.pid, signal.SIGCONT),
        )

    return _silent(args, make)


def partitioned(args):
    """Packets vanish both ways: neither end is notified."""
    spaces = []

    def make(environment):
        space = Namespace()
        spaces.append(space)
        victim = Worker(host=space.there, within=space, environment=environment)
        return victim, [Worker(environment=environment)], space.cut_off, space.heal

    try:
        return _silent(args, make)
    finally:
        for space in spaces:
            space.heal()
            space.remove()


def _hung_after(args, answers):
    scene = path_scene(2 * args.silent_samples, size="1280x720")
    victim = Worker()
    other = Worker()
    render = Render(*scene, *of([victim, other]), log="debug")
    render.watch.saw_times(f"answer: .* of {victim.name}$", answers, 120)
    thread = busiest_thread(victim.pid)
    before = len(render.watch.events())
    with Halted(thread):
        at = time.monotonic()
        while (
            any(
                f.leased_s is None and f.answered_s is None
                for f in fates(render.watch.events(), victim.name, at)
            )
            and render.has_ended(0.1) is None
        ):
            if time.monotonic() - at > 60:
                break
        # Long enough to be given bands again, which it cannot trace either.
        render.has_ended(5)
        back = time.monotonic()
        silent = render.watch.look("silent") is not None
        lost = render.watch.look("is lost") is not None
    if silent:
        for process in (render, victim, other):
            process.kill()
        return None
    again_s = render.watch.saw(f"answer: .* of {victim.name}$", 60, after=back)[0] - back
    render.end()
    events = render.watch.events()
    delays_s = lease_delays_s(events, victim.name, at)
    more = sum(
        e.kind == "lease" and e.worker == victim.name and at < e.when < back
        for e in events[before:]
    )
    for worker in (victim, other):
        worker.kill()
    return {
        "bands": len(delays_s),
        "most_s": max(delays_s),
        "more": more,
        "halted_s": back - at,
        "given_up": int(lost),
        "back_s": again_s,
        "wrong": int(render.bytes != wanted(scene)),
    }


def hung(args):
    """One tracing thread stops, all others of the worker continue, pings are answered.

    A lease has a deadline. The same right after a start, when boxes are on their way and speeds are
    not known well.
    """
    cold = _hung(args, 5)
    return {**_hung(args, 300), **{f"cold_{name}": value for name, value in cold.items()}}


def _hung(args, answers):
    """Calls _hung_after(), again when the thread was stopped inside a lock that other threads need.

    Such a worker falls silent, which another row measures.
    """
    for silent in range(_MOST_SILENT + 1):
        figures = _hung_after(args, answers)
        if figures is not None:
            return {**figures, "silent_instead": silent}
    raise RuntimeError(f"the worker's link was given up {_MOST_SILENT + 1} times")


def late(args):
    """Answers that come after other workers rendered the same bands are counted and ignored."""
    scene = path_scene(args.silent_samples, size="1280x720")
    answers = 0
    pictures = 0
    wrong = 0
    harmed = 0
    while answers < args.late_answers:
        victim = Worker()
        other = Worker()
        with Pump(victim.port) as pump:
            render = Render(
                *scene,
                "--threads",
                "0",
                "--worker",
                f"127.0.0.1:{pump.port}",
                "--worker",
                other.address,
                log="debug",
            )
            render.watch.saw_times(f"answer: .* of {victim.name}$", 5, 120)
            while render.has_ended(0) is None:
                at = time.monotonic()
                pump.hold_answers()
                # Longer than the deadline of a lease in tests, shorter than the timeout for
                # silence.
                render.has_ended(2.6)
                pump.go_on()
                try:
                    render.watch.saw(f"answer: .* of {victim.name}$", 30, after=at + 2.6)
                except RuntimeError:
                    break  # the picture has ended
                render.has_ended(0.3)
            render.end()
        answers += render.farm["late_answers"]
        wrong += render.bytes != wanted(scene)
        harmed += render.farm["expelled"] + render.farm["lost"]
        pictures += 1
        victim.kill()
        other.kill()
        if render.farm["late_answers"] == 0:
            raise RuntimeError("late: no answer of a whole picture was late")
    return {"pictures": pictures, "answers": answers, "wrong": wrong, "harmed": harmed}


def slow(args):
    """One worker of three, and one of two, has a tenth of the others' share of a core."""
    scene = path_scene(64)
    out = {"wrong": 0}
    for count in (3, 2):
        share = 0.5 if count == 3 else _SHARE
        fast = [Worker(share) for _ in range(count - 1)]
        snail = Worker(share / 10)
        without_s = []
        with_s = []
        # In turns, so that other load of the machine affects both alike; the first of each sends
        # the boxes.
        for i in range(args.slow_runs + 1):
            for times, workers in ((without_s, fast), (with_s, [*fast, snail])):
                render = Render(*scene, *of(workers)).end()
                out["wrong"] += render.bytes != wanted(scene)
                times += [render.tracing_s] if i > 0 else []
        for worker in (*fast, snail):
            worker.kill()
        out[f"of_{count}_without_s"] = quantile(without_s, 0.5)
        out[f"of_{count}_with_s"] = quantile(with_s, 0.5)
        out[f"of_{count}_ratio"] = quantile([w / o for w, o in zip(with_s, without_s)], 0.5)
    return out


def term(args):
    """SIGTERM of a worker: it finishes what it has begun, returns the rest, and exits."""
    numbers = random.Random(args.seed)
    scene = path_scene(50, size="640x360", tile=32)
    exits_s = []
    wrong = 0
    codes = 0
    given_back = 0
    finished = 0
    unaccounted = 0
    for _ in range(args.term_runs):
        victim = Worker()
        other = Worker()
        render = Render(*scene, *of([victim, other]), log="debug")
        # Tiles that waited for boxes are all begun at first.
        render.watch.saw_times(f"answer: .* of {victim.name}$", 15, 120)
        render.has_ended(numbers.uniform(0, 1.5))
        at = time.monotonic()
        victim.process.send_signal(signal.SIGTERM)
        code = victim.has_ended(30)
        exits_s.append(time.monotonic() - at)
        codes += code != 0
        render.end()
        for fate in fates(render.watch.events(), victim.name, at):
            given_back += fate.leased_s is not None and fate.answered_s is None
            finished += fate.answered_s is not None
            unaccounted += fate.leased_s is None and fate.answered_s is None
        wrong += render.bytes != wanted(scene)
        other.kill()
        victim.kill()
    return {
        "runs": args.term_runs,
        "exit_median_s": quantile(exits_s, 0.5),
        "exit_most_s": max(exits_s),
        "exit_codes": codes,
        "given_back": given_back,
        "finished": finished,
        "unaccounted": unaccounted,
        "wrong": wrong,
    }


MISSING = {"partition": networks_missing, "slow": shares_missing}
ROWS = {
    "lease": lease,
    "stop": stopped,
    "partition": partitioned,
    "hung": hung,
    "late": late,
    "slow": slow,
    "term": term,
}

"""Rows of the fault bench: coordinators that are killed and go on."""

import collections
import random

from farming import FOLDER, Render, Worker, of, path_scene, wanted
from resume_test import cells

_TILES = 20 * 12  # of path_scene()


def _leased(render):
    return len({e.band.tile for e in render.watch.events() if e.kind == "lease"})


def resume(args):
    """kill -9 of the coordinator at points spread over a run, each time with --resume.

    No tile that its checkpoint holds is leased again.
    """
    numbers = random.Random(args.seed)
    scene = path_scene(100)
    workers = [Worker(), Worker()]
    picture = FOLDER / "resumed.png"
    journal = picture.with_name(picture.name + ".tiles")
    twice = 0
    lost = 0
    again = 0
    no_progress = 0
    before = set()
    for kill in range(args.resume_kills):
        render = Render(*scene, *of(workers), "--resume", log="debug", picture=picture)
        # So many answers more, that all kills fall within the picture.
        most = (_TILES - len(before)) // (args.resume_kills - kill + 1)
        render.watch.saw_times("answer: ", max(1, numbers.randint(most // 4, most)), 120)
        render.kill()
        render.watch.join()
        kept = cells(journal) if journal.exists() else []
        twice += sum(times > 1 for times in collections.Counter(kept).values())
        lost += len(before - set(kept))
        again += max(0, _leased(render) - (_TILES - len(before)))
        no_progress += set(kept) == before
        before = set(kept)
    render = Render(*scene, *of(workers), "--resume", log="debug", picture=picture).end()
    again += max(0, _leased(render) - (_TILES - len(before)))
    for worker in workers:
        worker.kill()
    return {
        "kills": args.resume_kills,
        "kept": len(before),
        "resumed": render.results["tiles_resumed"],
        "made": render.results["tiles"],
        "no_progress": no_progress,
        "lost": lost,
        "again": again + abs(render.results["tiles_resumed"] - len(before)),
        "twice": twice,
        "wrong": int(render.bytes != wanted(scene)),
        "journal_left": int(journal.exists()),
    }


MISSING = {}
ROWS = {"resume": resume}

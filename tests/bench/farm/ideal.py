"""How long work takes at best when some of those who do it are lost."""


def ideal_s(work_s, prepare_s, workers, killed_at_s, most_at_once):
    """Until work that takes one worker `work_s`, when it is ready, is done by `workers` of which some are killed.
    @param prepare_s what each needs for itself before it begins @param most_at_once speed of all, in workers"""
    now, done = prepare_s, 0.0
    for at in sorted(killed_at_s):
        speed = min(workers, most_at_once)
        if done + speed * (at - now) >= work_s:
            break
        if at > now:
            done, now = done + speed * (at - now), at
        workers -= 1
    return now + (work_s - done) / min(workers, most_at_once)

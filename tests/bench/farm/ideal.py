"""The shortest possible time of work during which some of the workers are lost."""


def ideal_s(work_s, prepare_s, workers, killed_at_s, most_at_once):
    """@return seconds until `workers`, of which some are killed, have done work of `work_s`

    @param work_s       what the work takes one worker that is ready
    @param prepare_s    what each worker needs before it begins
    @param most_at_once speed of all, in workers
    """
    now = prepare_s
    done = 0.0
    for at in sorted(killed_at_s):
        speed = min(workers, most_at_once)
        if done + speed * (at - now) >= work_s:
            break
        if at > now:
            done += speed * (at - now)
            now = at
        workers -= 1
    return now + (work_s - done) / min(workers, most_at_once)

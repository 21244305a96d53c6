import PQueue from 'p-queue';

/**
 * Runs tasks, some at a time. The first failure stops the others, and is thrown only when none of
 * them runs any more: their files are about to be removed.
 * @return the results in the order of the tasks
 */
export async function runAll<T>(
  tasks: readonly ((signal: AbortSignal) => Promise<T>)[],
  concurrency: number,
  signal: AbortSignal,
): Promise<T[]> {
  signal.throwIfAborted();
  const stop = new AbortController();
  const both = AbortSignal.any([signal, stop.signal]);
  const queue = new PQueue({ concurrency });
  let failed = false;
  let reason: unknown;
  const results: T[] = [];
  tasks.forEach((task, index) => {
    void queue.add(async () => {
      if (both.aborted) return;
      try {
        results[index] = await task(both);
      } catch (error) {
        if (!failed) reason = error;
        failed = true;
        stop.abort();
      }
    });
  });
  await queue.onIdle();
  signal.throwIfAborted();
  if (failed) throw reason;
  return results;
}

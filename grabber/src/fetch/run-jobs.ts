import { setMaxListeners } from 'node:events';
import { mkdir } from 'node:fs/promises';
import { dirname, join } from 'node:path';
import PQueue from 'p-queue';
import type { Outcome, Tally } from '../progress/events.js';
import { kPlaces } from '../store/layout.js';
import { storing } from './disk-space.js';
import type { FetchJob, FetchRun } from './fetch-job.js';
import { fetchRecord } from './fetch-record.js';
import { NearBlocks } from './near-blocks.js';

const kSealsAtOnce = 2;

/** The queue of checks that all jobs of a run share. */
export function sealQueue(): PQueue {
  return new PQueue({ concurrency: kSealsAtOnce });
}

/** Files that wait for another try or for their check keep no place at the host; so more are under way than it serves. */
const kUnderWayPerRequest = 4;

/**
 * Works through all records of all jobs; sources run beside each other.
 * When the signal aborts, no further record starts, those under way are stopped, and the signal's reason is thrown
 * after the last of them has closed its files. Trouble that all files share (a full disk) stops the run the same way.
 */
export async function runJobs(jobs: readonly FetchJob[], run: FetchRun, signal: AbortSignal): Promise<Tally> {
  const tally: Tally = { verified: 0, converted: 0, fetched: 0, kept: 0, missing: 0, failed: 0 };
  const stop = new AbortController();
  const both = AbortSignal.any([signal, stop.signal]);
  // Every request and every wait listens, for as long as it lasts.
  setMaxListeners(0, both, signal);
  const done = (outcome: Outcome): void => {
    ++tally[outcome.state];
    run.events.outcome(outcome);
  };
  await Promise.all(jobs.map((job) => runJob(job, run, done, stop, both)));
  both.throwIfAborted();
  return tally;
}

async function runJob(
  job: FetchJob,
  run: FetchRun,
  done: (outcome: Outcome) => void,
  stop: AbortController,
  signal: AbortSignal,
): Promise<void> {
  const [first] = job.records;
  if (first === undefined) return;
  const queue = new PQueue({ concurrency: job.limits.max_concurrent * kUnderWayPerRequest });
  const clear = (): void => queue.clear();
  signal.addEventListener('abort', clear, { once: true });
  try {
    signal.throwIfAborted();
    for (const folder of new Set(job.records.map(({ key }) => dirname(join(run.root, kPlaces.unfinished(job.kind, key)))))) {
      await storing(folder, () => mkdir(folder, { recursive: true }));
    }
    const blocks = new NearBlocks(job.locate === undefined ? [] : job.table.list({ source: first.key.source, grid: first.key.grid }));
    for (const record of job.records) {
      void queue.add(async () => {
        try {
          signal.throwIfAborted();
          done(await fetchRecord(record, job, run, blocks, signal));
        } catch (error) {
          stop.abort(error);
        }
      });
    }
    await queue.onIdle();
  } catch (error) {
    stop.abort(error);
  } finally {
    signal.removeEventListener('abort', clear);
  }
}

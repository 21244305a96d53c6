import { setMaxListeners } from 'node:events';
import { mkdir } from 'node:fs/promises';
import { dirname, join } from 'node:path';
import PQueue from 'p-queue';
import type { Outcome, Tally } from '../progress/events.js';
import { kPlaces } from '../store/layout.js';
import { withStoreErrors } from './disk-space.js';
import type { FetchJob, FetchRun } from './fetch-job.js';
import { fetchRecord } from './fetch-record.js';
import { NearBlocks } from './near-blocks.js';

/**
 * Syncs that wait together share a commit of the file system's journal; more would occupy all four
 * worker threads of Node.js.
 */
const kMaxSyncs = 3;

/** The queue of slow work on the disk that all jobs of a run share. */
export function syncQueue(): PQueue {
  return new PQueue({ concurrency: kMaxSyncs });
}

/**
 * Files that wait for another try or for the disk do not occupy a slot of the host, so more files
 * are in progress than it serves at a time.
 */
const kFilesPerRequest = 4;

/**
 * Works through all records of all jobs; sources run concurrently. When the signal aborts, no
 * further record starts, those under way are stopped, and the signal's reason is thrown after the
 * last of them has closed its files. Trouble that all files share (a full disk) stops the run the
 * same way.
 */
export async function runJobs(
  jobs: readonly FetchJob[],
  run: FetchRun,
  signal: AbortSignal,
): Promise<Tally> {
  const tally: Tally = { verified: 0, converted: 0, fetched: 0, kept: 0, missing: 0, failed: 0 };
  const stop = new AbortController();
  const both = AbortSignal.any([signal, stop.signal]);
  // Every request and every wait adds a listener for as long as it lasts.
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
  try {
    signal.throwIfAborted();
    for (const folder of new Set(
      job.records.map(({ key }) => dirname(join(run.root, kPlaces.unfinished(job.kind, key)))),
    )) {
      await withStoreErrors(folder, () => mkdir(folder, { recursive: true }));
    }
    const blocks = new NearBlocks(
      job.locate === undefined
        ? []
        : job.table.list({ source: first.key.source, grid: first.key.grid }),
    );
    // All take from one iterator: a queue would hold a promise and more for each of a country's
    // squares.
    const records = job.records.values();
    const work = async (): Promise<void> => {
      for (const record of records) {
        signal.throwIfAborted();
        done(await fetchRecord(record, job, run, blocks, signal));
      }
    };
    const workers = Array.from({ length: job.limits.max_concurrent * kFilesPerRequest }, work);
    await Promise.all(workers.map((worker) => worker.catch((error: unknown) => stop.abort(error))));
  } catch (error) {
    stop.abort(error);
  }
}

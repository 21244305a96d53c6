import { setMaxListeners } from 'node:events';
import { mkdir } from 'node:fs/promises';
import { dirname, join } from 'node:path';
import PQueue from 'p-queue';
import type { StoreRecord, Catalogue, RecordTable, Verified } from '../model/store.js';
import type { FetchEvents, Outcome, Tally } from '../progress/reporter.js';
import type { Clock } from '../util/clock.js';
import { type DiskSpace, withStoreErrors } from './disk-space.js';
import type { HostQueues, HostLimits } from './host-queues.js';
import type { SourceClient } from './http-client.js';
import type { RetryPolicy } from './retry.js';
import { kPlaces } from '../store/layout.js';
import { fetchRecord } from './fetch-record.js';
import { NearBlocks } from './locate.js';

/** What was found in a whole file. */
export type Checked = {
  /** The extension that fits the content, without a dot, whatever the address says. */
  readonly extension: string;
  /** Null when the file cannot be read before it is converted. */
  readonly facts: Verified | null;
};

/**
 * Files of one source that are to be brought into the store; LiDAR squares or orthophotos alike.
 */
export type FetchJob = {
  readonly kind: 'lidar' | 'ortho';
  readonly table: RecordTable;
  readonly records: readonly StoreRecord[];
  readonly http: SourceClient;
  readonly limits: HostLimits;
  readonly missingStatus: readonly number[];
  readonly max_bytes: number;
  /**
   * Whether file: addresses may be copied. False for addresses from a web catalogue, which could
   * name any local file.
   */
  readonly allowFiles: boolean;
  /** All that a finished file may have, so that one can be found again. */
  readonly extensions: readonly string[];
  /** @throws GrabberError when the first bytes show that this is no such file */
  checkStart(shown: string, start: Uint8Array): void;
  /** @throws GrabberError when the file at `path` is not whole or not what it claims to be */
  check(path: string, record: StoreRecord, url: string, signal: AbortSignal): Promise<Checked>;
  /** Finds addresses of records that have none. */
  readonly locate: Catalogue['locate'];
  /** Addresses that an earlier run found are of no use. */
  readonly addressesExpire?: boolean;
  /** Brings a checked file into the form that is kept, and changes the record itself. */
  readonly convert?: (record: StoreRecord, signal: AbortSignal) => Promise<void>;
};

/** What all jobs of a run share. */
export type FetchRun = {
  /** Folder of the store. */
  readonly root: string;
  readonly clock: Clock;
  readonly policy: RetryPolicy;
  readonly queues: HostQueues;
  readonly disk: DiskSpace;
  /**
   * Queue for slow disk operations that run next to the downloads: unpacking archives and syncing
   * files.
   */
  readonly syncs: PQueue;
  readonly events: FetchEvents;
};

/** What the work on one record needs. */
export type FetchWork = {
  readonly job: FetchJob;
  readonly run: FetchRun;
  readonly blocks: NearBlocks;
  readonly signal: AbortSignal;
};

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
    const { source, grid } = first.key;
    const blocks = new NearBlocks(job.locate === undefined ? [] : job.table.list({ source, grid }));
    // All take from one iterator: a queue would hold a promise and more for each of a country's
    // squares.
    const records = job.records.values();
    const fetchAll = async (): Promise<void> => {
      for (const record of records) {
        signal.throwIfAborted();
        done(await fetchRecord(record, { job, run, blocks, signal }));
      }
    };
    const workers = Array.from({ length: job.limits.max_concurrent * kFilesPerRequest }, fetchAll);
    await Promise.all(workers.map((worker) => worker.catch((error: unknown) => stop.abort(error))));
  } catch (error) {
    stop.abort(error);
  }
}

import { converterFor } from '../convert/converter-for.js';
import { DiskSpace, freeBytes, kReserve_bytes } from '../fetch/disk-space.js';
import type { FetchJob, FetchRun } from '../fetch/fetch-job.js';
import { HostRateLimiter } from '../fetch/host-rate-limiter.js';
import { HostQueues } from '../fetch/host-queues.js';
import { runJobs, syncQueue } from '../fetch/run-jobs.js';
import type { StoreRecord } from '../model/square.js';
import type { Store } from '../model/store.js';
import type { FetchEvents, Tally } from '../progress/events.js';
import type { Reporter } from '../progress/reporter.js';
import { kSystemClock } from '../util/clock.js';
import { GrabberError } from '../util/errors.js';
import type { CliContext } from './context.js';
import { kExit } from './exit-codes.js';
import { toPolicy, type RunOptions } from './run-options.js';

/** What the conversion part adds to a run. */
export type FetchHooks = {
  /** @return brings a checked file into the form that is kept; undefined = nothing is converted */
  readonly converter?: (
    store: Store,
  ) => ((record: StoreRecord, signal: AbortSignal) => Promise<void>) | undefined;
};

export function conversionFor(context: CliContext): FetchHooks {
  const convert = converterFor({
    configFolder: context.configFolder(),
    packageRoot: context.info.root,
  });
  return { converter: (store) => (record, signal) => convert(record, store, signal) };
}

/**
 * Counts of squares that need no job; the source reported `known_missing` ones as missing lately.
 */
export type Excluded = {
  readonly kept: number;
  readonly known_missing: number;
  readonly skipped: number;
};

/**
 * Runs the jobs and reports their outcome.
 * @return the exit code
 */
export async function fillStore(
  jobs: readonly FetchJob[],
  store: Store,
  excluded: Excluded,
  options: RunOptions,
  reporter: Reporter,
  signal: AbortSignal,
): Promise<number> {
  const began_ms = performance.now();
  let received_bytes = 0;
  const events: FetchEvents = {
    ...reporter,
    bytes: (key, done, fresh, total) => {
      received_bytes += fresh;
      reporter.bytes(key, done, fresh, total);
    },
  };
  const records = jobs.flatMap((job) => job.records);
  const known_bytes = records.reduce((sum, record) => sum + (record.expectedBytes ?? 0), 0);
  checkFreeSpace(store.root, known_bytes);
  events.plan({
    files: records.length,
    kept: excluded.kept,
    known_bytes,
    unknown_sizes: records.filter((record) => record.expectedBytes === null).length,
  });
  const run: FetchRun = {
    root: store.root,
    clock: kSystemClock,
    policy: toPolicy(options),
    queues: new HostQueues(new HostRateLimiter(kSystemClock, options.maxWaitS * 1000)),
    disk: new DiskSpace(store.root),
    syncs: syncQueue(),
    events,
  };
  const tally = await runJobs(jobs, run, signal);
  const seconds = Math.round(performance.now() - began_ms) / 1000;
  reporter.summary({
    ...tally,
    kept: tally.kept + excluded.kept,
    known_missing: excluded.known_missing,
    received_bytes,
    seconds,
  });
  return toExitCode(tally, excluded);
}

/**
 * Refuses a run that can never fit, before it starts. Some of the files may be partly there.
 * @throws GrabberError DISK_FULL
 */
function checkFreeSpace(root: string, known_bytes: number): void {
  const free = freeBytes(root);
  if (known_bytes <= free) return;
  throw new GrabberError(
    'DISK_FULL',
    `fill store ${root}: the files have ${known_bytes} bytes, ${free} are free; allowed: ` +
      `at most that, less ${kReserve_bytes} for others`,
  );
}

function toExitCode(tally: Tally, excluded: Excluded): number {
  if (tally.failed > 0 || excluded.skipped > 0) return kExit.failed;
  return tally.missing > 0 || excluded.known_missing > 0 || tally.fetched > 0
    ? kExit.holes
    : kExit.done;
}

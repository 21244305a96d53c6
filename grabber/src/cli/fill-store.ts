import { converterFor, type Converter } from '../convert/convert-record.js';
import { DiskSpace, freeBytes, kReserve_bytes } from '../fetch/disk-space.js';
import { type FetchJob, type FetchRun, runJobs, syncQueue } from '../fetch/run-jobs.js';
import { HostRateLimiter, HostQueues } from '../fetch/host-queues.js';
import type { StoreRecord, Store, Catalogue } from '../model/store.js';
import type { FetchEvents, Tally, Reporter } from '../progress/reporter.js';
import { kSystemClock } from '../util/clock.js';
import { GrabberError } from '../util/errors.js';
import { type CliContext, kExit } from './context.js';
import { toPolicy, type RunOptions } from './run-options.js';
import {
  createHttpClient,
  kNoAccess,
  type Access,
  type SourceClient,
} from '../fetch/http-client.js';
import { userAgent } from '../util/package-info.js';
import { checkLidar, checkLidarStart, kLidarExtensions } from '../fetch/lidar-check.js';
import { readSecretHeaders } from '../fetch/redact.js';
import type { AccessProfile } from '../sources/source.js';

/** What brings a checked file into the form that is kept. */
export function conversionFor({ configFolder, info }: CliContext): Converter {
  return converterFor({ configFolder: configFolder(), packageRoot: info.root });
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

const kGib_bytes = 1024 ** 3;

/** @throws GrabberError SECRET when the environment lacks one */
export function toAccess(profile: AccessProfile): Access {
  return {
    hosts: profile.hosts,
    privateOrigins: profile.privateOrigins,
    secretHeaders: readSecretHeaders(profile.secretHeaders, process.env),
    secretOrigins: profile.secretOrigins,
  };
}

/** @param access permits no host when left out, until permit() is called */
export function openClient(
  { info }: CliContext,
  { timeoutS }: { readonly timeoutS: number },
  access = kNoAccess,
): SourceClient {
  return createHttpClient({ userAgent: userAgent(info), timeout_ms: timeoutS * 1000, access });
}

/** Squares of one source; `http` may contact its hosts. */
export function lidarJob(
  records: readonly StoreRecord[],
  profile: AccessProfile,
  catalogue: Catalogue,
  store: Store,
  http: SourceClient,
  allowFiles: boolean,
  options: RunOptions,
  convert: Converter,
): FetchJob {
  return {
    kind: 'lidar',
    table: store.squares,
    records,
    http,
    limits: {
      max_concurrent: options.concurrency ?? profile.max_concurrent,
      max_per_s: profile.max_per_s,
    },
    missingStatus: profile.missing_status,
    max_bytes: options.maxFileGib * kGib_bytes,
    allowFiles,
    extensions: kLidarExtensions,
    checkStart: checkLidarStart,
    check: checkLidar,
    locate: catalogue.locate?.bind(catalogue),
    addressesExpire: catalogue.addressesExpire ?? false,
    convert: (record, signal) => convert(record, store, signal),
  };
}

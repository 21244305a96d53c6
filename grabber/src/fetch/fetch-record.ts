import type { StoreRecord } from '../model/square.js';
import type { Outcome } from '../progress/events.js';
import { GrabberError, describeError } from '../util/errors.js';
import { stopsRun } from './disk-space.js';
import type { FetchJob, FetchRun } from './fetch-job.js';
import { locateAddresses } from './locate.js';
import type { NearBlocks } from './near-blocks.js';
import { fetchFromMirrors, type FetchResult } from './mirrors.js';
import { recover } from './recover.js';

/**
 * Fetches one file into the store: locate, transfer, check, rename, convert. A failure of the file
 * is an outcome; only a stop, or a fault that all files share, is thrown.
 */
export async function fetchRecord(
  record: StoreRecord,
  job: FetchJob,
  run: FetchRun,
  blocks: NearBlocks,
  signal: AbortSignal,
): Promise<Outcome> {
  const { key } = record;
  try {
    const done =
      (await recover(record, job, run, signal)) ??
      (await locateAndObtain(record, job, run, blocks, signal));
    if (done.kind === 'missing') {
      const reason = job.http.redact(`${key.source} has no square ${key.name} (${done.reason})`);
      job.table.missing(key, reason);
      return { state: 'missing', key, url: job.table.get(key)?.url ?? null, reason };
    }
    const stored = job.table.get(key) ?? record;
    if (job.convert === undefined) return toOutcome(stored, done);
    await job.convert(stored, signal);
    return toOutcome(job.table.get(key) ?? stored, done);
  } catch (error) {
    signal.throwIfAborted();
    if (stopsRun(error)) throw error;
    // The server may have sent back what it was sent.
    const message = job.http.redact(describeError(error));
    const code = error instanceof GrabberError ? error.code : 'STORE_IO';
    job.table.failed(key, code, message);
    return { state: 'failed', key, url: job.table.get(key)?.url ?? null, code, message };
  }
}

async function locateAndObtain(
  record: StoreRecord,
  job: FetchJob,
  run: FetchRun,
  blocks: NearBlocks,
  signal: AbortSignal,
): Promise<FetchResult> {
  const urls = await locateAddresses(record, job, run, blocks, signal);
  if (urls.length === 0) return { kind: 'missing', reason: 'at none of its possible addresses' };
  return fetchFromMirrors(record, urls, job, run, signal);
}

type Stored = Extract<FetchResult, { kind: 'stored' }>;

function toOutcome(record: StoreRecord, done: Stored): Outcome {
  return {
    state: outcomeState(record, done),
    key: record.key,
    url: record.url,
    file: record.file ?? done.file,
    point_count: record.points?.pointCount ?? null,
    warnings: record.warnings,
  };
}

function outcomeState({ state }: StoreRecord, done: Stored): 'converted' | 'fetched' | 'verified' {
  if (state === 'converted' || state === 'verified') return state;
  return done.checked.facts === null ? 'fetched' : 'verified';
}

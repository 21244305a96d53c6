import { join } from 'node:path';
import type { StoreRecord } from '../model/store.js';
import type { Outcome } from '../progress/reporter.js';
import { GrabberError, describeError, recordedCode } from '../util/errors.js';
import { stopsRun } from './disk-space.js';
import type { FetchWork } from './run-jobs.js';
import { locateAddresses } from './locate.js';
import { recover, checkHash, finalize, type FinalizedFile } from './finalize.js';
import { archiveBeside, kPlaces } from '../store/layout.js';
import { copyLocal, transferOnce, type TransferContext, type TransferResult } from './transfer.js';
import { readPartialState, removePartial } from './partial.js';
import { withRetries } from './retry.js';
import { shownUrl } from './redact.js';
import { unzipMember } from './zip-member.js';

/**
 * Fetches one file into the store: locate, transfer, check, rename, convert. A failure of the file
 * is an outcome; only a stop, or a fault that all files share, is thrown.
 */
export async function fetchRecord(record: StoreRecord, work: FetchWork): Promise<Outcome> {
  const { key } = record;
  const { job, signal } = work;
  try {
    const done = (await recover(record, work)) ?? (await locateAndObtain(record, work));
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
    const code = recordedCode(error);
    job.table.failed(key, code, message);
    return { state: 'failed', key, url: job.table.get(key)?.url ?? null, code, message };
  }
}

async function locateAndObtain(record: StoreRecord, work: FetchWork): Promise<FetchResult> {
  const urls = await locateAddresses(record, work);
  if (urls.length === 0) return { kind: 'missing', reason: 'at none of its possible addresses' };
  return fetchFromMirrors(record, urls, work);
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

export type FetchResult = FinalizedFile | { readonly kind: 'missing'; readonly reason: string };

const kNoStop = new AbortController().signal;

/** Fewer fresh bytes than this do not count as getting further. */
const kAdvance_bytes = 1024 * 1024;

/**
 * Tries the mirrors of a file in order, each until its retries are used up; a mirror without the
 * file is left at once.
 * @return kind "missing" when no mirror has the file
 * @throws the last mirror's error when one failed for another reason
 */
async function fetchFromMirrors(
  record: StoreRecord,
  urls: readonly string[],
  work: FetchWork,
): Promise<FetchResult> {
  const { job, run, signal } = work;
  let missing: FetchResult = { kind: 'missing', reason: 'no address' };
  let failure: { readonly error: unknown } | undefined;
  for (const url of await resumableFirst(record, urls, work)) {
    job.table.begin(record.key, url);
    run.events.begin(record.key, url);
    try {
      const done = await fromMirror(record, url, work);
      if (done.kind === 'stored') return done;
      missing = done;
    } catch (error) {
      signal.throwIfAborted();
      if (stopsRun(error)) throw error;
      failure = { error };
    }
  }
  if (failure !== undefined) throw failure.error;
  return missing;
}

/** Puts the mirror of an unfinished file first, since only that one can continue it. */
async function resumableFirst(
  record: StoreRecord,
  urls: readonly string[],
  work: FetchWork,
): Promise<readonly string[]> {
  if (urls.length < 2) return urls;
  const started = (await readPartialState(toPlaces(record, work).transfer, work.signal))?.url;
  return [...urls].sort((a, b) => Number(b === started) - Number(a === started));
}

/** Where bytes arrive, and where the file lies that is checked; the same but for archives. */
function toPlaces(
  record: StoreRecord,
  { job, run }: FetchWork,
): { transfer: string; file: string } {
  const file = join(run.root, kPlaces.unfinished(job.kind, record.key));
  return { transfer: record.member === null ? file : archiveBeside(file), file };
}

function fromMirror(record: StoreRecord, url: string, work: FetchWork): Promise<FetchResult> {
  const { job, run, signal } = work;
  let furthest_bytes = 0;
  let reached_bytes = 0;
  const context: TransferContext = {
    http: job.http,
    limiter: run.queues.limiter,
    disk: run.disk,
    clock: run.clock,
    missingStatus: job.missingStatus,
    max_bytes: job.max_bytes,
    expected_bytes: record.expectedBytes ?? 0,
    checkStart: (shown, start) =>
      record.member === null ? job.checkStart(shown, start) : undefined,
    onBytes: (done, fresh, total) => {
      reached_bytes = done;
      run.events.bytes(record.key, done, fresh, total);
    },
  };
  const advanced = (): boolean => {
    const further = reached_bytes > furthest_bytes + kAdvance_bytes;
    furthest_bytes = Math.max(furthest_bytes, reached_bytes);
    return further;
  };
  return withRetries(
    () => attempt(record, url, context, work),
    run.policy,
    run.clock,
    (notice) => run.events.retry(record.key, notice),
    signal,
    advanced,
  );
}

async function attempt(
  record: StoreRecord,
  url: string,
  context: TransferContext,
  work: FetchWork,
): Promise<FetchResult> {
  const { run, signal } = work;
  const places = toPlaces(record, work);
  const transfer = await transferFrom(url, places.transfer, context, work);
  if (transfer.kind === 'missing') return transfer;
  try {
    checkHash(shownUrl(url), transfer.sha256, record.expectedSha256);
    const { member } = record;
    const { bytes, sha256 } =
      member === null
        ? transfer
        : await run.syncs.add(() =>
            unzipMember(places.transfer, member, places.file, shownUrl(url), context, signal),
          );
    // A stop does not interrupt this: a received file is checked and renamed, which is quick.
    const received = { partial: places.file, url, bytes, sha256 };
    const finalized = await finalize(record, received, { ...work, signal: kNoStop });
    if (member !== null) removePartial(places.transfer);
    return finalized;
  } catch (error) {
    // A whole file that is bad is fetched from its start again. A disk error says nothing about the
    // file.
    if (!signal.aborted && !stopsRun(error)) removePartial(places.transfer);
    throw error;
  }
}

function transferFrom(
  url: string,
  partial: string,
  context: TransferContext,
  { job, run, signal }: FetchWork,
): Promise<TransferResult> {
  if (!URL.canParse(url)) {
    throw new GrabberError(
      'CATALOGUE',
      `fetch "${url.slice(0, 200)}": no address; allowed: http(s)://host/path`,
    );
  }
  const { protocol, host } = new URL(url);
  if (protocol !== 'file:') {
    const transfer = (): Promise<TransferResult> => transferOnce(url, partial, context, signal);
    return run.queues.run(host, job.limits, transfer, signal);
  }
  if (!job.allowFiles) {
    throw new GrabberError(
      'LOCAL_FILE',
      `fetch ${url}: a file of this machine; allowed: web addresses, or fetch with --from`,
    );
  }
  const copy = (): Promise<TransferResult> => copyLocal(url, partial, context, signal);
  return run.queues.run(protocol, { ...job.limits, max_per_s: null }, copy, signal);
}

import { join } from 'node:path';
import type { StoreRecord } from '../model/square.js';
import { archiveBeside, kPlaces } from '../store/layout.js';
import { GrabberError } from '../util/errors.js';
import { copyLocal } from './copy-local.js';
import { stopsRun } from './disk-space.js';
import type { FetchJob, FetchRun } from './fetch-job.js';
import { readPartialState, removePartial } from './partial.js';
import { withRetries } from './retry.js';
import { checkHash, finalize, type FinalizedFile } from './finalize.js';
import { shownUrl } from './shown-url.js';
import { transferOnce, type TransferContext, type TransferResult } from './transfer.js';
import { unzipMember } from './zip-member.js';

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
export async function fetchFromMirrors(
  record: StoreRecord,
  urls: readonly string[],
  job: FetchJob,
  run: FetchRun,
  signal: AbortSignal,
): Promise<FetchResult> {
  let missing: FetchResult = { kind: 'missing', reason: 'no address' };
  let failure: { readonly error: unknown } | undefined;
  for (const url of await resumableFirst(record, urls, job, run, signal)) {
    job.table.begin(record.key, url);
    run.events.begin(record.key, url);
    try {
      const done = await fromMirror(record, url, job, run, signal);
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
  job: FetchJob,
  run: FetchRun,
  signal: AbortSignal,
): Promise<readonly string[]> {
  if (urls.length < 2) return urls;
  const started = (await readPartialState(toPlaces(record, job, run).transfer, signal))?.url;
  return [...urls].sort((a, b) => Number(b === started) - Number(a === started));
}

/** Where bytes arrive, and where the file lies that is checked; the same but for archives. */
function toPlaces(
  record: StoreRecord,
  job: FetchJob,
  run: FetchRun,
): { transfer: string; file: string } {
  const file = join(run.root, kPlaces.unfinished(job.kind, record.key));
  return { transfer: record.member === null ? file : archiveBeside(file), file };
}

function fromMirror(
  record: StoreRecord,
  url: string,
  job: FetchJob,
  run: FetchRun,
  signal: AbortSignal,
): Promise<FetchResult> {
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
    () => attempt(record, url, context, job, run, signal),
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
  job: FetchJob,
  run: FetchRun,
  signal: AbortSignal,
): Promise<FetchResult> {
  const places = toPlaces(record, job, run);
  const transfer = await transferFrom(url, places.transfer, context, job, run, signal);
  if (transfer.kind === 'missing') return transfer;
  try {
    checkHash(shownUrl(url), transfer.sha256, record.expectedSha256);
    const { member } = record;
    const { bytes, sha256 } =
      member === null
        ? transfer
        : await run.syncs.add(() =>
            unzipMember(
              places.transfer,
              member,
              places.file,
              shownUrl(url),
              { ...context, max_bytes: job.max_bytes },
              signal,
            ),
          );
    // A stop does not interrupt this: a received file is checked and renamed, which is quick.
    const finalized = await finalize(
      record,
      { partial: places.file, url, bytes, sha256 },
      job,
      run,
      kNoStop,
    );
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
  job: FetchJob,
  run: FetchRun,
  signal: AbortSignal,
): Promise<TransferResult> {
  if (!URL.canParse(url)) {
    throw new GrabberError(
      'CATALOGUE',
      `fetch "${url.slice(0, 200)}": no address; allowed: http(s)://host/path`,
    );
  }
  const { protocol, host } = new URL(url);
  if (protocol !== 'file:') {
    return run.queues.run(
      host,
      job.limits,
      () => transferOnce(url, partial, context, signal),
      signal,
    );
  }
  if (!job.allowFiles) {
    throw new GrabberError(
      'LOCAL_FILE',
      `fetch ${url}: a file of this machine; allowed: web addresses, or fetch with --from`,
    );
  }
  return run.queues.run(
    protocol,
    { ...job.limits, max_per_s: null },
    () => copyLocal(url, partial, context, signal),
    signal,
  );
}

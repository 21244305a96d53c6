import { join } from 'node:path';
import type { StoreRecord } from '../model/square.js';
import { kPlaces } from '../store/layout.js';
import { GrabberError } from '../util/errors.js';
import { fileSize, sha256OfFile } from '../util/files.js';
import type { Checked, FetchJob, FetchRun } from './fetch-job.js';
import { readPartialState, removePartial } from './partial.js';
import { finalize, type FinalizedFile } from './finalize.js';

/**
 * Finishes what a killed run had nearly done.
 * @return undefined when the file must be transferred
 */
export async function recover(
  record: StoreRecord,
  job: FetchJob,
  run: FetchRun,
  signal: AbortSignal,
): Promise<FinalizedFile | undefined> {
  if (record.state === 'fetched' && record.file !== null) {
    return recoverFetched(record, job, run, signal);
  }
  if (record.state === 'fetching' && record.file === null && record.member === null) {
    return adoptFinished(record, job, run, signal);
  }
  return undefined;
}

/**
 * The record knows length and hash; the file lies under its final name, or still under the
 * unfinished one.
 */
async function recoverFetched(
  record: StoreRecord,
  job: FetchJob,
  run: FetchRun,
  signal: AbortSignal,
): Promise<FinalizedFile | undefined> {
  const { file, url, urls } = record;
  if (file === null) return undefined;
  const from = url ?? urls[0] ?? file.path;
  const place = job.extensions
    .map((extension) => kPlaces.finished(job.kind, record.key, extension))
    .find((one) => one === file.path);
  if (place !== undefined && (await hasContent(join(run.root, place), file, signal))) {
    const checked = await tryCheck(join(run.root, place), record, from, job, signal);
    if (checked === undefined) return undefined;
    if (checked.facts !== null) job.table.verified(record.key, checked.facts);
    return { kind: 'stored', file, checked };
  }
  const partial = join(run.root, kPlaces.unfinished(job.kind, record.key));
  if (!(await hasContent(partial, file, signal))) return undefined;
  return finalize(
    record,
    { partial, url: from, bytes: file.bytes, sha256: file.sha256 },
    job,
    run,
    signal,
  );
}

async function hasContent(
  path: string,
  file: { bytes: number; sha256: string },
  signal: AbortSignal,
): Promise<boolean> {
  if ((await fileSize(path)) !== file.bytes) return false;
  return (await sha256OfFile(path, signal)) === file.sha256;
}

/**
 * A file under its final name whose record does not have it yet, since the run was killed before:
 * taken when its length or hash is the expected one.
 */
async function adoptFinished(
  record: StoreRecord,
  job: FetchJob,
  run: FetchRun,
  signal: AbortSignal,
): Promise<FinalizedFile | undefined> {
  const partial = join(run.root, kPlaces.unfinished(job.kind, record.key));
  const state = await readPartialState(partial, signal);
  for (const extension of job.extensions) {
    const path = kPlaces.finished(job.kind, record.key, extension);
    const bytes = await fileSize(join(run.root, path));
    if (bytes === undefined) continue;
    const sha256 = await sha256OfFile(join(run.root, path), signal);
    const fits =
      record.expectedSha256 === null
        ? [record.expectedBytes, state?.total_bytes].includes(bytes)
        : record.expectedSha256.toLowerCase() === sha256;
    if (!fits) continue;
    const checked = await tryCheck(join(run.root, path), record, record.url ?? path, job, signal);
    if (checked?.extension !== extension) continue;
    const file = { path, bytes, sha256 };
    job.table.fetched(record.key, file);
    removePartial(partial);
    if (checked.facts !== null) job.table.verified(record.key, checked.facts);
    return { kind: 'stored', file, checked };
  }
  return undefined;
}

/** @return undefined when the file is bad, and so must be fetched again */
async function tryCheck(
  path: string,
  record: StoreRecord,
  url: string,
  job: FetchJob,
  signal: AbortSignal,
): Promise<Checked | undefined> {
  try {
    return await job.check(path, record, url, signal);
  } catch (error) {
    signal.throwIfAborted();
    if (error instanceof GrabberError) return undefined;
    throw error;
  }
}

import { renameSync } from 'node:fs';
import { join } from 'node:path';
import type { StoreRecord, StoredFile } from '../model/store.js';
import { kPlaces } from '../store/layout.js';
import { GrabberError } from '../util/errors.js';
import { removeIfThere, fileSize, sha256OfFile } from '../util/files.js';
import { withStoreErrors, withStoreErrorsSync } from './disk-space.js';
import type { Checked, FetchJob, FetchWork } from './run-jobs.js';
import { forgetState, removePartial, readPartialState } from './partial.js';
import { flushFile } from '../convert/work-folder.js';

export type ReceivedFile = {
  readonly partial: string;
  readonly url: string;
  readonly bytes: number;
  readonly sha256: string;
};
export type FinalizedFile = {
  readonly kind: 'stored';
  readonly file: StoredFile;
  readonly checked: Checked;
};

/**
 * Checks a whole file and gives it its final name: check, record, sync, rename, record. In this
 * order a file under its final name is always whole and checked, and its record names it already: a
 * run that was killed in between finds the file by its hash under either name (recover.ts) and
 * fetches nothing again. All operations but the sync are synchronous, since each takes less time
 * than a worker thread would; syncs may take long and are queued.
 * @throws GrabberError of the check, STORE_IO or DISK_FULL
 */
export async function finalize(
  record: StoreRecord,
  received: ReceivedFile,
  work: FetchWork,
): Promise<FinalizedFile> {
  const { job, run, signal } = work;
  const { partial, url, bytes, sha256 } = received;
  let checked: Checked;
  try {
    checked = await job.check(partial, record, url, signal);
  } catch (error) {
    // A whole file that is bad cannot be continued; the next try must start anew.
    if (!signal.aborted) removePartial(partial);
    throw error;
  }
  const file = { path: kPlaces.finished(job.kind, record.key, checked.extension), bytes, sha256 };
  job.table.fetched(record.key, file);
  await run.syncs.add(() => withStoreErrors(partial, () => flushFile(partial)));
  withStoreErrorsSync(file.path, () => renameSync(partial, join(run.root, file.path)));
  forgetState(partial);
  await removeOldFile(record, file.path, work);
  if (checked.facts !== null) job.table.verified(record.key, checked.facts);
  return { kind: 'stored', file, checked };
}

/**
 * A square that was LAS and is LAZ now, or the other way round, leaves a file that no record names.
 */
async function removeOldFile(
  record: StoreRecord,
  path: string,
  { job, run }: FetchWork,
): Promise<void> {
  const old = record.file?.path;
  if (old === undefined || old === path) return;
  // Only a name that this program gives is removed, whatever stands in the record.
  if (listOwnPaths(record, job).includes(old)) await removeIfThere(join(run.root, old));
}

function listOwnPaths({ key }: StoreRecord, { extensions, kind }: FetchJob): string[] {
  return extensions.map((extension) => kPlaces.finished(kind, key, extension));
}

export function checkHash(url: string, found: string, expected: string | null): void {
  if (expected === null || expected.toLowerCase() === found) return;
  throw new GrabberError(
    'CHECKSUM',
    `fetch ${url}: SHA-256 is ${found}; allowed: ${expected}, as its catalogue says`,
    { retryable: true },
  );
}

/**
 * Finishes what a killed run had nearly done.
 * @return undefined when the file must be transferred
 */
export async function recover(
  record: StoreRecord,
  work: FetchWork,
): Promise<FinalizedFile | undefined> {
  if (record.state === 'fetched' && record.file !== null) {
    return recoverFetched(record, work);
  }
  if (record.state === 'fetching' && record.file === null && record.member === null) {
    return adoptFinished(record, work);
  }
  return undefined;
}

/**
 * The record knows length and hash; the file lies under its final name, or still under the
 * unfinished one.
 */
async function recoverFetched(
  record: StoreRecord,
  work: FetchWork,
): Promise<FinalizedFile | undefined> {
  const { job, run, signal } = work;
  const { file, url, urls } = record;
  if (file === null) return undefined;
  const from = url ?? urls[0] ?? file.path;
  const final = join(run.root, file.path);
  if (listOwnPaths(record, job).includes(file.path) && (await hasContent(final, file, signal))) {
    const checked = await tryCheck(final, record, from, work);
    if (checked === undefined) return undefined;
    if (checked.facts !== null) job.table.verified(record.key, checked.facts);
    return { kind: 'stored', file, checked };
  }
  const partial = join(run.root, kPlaces.unfinished(job.kind, record.key));
  if (!(await hasContent(partial, file, signal))) return undefined;
  return finalize(record, { ...file, partial, url: from }, work);
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
  work: FetchWork,
): Promise<FinalizedFile | undefined> {
  const { job, run, signal } = work;
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
    const checked = await tryCheck(join(run.root, path), record, record.url ?? path, work);
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
  { job, signal }: FetchWork,
): Promise<Checked | undefined> {
  try {
    return await job.check(path, record, url, signal);
  } catch (error) {
    signal.throwIfAborted();
    if (error instanceof GrabberError) return undefined;
    throw error;
  }
}

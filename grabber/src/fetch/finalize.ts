import { closeSync, fdatasync, openSync, renameSync } from 'node:fs';
import { join } from 'node:path';
import { promisify } from 'node:util';
import type { StoreRecord, StoredFile } from '../model/square.js';
import { kPlaces } from '../store/layout.js';
import { GrabberError } from '../util/errors.js';
import { removeIfThere } from '../util/files.js';
import { withStoreErrors, withStoreErrorsSync } from './disk-space.js';
import type { Checked, FetchJob, FetchRun } from './fetch-job.js';
import { forgetState, removePartial } from './partial.js';

const datasync = promisify(fdatasync);

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
  job: FetchJob,
  run: FetchRun,
  signal: AbortSignal,
): Promise<FinalizedFile> {
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
  await run.syncs.add(() => withStoreErrors(partial, () => syncFile(partial)));
  withStoreErrorsSync(file.path, () => renameSync(partial, join(run.root, file.path)));
  forgetState(partial);
  await removeOldFile(record, file.path, job, run);
  if (checked.facts !== null) job.table.verified(record.key, checked.facts);
  return { kind: 'stored', file, checked };
}

/**
 * Writes the data to the disk before the rename, since otherwise it may arrive there after the
 * name.
 */
async function syncFile(path: string): Promise<void> {
  const fd = openSync(path, 'r+');
  try {
    await datasync(fd);
  } finally {
    closeSync(fd);
  }
}

/**
 * A square that was LAS and is LAZ now, or the other way round, leaves a file that no record names.
 */
async function removeOldFile(
  record: StoreRecord,
  path: string,
  job: FetchJob,
  run: FetchRun,
): Promise<void> {
  const old = record.file?.path;
  if (old === undefined || old === path) return;
  // Only a name that this program gives is removed, whatever stands in the record.
  if (
    job.extensions.some((extension) => kPlaces.finished(job.kind, record.key, extension) === old)
  ) {
    await removeIfThere(join(run.root, old));
  }
}

export function checkHash(url: string, found: string, expected: string | null): void {
  if (expected === null || expected.toLowerCase() === found) return;
  throw new GrabberError(
    'CHECKSUM',
    `fetch ${url}: SHA-256 is ${found}; allowed: ${expected}, as its catalogue says`,
    { retryable: true },
  );
}

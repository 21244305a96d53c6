import type { RecordKey, StoredFile, StoreRecord } from '../model/square.js';
import type { RecordTable, Store } from '../model/store.js';
import { kPlaces, type FileKind } from '../store/layout.js';
import { findProblem, wrongBytes } from './check-file.js';

export type FileToCheck = {
  readonly kind: FileKind;
  readonly key: RecordKey;
  readonly file: StoredFile;
  /**
   * False: a run that was cut off, or is not through yet, may have left it under its unfinished
   * name.
   */
  readonly placed: boolean;
};
export type BadFile = FileToCheck & { readonly reason: string };
export type VerifyProgress = (done: number, total: number, bytes: number) => void;

/** Two files at a time keep a disk and the hash of the other file busy. */
const kConcurrency = 2;

export function chooseTable(store: Store, kind: FileKind): RecordTable {
  return kind === 'lidar' ? store.squares : store.orthophotos;
}

/** Usable files, and whole ones that have not been checked yet. */
export function wholeFiles(store: Store, source: string | undefined): FileToCheck[] {
  const of = source === undefined ? {} : { source };
  return (['lidar', 'ortho'] as const).flatMap((kind) => {
    const table = chooseTable(store, kind);
    return [
      ...table.list({ ...of, usable: true }),
      ...table.list({ ...of, states: ['fetched'] }),
    ].flatMap((record) => toCheck(kind, record) ?? []);
  });
}

function toCheck(
  kind: FileKind,
  { key, file, state, verifiedAt }: StoreRecord,
): FileToCheck | undefined {
  const whole = verifiedAt !== null || state === 'fetched';
  return file === null || !whole ? undefined : { kind, key, file, placed: state !== 'fetched' };
}

/** @return the bad ones, in the order of `files` */
export async function verifyFiles(
  store: Store,
  files: readonly FileToCheck[],
  progress: VerifyProgress,
  signal: AbortSignal,
): Promise<BadFile[]> {
  const bad: (BadFile | undefined)[] = [];
  const waiting = files.entries();
  let done = 0;
  let bytes = 0;
  const work = async (): Promise<void> => {
    // All workers take from one iterator.
    for (const [index, one] of waiting) {
      bad[index] = await checkOne(store, one, signal);
      ++done;
      bytes += one.file.bytes;
      progress(done, files.length, bytes);
    }
  };
  await Promise.all(Array.from({ length: kConcurrency }, work));
  return bad.filter((one) => one !== undefined);
}

/**
 * A fetch may replace a file while it is read, so a fault is reported only of a file that the
 * store still has like this.
 */
async function checkOne(
  store: Store,
  one: FileToCheck,
  signal: AbortSignal,
): Promise<BadFile | undefined> {
  let now: FileToCheck | undefined = one;
  while (now !== undefined) {
    signal.throwIfAborted();
    if (!now.placed && (await liesUnfinished(store, now, signal))) return undefined;
    const reason = await findProblem(store.root, now.file, now.kind, signal);
    if (reason === undefined) return undefined;
    const later = findCurrent(store, now);
    if (later?.file.sha256 === now.file.sha256 && later.file.path === now.file.path) {
      return { ...now, reason };
    }
    now = later;
  }
  return undefined;
}

async function liesUnfinished(
  store: Store,
  { kind, key, file }: FileToCheck,
  signal: AbortSignal,
): Promise<boolean> {
  return (
    (await wrongBytes(store.root, { ...file, path: kPlaces.unfinished(kind, key) }, signal)) ===
    undefined
  );
}

function findCurrent(store: Store, { kind, key }: FileToCheck): FileToCheck | undefined {
  const record = chooseTable(store, kind).get(key);
  return record === undefined ? undefined : toCheck(kind, record);
}

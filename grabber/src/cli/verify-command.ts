import { rm } from 'node:fs/promises';
import { join } from 'node:path';
import type { Command } from 'commander';
import type { Store, RecordKey, StoredFile, StoreRecord } from '../model/store.js';
import { type CliContext, kExit, formatBytes, type Output } from './context.js';
import { parseSourceId } from './options.js';
import {
  checkSource,
  readStore,
  storeOption,
  writeStore,
  type StoreOption,
  chooseTable,
} from './with-store.js';
import { kPlaces, type FileKind } from '../store/layout.js';
import { verifyLasFile } from '../las/verify.js';
import { describeError } from '../util/errors.js';
import { fileSize, sha256OfFile, readStart } from '../util/files.js';

type VerifyOptions = StoreOption & {
  readonly source?: string;
  readonly repair?: boolean;
  readonly json?: boolean;
};

export function addVerifyCommand(program: Command, context: CliContext): void {
  program
    .command('verify')
    .description('read all finished files again: length, SHA-256, header')
    .addOption(storeOption())
    .option('--source <id>', 'only files of this source', parseSourceId)
    .option('--repair', 'remove bad files and want them again; "resume" fetches them')
    .option('--json', 'print JSON')
    .addHelpText('after', '\nExit codes: 0 all are good, 1 some are bad.')
    .action(async (options: VerifyOptions) => {
      const work = (store: Store): Promise<number> => verifyCommand(store, options, context);
      const run = options.repair === true ? writeStore : readStore;
      context.exit(await run(options.store, context.signal, work));
    });
}

async function verifyCommand(
  store: Store,
  options: VerifyOptions,
  { output, signal }: CliContext,
): Promise<number> {
  checkSource(store, options.source);
  const files = wholeFiles(store, options.source);
  const bad = await verifyFiles(store, files, progressTo(output, process.stderr.isTTY), signal);
  if (options.repair === true) for (const one of bad) await repair(store, one);
  if (options.json === true) {
    const reported = bad.map(({ kind, key, file, reason }) => ({ kind, key, file, reason }));
    const result = { checked: files.length, repaired: options.repair === true, bad: reported };
    output.out(`${JSON.stringify(result, undefined, 2)}\n`);
  } else {
    for (const { key, file, reason } of bad) {
      output.outLine(`bad ${key.source}/${key.name}  ${file.path}: ${reason}`);
    }
    const repaired = options.repair === true ? ', wanted again' : '; --repair wants them again';
    const then = bad.length === 0 ? '' : repaired;
    output.outLine(`${files.length} files checked, ${bad.length} bad${then}`);
  }
  return bad.length === 0 ? kExit.done : kExit.failed;
}

/**
 * Removes a bad file and marks it as wanted. The file goes first: after a kill the record names a
 * missing file, which the next run finds.
 */
async function repair(store: Store, { kind, key, file }: BadFile): Promise<void> {
  await rm(join(store.root, file.path), { force: true });
  chooseTable(store, kind).forget(key);
  chooseTable(store, kind).want([key]);
}

/**
 * Shows progress: one line that is overwritten in a terminal, else a line for every tenth of the
 * files.
 */
function progressTo(output: Output, terminal: boolean): VerifyProgress {
  let reported = 0;
  return (done, total, bytes) => {
    const tenth = Math.floor((10 * done) / total);
    if (!terminal && tenth === reported) return;
    reported = tenth;
    const text = `verify ${done}/${total} files, ${formatBytes(bytes)}`;
    if (terminal) output.drawn.err(`\r${text}${done === total ? '\n' : ''}`);
    else output.errLine(text);
  };
}

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

/**
 * Reads all of a file of the store again: length, hash, and whether it opens as what it is.
 * @return what is wrong with it, undefined when nothing is
 * @throws the signal's reason when it aborts
 */
export async function findProblem(
  root: string,
  file: StoredFile,
  kind: FileKind,
  signal: AbortSignal,
): Promise<string | undefined> {
  const path = join(root, file.path);
  try {
    const wrong = await wrongBytes(root, file, signal);
    // zLAS is Esri's own format, and its header is not published.
    if (wrong !== undefined || file.path.endsWith('.zlas')) return wrong;
    if (kind === 'ortho') return await tiffProblem(path, file.bytes);
    await verifyLasFile(path, file.path, signal);
    return undefined;
  } catch (error) {
    signal.throwIfAborted();
    return describeError(error);
  }
}

/** @return in what way its bytes are not those that are recorded */
export async function wrongBytes(
  root: string,
  file: StoredFile,
  signal: AbortSignal,
): Promise<string | undefined> {
  const path = join(root, file.path);
  const bytes = await fileSize(path);
  if (bytes === undefined) return 'it is not there';
  if (bytes !== file.bytes) return `it has ${bytes} bytes; recorded: ${file.bytes}`;
  const sha256 = await sha256OfFile(path, signal);
  return sha256 === file.sha256 ? undefined : `its SHA-256 is ${sha256}; recorded: ${file.sha256}`;
}

/** Ref: Adobe, "TIFF Revision 6.0", 1992, section 2; BigTIFF has version 43 and 8-byte offsets. */
async function tiffProblem(path: string, bytes: number): Promise<string | undefined> {
  const start = await readStart(path, 16);
  const order = start.toString('latin1', 0, 2);
  if (start.length < 16 || (order !== 'II' && order !== 'MM')) return 'it is no TIFF file';
  // Little-endian from here on.
  if (order === 'MM') start.subarray(2, 4).swap16();
  const version = start.readUInt16LE(2);
  if (version !== 42 && version !== 43) return `its TIFF version is ${version}; allowed: 42, 43`;
  if (order === 'MM' && version === 42) start.subarray(4, 8).swap32();
  if (order === 'MM') start.subarray(8, 16).swap64();
  const offset = version === 43 ? Number(start.readBigUInt64LE(8)) : start.readUInt32LE(4);
  return offset < 8 || offset >= bytes
    ? `its directory is at ${offset}; allowed: 8 to ${bytes - 1}`
    : undefined;
}

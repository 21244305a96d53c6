import type { Dirent } from 'node:fs';
import { readdir, realpath, rm, stat } from 'node:fs/promises';
import { join, relative, sep } from 'node:path';
import type { Command } from 'commander';
import { removeStaleWork } from '../convert/work-folder.js';
import type { Store, StoreRecord } from '../model/store.js';
import { type CliContext, formatBytes } from './context.js';
import { parseSourceId } from './options.js';
import {
  checkSource,
  storeOption,
  writeStore,
  type StoreOption,
  chooseTable,
} from './with-store.js';
import { archiveBeside, kFileExtensions, kPlaces, type FileKind } from '../store/layout.js';
import { systemCode } from '../util/errors.js';

type GcOptions = StoreOption & { readonly source?: string; readonly dryRun?: boolean };

export function addGcCommand(program: Command, context: CliContext): void {
  program
    .command('gc')
    .description(
      'remove files of the store that no record names, and unfinished ones that are no ' +
        'longer needed',
    )
    .addOption(storeOption())
    .option('--source <id>', 'drop all files of this source; its squares stay known', parseSourceId)
    .option('--dry-run', 'only list what would be removed')
    .action((options: GcOptions) =>
      writeStore(options.store, context.signal, (store) => gcCommand(store, options, context)),
    );
}

async function gcCommand(
  store: Store,
  { source, dryRun = false }: GcOptions,
  { output, signal }: CliContext,
): Promise<void> {
  checkSource(store, source);
  const { files, leftAlone } = await findLeftovers(store, source, signal);
  // Records first: a run that is cut off here leaves files that no record names, which the next one
  // finds.
  const dropped = source === undefined ? 0 : dropRecords(store, source, dryRun);
  if (!dryRun) {
    await removeStaleWork(store.root);
    await removeLeftovers(store, files, signal);
  }
  for (const { path, bytes } of files) {
    output.outLine(`${dryRun ? 'would remove' : 'removed'} ${path}  ${formatBytes(bytes)}`);
  }
  for (const path of leftAlone) {
    output.errLine(
      `warning: left alone ${path}: a link, not in the store, or no file of the grabber's`,
    );
  }
  const total = files.reduce((sum, { bytes }) => sum + bytes, 0);
  const records =
    source === undefined
      ? ''
      : `, ${dropped} records of ${source}${dryRun ? ' would be' : ''} dropped`;
  output.outLine(
    `${files.length} files, ${formatBytes(total)}${dryRun ? ' would go' : ' removed'}${records}`,
  );
}

function dropRecords(store: Store, source: string, dryRun: boolean): number {
  let dropped = 0;
  for (const table of [store.squares, store.orthophotos]) {
    for (const { key, state } of table.list({ source })) {
      if (state === 'known') continue;
      ++dropped;
      if (!dryRun) table.forget(key);
    }
  }
  return dropped;
}

export type Leftover = { readonly path: string; readonly bytes: number };
export type Leftovers = {
  /** Files that no record names, by path. */
  readonly files: readonly Leftover[];
  /**
   * Links, folders outside of the store, and names that this program does not give: they are
   * left to the user.
   */
  readonly leftAlone: readonly string[];
};

const kKinds: readonly FileKind[] = ['lidar', 'ortho'];
/** Names that this program gives: finished and unfinished files, and their side-cars. */
const kOwnNames =
  /\.(laz|las|zlas|lax|tif|tif\.(aux\.xml|ovr|msk))$|\/\.[^/]+\.part(\.json(\.tmp)?)?$/i;
const kKeptOriginal = /^lidar\/[^/]+\/original\//;
const kUnfinished = new Set(['wanted', 'fetching', 'fetched']);

/**
 * Looks for files in the store's folders that no record needs. The store must not be written to
 * meanwhile.
 * @param dropped a source whose records count as if they named nothing, and the only one whose
 *   folders are looked at
 */
export async function findLeftovers(
  store: Store,
  dropped: string | undefined,
  signal: AbortSignal,
): Promise<Leftovers> {
  const needed = new Needed(dropped === undefined);
  for (const kind of kKinds) {
    for (const record of chooseTable(store, kind).list({})) {
      if (record.key.source !== dropped) needed.add(kind, record);
    }
  }
  const files: Leftover[] = [];
  const leftAlone: string[] = [];
  for (const kind of kKinds) {
    const folder = dropped === undefined ? kind : `${kind}/${dropped}`;
    for await (const found of walk(store.root, folder, signal)) {
      if (found.link || !(kOwnNames.test(found.path) || needed.has(found.path))) {
        leftAlone.push(found.path);
      } else if (!needed.has(found.path)) {
        files.push({ path: found.path, bytes: (await stat(join(store.root, found.path))).size });
      }
    }
  }
  return { files, leftAlone };
}

export async function removeLeftovers(
  store: Store,
  files: readonly Leftover[],
  signal: AbortSignal,
): Promise<void> {
  for (const { path } of files) {
    signal.throwIfAborted();
    await rm(join(store.root, path), { force: true });
  }
}

/** What the records of a store need. */
class Needed {
  readonly #keepsPutAway: boolean;
  readonly #files = new Set<string>();
  readonly #stems = new Set<string>();
  readonly #unfinished = new Set<string>();

  constructor(keepsPutAway: boolean) {
    this.#keepsPutAway = keepsPutAway;
  }

  add(kind: FileKind, { key, state, file }: StoreRecord): void {
    if (file !== null) this.#addFile(file.path);
    if (!kUnfinished.has(state)) return;
    const unfinished = kPlaces.unfinished(kind, key);
    this.#unfinished.add(unfinished).add(archiveBeside(unfinished));
    // A run that was killed may have renamed the file before it updated the record.
    for (const extension of kFileExtensions[kind]) {
      this.#addFile(kPlaces.finished(kind, key, extension));
    }
  }

  /** Indices and overviews lie next to their file: a.lax or a.tif.aux.xml. */
  has(path: string): boolean {
    // Originals that --keep-original has moved away are there at the request of the user.
    if (this.#files.has(path) || (this.#keepsPutAway && kKeptOriginal.test(path))) return true;
    const part = /^(.*\/\.[^/]+?\.part)(\.[^/]*)?$/.exec(path)?.[1];
    if (part !== undefined) return this.#unfinished.has(part);
    if (path.endsWith('.lax')) return this.#stems.has(path.slice(0, -'.lax'.length));
    for (
      let dot = path.lastIndexOf('.');
      dot > path.lastIndexOf('/');
      dot = path.lastIndexOf('.', dot - 1)
    ) {
      if (this.#files.has(path.slice(0, dot))) return true;
    }
    return false;
  }

  #addFile(path: string): void {
    this.#files.add(path);
    this.#stems.add(path.slice(0, path.lastIndexOf('.')));
  }
}

/**
 * All plain files and links below a folder of the store; never follows a link, and never leaves the
 * store.
 */
async function* walk(
  root: string,
  folder: string,
  signal: AbortSignal,
): AsyncGenerator<{ path: string; link: boolean }> {
  if (!(await isInside(root, folder))) {
    yield { path: folder, link: true };
    return;
  }
  for (const entry of await listEntries(join(root, folder))) {
    signal.throwIfAborted();
    const path = `${folder}/${entry.name}`;
    if (entry.isDirectory()) yield* walk(root, path, signal);
    else yield { path, link: !entry.isFile() };
  }
}

async function listEntries(folder: string): Promise<Dirent[]> {
  try {
    return (await readdir(folder, { withFileTypes: true })).sort((a, b) =>
      a.name < b.name ? -1 : 1,
    );
  } catch (error) {
    if (systemCode(error) === 'ENOENT') return [];
    throw error;
  }
}

async function isInside(root: string, folder: string): Promise<boolean> {
  try {
    const way = relative(await realpath(root), await realpath(join(root, folder)));
    return way !== '..' && !way.startsWith(`..${sep}`);
  } catch (error) {
    if (systemCode(error) === 'ENOENT') return true;
    throw error;
  }
}

import type { Dirent } from 'node:fs';
import { readdir, realpath, rm, stat } from 'node:fs/promises';
import { join, relative, sep } from 'node:path';
import type { StoreRecord } from '../model/square.js';
import type { Store } from '../model/store.js';
import { archiveBeside, kFileExtensions, kPlaces, type FileKind } from '../store/layout.js';
import { systemCode } from '../util/errors.js';

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
    const table = kind === 'lidar' ? store.squares : store.orthophotos;
    for (const record of table.list({})) {
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

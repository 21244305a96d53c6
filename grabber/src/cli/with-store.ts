import { resolve } from 'node:path';
import { Option } from 'commander';
import { usage, causedError } from '../util/errors.js';
import type { RecordTable, Store } from '../model/store.js';
import { checkIsThere } from '../store/database.js';
import { storeLayout, type FileKind } from '../store/layout.js';
import { lockStore, openStore } from '../store/open-store.js';
import { makeFolder } from '../util/files.js';

export type StoreOption = { readonly store: string };

/** A new one for each command: commander keeps what it was given in it. */
export function storeOption(): Option {
  return new Option('--store <folder>', 'the store').env('TERRAVOX_STORE').makeOptionMandatory();
}

/**
 * Makes sure that a mistyped --source does not pass for a source without work.
 * @throws GrabberError USAGE unless the store has records of it
 */
export function checkSource(store: Store, source: string | undefined): void {
  if (source === undefined) return;
  const known = new Set(
    [...store.squares.tally(), ...store.orthophotos.tally()].map((row) => row.source),
  );
  if (known.has(source)) return;
  throw usage(
    `choose source: the store ${store.root} has nothing of "${source}"; allowed: ` +
      `${[...known].join(', ') || 'none yet'}`,
  );
}

/**
 * Opens a store for reading, while another process may write to it, and closes it after the work.
 */
export async function readStore<T>(
  folder: string,
  signal: AbortSignal,
  work: (store: Store) => T | Promise<T>,
): Promise<T> {
  const store = openStore(resolve(folder), { readOnly: true }, signal);
  try {
    return await work(store);
  } finally {
    store.close();
  }
}

/**
 * Opens an existing store for writing, under its lock, and closes it after the work.
 * @throws GrabberError STORE_LOCKED, or STORE_FORMAT where there is no store
 */
export async function writeStore<T>(
  folder: string,
  signal: AbortSignal,
  work: (store: Store) => Promise<T>,
): Promise<T> {
  checkIsThere(storeLayout(resolve(folder)).database);
  return makeStore(folder, signal, work);
}

/**
 * Does the same for a store that is created when it does not exist.
 * @throws GrabberError STORE_LOCKED, or STORE_IO where it cannot be created
 */
export async function makeStore<T>(
  folder: string,
  signal: AbortSignal,
  work: (store: Store) => Promise<T>,
): Promise<T> {
  const { root, lock } = storeLayout(resolve(folder));
  try {
    await makeFolder(root);
  } catch (error) {
    const allowed = 'a folder that can be written';
    throw causedError('STORE_IO', `make store folder ${root}`, error, allowed);
  }
  const unlock = lockStore(lock, signal);
  try {
    const store = openStore(root, {}, signal);
    try {
      return await work(store);
    } finally {
      store.close();
    }
  } finally {
    unlock();
  }
}

export function chooseTable(store: Store, kind: FileKind): RecordTable {
  return kind === 'lidar' ? store.squares : store.orthophotos;
}

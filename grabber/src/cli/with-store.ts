import { resolve } from 'node:path';
import { Option } from 'commander';
import type { Store } from '../model/store.js';
import { checkIsThere } from '../store/database.js';
import { storeLayout } from '../store/layout.js';
import { lockStore } from '../store/lock.js';
import { openStore } from '../store/open-store.js';
import { GrabberError, describeError } from '../util/errors.js';
import { makeFolder } from '../util/files.js';

export type StoreOption = { readonly store: string };

/** A new one for each command: commander keeps what it was given in it. */
export function storeOption(): Option {
  return new Option('--store <folder>', 'the store').env('TERRAVOX_STORE').makeOptionMandatory();
}

/** A slip in --source must not pass for nothing to do. @throws GrabberError USAGE unless the store has records of it */
export function checkSourceOf(store: Store, source: string | undefined): void {
  if (source === undefined) return;
  const known = new Set([...store.squares.tally(), ...store.orthophotos.tally()].map((row) => row.source));
  if (known.has(source)) return;
  throw new GrabberError('USAGE', `choose source: the store ${store.root} has nothing of "${source}"; allowed: ${[...known].join(', ') || 'none yet'}`);
}

/** Works with a store that others may be writing to. */
export async function readStore<T>(folder: string, signal: AbortSignal, work: (store: Store) => T | Promise<T>): Promise<T> {
  const store = openStore(resolve(folder), { readOnly: true }, signal);
  try {
    return await work(store);
  } finally {
    store.close();
  }
}

/** Works with a store that is there and that nobody else writes to meanwhile. @throws GrabberError STORE_LOCKED */
export async function writeStore<T>(folder: string, signal: AbortSignal, work: (store: Store) => Promise<T>): Promise<T> {
  checkIsThere(storeLayout(resolve(folder)).database);
  return makeStore(folder, signal, work);
}

/** The same for a store that is made where there is none. @throws GrabberError STORE_LOCKED, or STORE_IO where it cannot be made */
export async function makeStore<T>(folder: string, signal: AbortSignal, work: (store: Store) => Promise<T>): Promise<T> {
  const { root, lock } = storeLayout(resolve(folder));
  try {
    await makeFolder(root);
  } catch (error) {
    throw new GrabberError('STORE_IO', `make store folder ${root}: ${describeError(error)}; allowed: a folder that can be written`, {
      cause: error,
    });
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

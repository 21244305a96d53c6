import type Sqlite from 'better-sqlite3';
import type { Database } from 'better-sqlite3';
import type { Clock } from '../util/clock.js';
import { GrabberError } from '../util/errors.js';
import { asStoreError } from './store-error.js';

/** An open database with its place and its clock; what its tables share. */
export type Connection = {
  readonly db: Database;
  readonly path: string;
  readonly clock: Clock;
  readonly readOnly: boolean;
};

/** Runs reads; SQLite's errors become the store's. */
export function withReadErrors<T>({ path }: Connection, run: () => T): T {
  try {
    return run();
  } catch (error) {
    throw asStoreError('read', path, error);
  }
}

/** Made once a database: making one for every change costs as much as a small change. */
const kTransactions = new WeakMap<Database, Sqlite.Transaction<(run: () => unknown) => unknown>>();

function immediate(db: Database, run: () => unknown): unknown {
  let transaction = kTransactions.get(db);
  if (transaction === undefined) {
    transaction = db.transaction((inside: () => unknown) => inside());
    kTransactions.set(db, transaction);
  }
  return transaction.immediate(run);
}

/**
 * Runs changes as one transaction. Immediate: one that begins by reading could find at its first
 * write that another process was faster.
 */
export function inTransaction<T>({ db, path, readOnly }: Connection, run: () => T): T {
  if (readOnly) {
    throw new GrabberError(
      'STORE_IO',
      `write ${path}: the store was opened for reading; allowed: reads`,
    );
  }
  try {
    return immediate(db, run) as T;
  } catch (error) {
    throw asStoreError('write', path, error);
  }
}

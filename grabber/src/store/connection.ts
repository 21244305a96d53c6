import type { Clock } from '../util/clock.js';
import { GrabberError } from '../util/errors.js';
import { asStoreError } from './store-error.js';
import { runImmediate, type Database } from './sqlite.js';

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

/** Runs changes as one transaction. */
export function inTransaction<T>({ db, path, readOnly }: Connection, run: () => T): T {
  if (readOnly) {
    throw new GrabberError(
      'STORE_IO',
      `write ${path}: the store was opened for reading; allowed: reads`,
    );
  }
  try {
    return runImmediate(db, run);
  } catch (error) {
    throw asStoreError('write', path, error);
  }
}

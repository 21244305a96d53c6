import {
  DatabaseSync,
  type DatabaseSyncInstance as Database,
  type StatementSyncInstance as Statement,
} from '@photostructure/sqlite';
import type { Clock } from '../util/clock.js';
import { GrabberError, bothEnds, describeError, oneLine, systemCode } from '../util/errors.js';

// SQLite with the interface of node:sqlite, which Node.js 20 does not have: one for every version.
export { DatabaseSync, type Database, type Statement };

/** The first value of the first row; undefined when there is none. */
export function readValue(db: Database, sql: string): unknown {
  const row = db.prepare(sql).get() as Readonly<Record<string, unknown>> | undefined;
  return Object.values(row ?? {})[0];
}

/**
 * Runs all of `run`, or nothing of it when it throws. Immediate: a transaction that begins by
 * reading could find at its first write that another process was faster.
 */
export function runImmediate<T>(db: Database, run: () => T): T {
  db.exec('BEGIN IMMEDIATE');
  try {
    const result = run();
    db.exec('COMMIT');
    return result;
  } catch (error) {
    // A full disk has ended it already.
    if (db.isTransaction) db.exec('ROLLBACK');
    throw error;
  }
}

/** The name of the result of an SQLite call, such as SQLITE_FULL; undefined for other errors. */
export function sqliteCode(error: unknown): string | undefined {
  return error instanceof Error && 'sqliteCodeName' in error
    ? String(error.sqliteCodeName)
    : undefined;
}

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

/** Longest text of an error that a record keeps; servers may say more. */
const kMaxMessageLength = 2000;

/** A message from anywhere, as one line that fits a record. */
export function recordedMessage(text: string): string {
  return bothEnds(oneLine(text), kMaxMessageLength);
}

/** An error of SQLite as one of the store; everything else is passed on as it is. */
export function asStoreError(attempt: string, path: string, error: unknown): unknown {
  // Of a whole number that JavaScript cannot hold.
  const isTooLarge = systemCode(error) === 'ERR_OUT_OF_RANGE';
  const code = isTooLarge ? 'ERR_OUT_OF_RANGE' : sqliteCode(error);
  if (code === undefined) return error;
  const why = `${attempt} ${path}: ${describeError(error)} (${code})`;
  // The statements are fixed, so a plain SQLITE_ERROR means a table or a column that is not there.
  if (isTooLarge || ['SQLITE_CORRUPT', 'SQLITE_NOTADB', 'SQLITE_ERROR'].includes(code)) {
    const allowed = 'a sound GeoPackage that the grabber made';
    return new GrabberError('STORE_DAMAGED', `${why}; allowed: ${allowed}`, { cause: error });
  }
  return new GrabberError('STORE_IO', why, { cause: error });
}

import type { Store } from '../model/store.js';
import { kSystemClock, type Clock } from '../util/clock.js';
import {
  hasLog,
  removeEmptyLog,
  openForReading,
  openForWriting,
  migrationsFolder,
  readMigrations,
} from './database.js';
import { storeLayout } from './layout.js';
import { RecordTable } from './record-table.js';
import { asStoreError, DatabaseSync, sqliteCode, type Database } from './sqlite.js';
import { GrabberError, causedError } from '../util/errors.js';

export type OpenStoreOptions = {
  /** The store must be there; it may be written to by another process meanwhile. */
  readonly readOnly?: boolean;
  readonly clock?: Clock;
  /** Folder of `NNNN_name.sql`; the package's unless a test has its own. */
  readonly migrations?: string;
};

/**
 * Opens a store. For writing it is created when it does not exist, and migrated when it is older. A
 * writer holds the lock of the store (lock.ts), which this function does not take.
 * @throws GrabberError STORE_FORMAT (no store, or of a newer grabber), STORE_DAMAGED, STORE_IO
 */
export function openStore(root: string, options: OpenStoreOptions, signal: AbortSignal): Store {
  signal.throwIfAborted();
  const clock = options.clock ?? kSystemClock;
  const { database: path } = storeLayout(root);
  const migrations = readMigrations(options.migrations ?? migrationsFolder());
  const readOnly = options.readOnly ?? false;
  const logBefore = readOnly && hasLog(path);
  const db = readOnly
    ? openForReading(path, migrations)
    : openForWriting(root, path, migrations, clock.now());
  const connection = { db, path, clock, readOnly };
  try {
    const squares = new RecordTable(connection, 'squares');
    if (!readOnly) squares.drawUndrawn();
    return {
      root,
      squares,
      orthophotos: new RecordTable(connection, 'orthophotos'),
      close: () => {
        db.close();
        if (readOnly && !logBefore) removeEmptyLog(path);
      },
    };
  } catch (error) {
    // A table or a column is missing.
    db.close();
    throw asStoreError('open store', path, error);
  }
}

/**
 * Locks a store, so that two runs do not write the same files. The lock is SQLite's on a database
 * of its own, which the system releases when the process ends in any way. The file stays, and its
 * content means nothing.
 * @return releases the lock
 * @throws GrabberError STORE_LOCKED, or STORE_IO where the file cannot be written
 */
export function lockStore(path: string, signal: AbortSignal): () => void {
  signal.throwIfAborted();
  let database: Database | undefined;
  try {
    database = new DatabaseSync(path, { timeout: 0 });
    database.exec('BEGIN EXCLUSIVE');
  } catch (error) {
    database?.close();
    if (sqliteCode(error) === 'SQLITE_BUSY') {
      throw new GrabberError(
        'STORE_LOCKED',
        `lock store: another grabber holds ${path}; allowed: one grabber at a time`,
      );
    }
    throw causedError('STORE_IO', `lock store ${path}`, error, 'a folder that can be written');
  }
  const held = database;
  return () => held.close();
}

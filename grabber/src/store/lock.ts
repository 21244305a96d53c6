import { GrabberError, describeError } from '../util/errors.js';
import { DatabaseSync, sqliteCode, type Database } from './sqlite.js';

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
    throw new GrabberError(
      'STORE_IO',
      `lock store ${path}: ${describeError(error)}; allowed: a folder that can be written`,
      { cause: error },
    );
  }
  const held = database;
  return () => {
    held.close();
  };
}

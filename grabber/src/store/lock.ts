import Sqlite from 'better-sqlite3';
import { GrabberError, describeError, systemCode } from '../util/errors.js';

/**
 * Two runs on one store would take turns at the same files, so that a run holds a lock: that of SQLite on a database of its own, which
 * the system lets go when the process ends, however it ends. The file stays; it says nothing.
 * @return releases the lock
 * @throws GrabberError STORE_LOCKED
 */
export function lockStore(path: string, signal: AbortSignal): () => void {
  signal.throwIfAborted();
  let database: Sqlite.Database | undefined;
  try {
    database = new Sqlite(path, { timeout: 0 });
    database.exec('BEGIN EXCLUSIVE');
  } catch (error) {
    database?.close();
    if (systemCode(error) === 'SQLITE_BUSY') {
      throw new GrabberError('STORE_LOCKED', `lock store: another grabber holds ${path}; allowed: one grabber at a time`);
    }
    throw new GrabberError('STORE_IO', `lock store ${path}: ${describeError(error)}; allowed: a folder that can be written`, { cause: error });
  }
  const held = database;
  return () => {
    held.close();
  };
}

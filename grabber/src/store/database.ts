import { mkdirSync, statSync } from 'node:fs';
import { pathToFileURL } from 'node:url';
import { GrabberError, describeError } from '../util/errors.js';
import { checkNotNewer, migrate, schemaVersion, type Migration } from './migrations.js';
import { asStoreError } from './store-error.js';
import { DatabaseSync, sqliteCode, type Database } from './sqlite.js';

/** Another process writes in short transactions; this is far longer than any of them. */
const kBusyTimeout_ms = 10_000;

/**
 * Opens or makes the database of a store for writing, at the newest version.
 * @throws GrabberError
 */
export function openForWriting(
  root: string,
  path: string,
  migrations: readonly Migration[],
  now: Date,
): Database {
  try {
    mkdirSync(root, { recursive: true });
  } catch (error) {
    throw new GrabberError(
      'STORE_IO',
      `make store folder ${root}: ${describeError(error)}; allowed: a folder that can be written`,
      { cause: error },
    );
  }
  return opened(
    path,
    () => new DatabaseSync(path, { timeout: kBusyTimeout_ms }),
    (db) => {
      // Checked before anything is changed, since it may be a foreign database.
      checkNotNewer(schemaVersion(db, path), migrations.length, path);
      db.exec('PRAGMA journal_mode = WAL; PRAGMA synchronous = NORMAL; PRAGMA foreign_keys = ON');
      migrate(db, path, migrations, now);
    },
  );
}

/**
 * Opens the database of a store that is there, also while another process writes to it.
 * @throws GrabberError
 */
export function openForReading(path: string, migrations: readonly Migration[]): Database {
  checkIsThere(path);
  return opened(
    path,
    () => readable(path),
    (db) => {
      const version = schemaVersion(db, path);
      checkNotNewer(version, migrations.length, path);
      if (version === migrations.length) return;
      throw new GrabberError(
        'STORE_FORMAT',
        `open store ${path}: its version is ${version}; allowed: ${migrations.length}; ` +
          '"resume" brings it there',
      );
    },
  );
}

/** @throws GrabberError STORE_FORMAT when there is no database */
export function checkIsThere(path: string): void {
  if (statSync(path, { throwIfNoEntry: false })?.isFile() === true) return;
  throw new GrabberError(
    'STORE_FORMAT',
    `open store ${path}: no such file; allowed: a folder that the grabber fills`,
  );
}

/**
 * Opens a database for reading. Readers share memory with writers through a file next to the
 * database, which cannot be created on a read-only disk.
 */
function readable(path: string): Database {
  const db = new DatabaseSync(path, { readOnly: true, timeout: kBusyTimeout_ms });
  try {
    db.exec('PRAGMA schema_version');
    return db;
  } catch (error) {
    db.close();
    const code = sqliteCode(error) ?? '';
    // What is in a log that cannot be read would be missing, so then it is an error.
    if (
      !/^SQLITE_(CANTOPEN|READONLY)/.test(code) ||
      (statSync(`${path}-wal`, { throwIfNoEntry: false })?.size ?? 0) > 0
    ) {
      throw error;
    }
    return new DatabaseSync(`${pathToFileURL(path).href}?immutable=1`, { readOnly: true });
  }
}

/**
 * Whether the files that users of a database share exist next to it: its log, and the index of the
 * log.
 */
export function hasLog(path: string): boolean {
  return ['-wal', '-shm'].some(
    (end) => statSync(`${path}${end}`, { throwIfNoEntry: false }) !== undefined,
  );
}

/**
 * Removes an empty log that readers have created: only a process that can write may remove it, as
 * the last one to close the database. SQLite makes sure that no other process uses it. On a
 * read-only disk it stays.
 */
export function removeEmptyLog(path: string): void {
  if (!hasLog(path)) return;
  try {
    const db = new DatabaseSync(`${pathToFileURL(path).href}?mode=rw`, { timeout: 0 });
    try {
      db.exec('PRAGMA schema_version');
    } finally {
      db.close();
    }
  } catch {
    // Another process uses it, or the disk is read-only.
  }
}

function opened(path: string, open: () => Database, prepare: (db: Database) => void): Database {
  let db: Database | undefined;
  try {
    db = open();
    prepare(db);
    return db;
  } catch (error) {
    db?.close();
    throw asStoreError('open store', path, error);
  }
}

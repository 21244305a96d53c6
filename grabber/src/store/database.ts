import { mkdirSync, statSync, readFileSync, readdirSync } from 'node:fs';
import { pathToFileURL } from 'node:url';
import { join } from 'node:path';
import { GrabberError, causedError } from '../util/errors.js';
import {
  asStoreError,
  DatabaseSync,
  sqliteCode,
  type Database,
  readValue,
  runImmediate,
} from './sqlite.js';
import { readPackageInfo } from '../util/package-info.js';

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
    const allowed = 'a folder that can be written';
    throw causedError('STORE_IO', `make store folder ${root}`, error, allowed);
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

/** "GPKG" */
export const kApplicationId = 0x47504b47;

export type Migration = { readonly version: number; readonly name: string; readonly sql: string };

export function migrationsFolder(): string {
  return join(readPackageInfo().root, 'migrations');
}

/** Files `NNNN_name.sql`, numbered from 1 without a gap. */
export function readMigrations(folder: string): Migration[] {
  const names = readdirSync(folder)
    .filter((name) => name.endsWith('.sql'))
    .sort();
  return names.map((name, index) => {
    const version = Number(/^(\d{4})_[a-z0-9_]+\.sql$/.exec(name)?.[1]);
    if (version !== index + 1) {
      throw new GrabberError(
        'CONFIG',
        `read migrations ${folder}: file ${index + 1} is ${name}; allowed: ` +
          `${String(index + 1).padStart(4, '0')}_<name>.sql`,
      );
    }
    return {
      version,
      name: name.slice(0, -'.sql'.length),
      sql: readFileSync(join(folder, name), 'utf8'),
    };
  });
}

/**
 * What version an open database has; 0 for an empty one.
 * @throws GrabberError STORE_FORMAT when it is something else than a store
 */
export function schemaVersion(db: Database, path: string): number {
  const objects = readValue(db, 'SELECT count(*) FROM sqlite_master');
  const application = readValue(db, 'PRAGMA application_id');
  if (objects === 0 && application === 0) return 0;
  const refuse = (what: string): never => {
    throw new GrabberError(
      'STORE_FORMAT',
      `open store ${path}: ${what}; allowed: a fishnet.gpkg that the grabber made`,
    );
  };
  if (application !== kApplicationId) {
    refuse(`its application_id is ${String(application)}, no GeoPackage`);
  }
  const ours = readValue(
    db,
    "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name = 'terravox_schema'",
  );
  if (ours !== 1) refuse('a GeoPackage without the table terravox_schema');
  const version = readValue(db, 'SELECT max(version) FROM terravox_schema');
  if (typeof version !== 'number' || !Number.isInteger(version) || version < 1) {
    return refuse(`its version is ${String(version)}`);
  }
  return version;
}

/** @throws GrabberError STORE_FORMAT for a store that a newer grabber made */
export function checkNotNewer(version: number, newest: number, path: string): void {
  if (version <= newest) return;
  throw new GrabberError(
    'STORE_FORMAT',
    `open store ${path}: its version is ${version}; allowed: up to ${newest}; a newer ` +
      'grabber has made it',
  );
}

/**
 * Brings a database to the newest version: all steps or none.
 * @return how many steps it took
 */
export function migrate(
  db: Database,
  path: string,
  migrations: readonly Migration[],
  now: Date,
): number {
  return runImmediate(db, () => {
    // Read again within the transaction, since another process may have migrated meanwhile.
    const version = schemaVersion(db, path);
    checkNotNewer(version, migrations.length, path);
    const steps = migrations.slice(version);
    for (const step of steps) {
      db.exec(step.sql);
      db.prepare('INSERT INTO terravox_schema (version, name, migrated_at) VALUES (?, ?, ?)').run(
        step.version,
        step.name,
        now.toISOString(),
      );
    }
    return steps.length;
  });
}

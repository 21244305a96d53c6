import { readFileSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { GrabberError } from '../util/errors.js';
import { readPackageInfo } from '../util/package-info.js';
import { readValue, runImmediate, type Database } from './sqlite.js';

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

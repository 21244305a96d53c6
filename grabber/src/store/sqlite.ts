import {
  DatabaseSync,
  type DatabaseSyncInstance as Database,
  type StatementSyncInstance as Statement,
} from '@photostructure/sqlite';

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

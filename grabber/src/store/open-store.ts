import type { Store } from '../model/store.js';
import { kSystemClock, type Clock } from '../util/clock.js';
import { AreaTable } from './area-table.js';
import {
  checkIsThere,
  hasLog,
  removeEmptyLog,
  openForReading,
  openForWriting,
} from './database.js';
import { storeLayout } from './layout.js';
import { migrationsFolder, readMigrations } from './migrations.js';
import { RecordTable } from './record-table.js';
import { asStoreError } from './store-error.js';

export type OpenStoreOptions = {
  /** The store must be there; it may be written to by another process meanwhile. */
  readonly readOnly?: boolean;
  /** The store must be there, and is opened for writing. */
  readonly mustExist?: boolean;
  readonly clock?: Clock;
  /** Folder of `NNNN_name.sql`; the package's unless a test has its own. */
  readonly migrations?: string;
};

/** What the grabber's own commands may use beyond the contract. */
export type OpenStore = Store & {
  readonly squares: RecordTable;
  readonly orthophotos: RecordTable;
};

/**
 * Opens a store. For writing it is created when it does not exist, and migrated when it is older. A
 * writer holds the lock of the store (lock.ts), which this function does not take.
 * @throws GrabberError STORE_FORMAT (no store, or of a newer grabber), STORE_DAMAGED, STORE_IO
 */
export function openStore(root: string, options: OpenStoreOptions, signal: AbortSignal): OpenStore {
  signal.throwIfAborted();
  const clock = options.clock ?? kSystemClock;
  const { database: path } = storeLayout(root);
  const migrations = readMigrations(options.migrations ?? migrationsFolder());
  const readOnly = options.readOnly ?? false;
  if (options.mustExist === true) checkIsThere(path);
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
      areas: new AreaTable(connection),
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

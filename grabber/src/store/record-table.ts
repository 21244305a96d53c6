import {
  findGround,
  kStates,
  type CatalogueSquare,
  type RecordKey,
  type State,
  type StoredFile,
  type StoreRecord,
  type Terms,
  type Learned,
  type Place,
  type RecordFilter,
  type RecordTable as RecordTableContract,
  type Verified,
} from '../model/store.js';
import { GrabberError } from '../util/errors.js';
import {
  inTransaction,
  withReadErrors,
  type Connection,
  recordedMessage,
  type Statement,
} from './sqlite.js';
import { Contents, Extent, encodeFootprint } from './geometry.js';
import type { FileKind } from './layout.js';
import { Learner } from './learner.js';
import { toFacts, toKey, recordOfRow, RowReader, type Row } from './record-row.js';
import { recordSql, type RecordSql } from './record-sql.js';

/**
 * How long a square counts as missing. A source may publish it later, but requesting all holes in
 * every run would burden it.
 */
const kMissingFor_ms = 30 * 24 * 3600 * 1000;

/**
 * Squares or orthophotos: the same columns in two tables. Statements are prepared once; each call
 * is one transaction.
 */
export class RecordTable implements RecordTableContract {
  readonly #connection: Connection;
  readonly #table: 'squares' | 'orthophotos';
  readonly #kind: FileKind;
  readonly #sql: Readonly<Record<keyof RecordSql, Statement>>;
  readonly #contents: Contents;
  readonly #learner: Learner;

  constructor(connection: Connection, table: 'squares' | 'orthophotos') {
    this.#connection = connection;
    this.#table = table;
    this.#kind = table === 'squares' ? 'lidar' : 'ortho';
    const entries = Object.entries(recordSql(table)).map(
      ([name, text]) => [name, connection.db.prepare(text)] as const,
    );
    this.#sql = Object.fromEntries(entries) as Record<keyof RecordSql, Statement>;
    this.#contents = new Contents(connection.db, table);
    this.#learner = new Learner(connection.db, table, this.#sql, this.#contents);
  }

  learn(
    source: string,
    grid: string,
    gridCrs: string | null,
    terms: Terms,
    squares: Iterable<CatalogueSquare>,
  ): Learned {
    return inTransaction(this.#connection, () =>
      this.#learner.learn({ source, grid, gridCrs, terms, now: this.#now() }, squares),
    );
  }

  /** Draws squares whose files were fetched by a grabber that did not draw them. */
  drawUndrawn(): void {
    const keys = withReadErrors(this.#connection, () => this.#sql.undrawn.all() as RecordKey[]);
    if (keys.length === 0) return;
    inTransaction(this.#connection, () => {
      for (const key of keys) this.#draw(key);
    });
  }

  get(key: RecordKey): StoreRecord | undefined {
    return withReadErrors(this.#connection, () => {
      const row = this.#sql.get.get(toKey(key)) as Row | undefined;
      return row === undefined ? undefined : this.#record(row);
    });
  }

  list(filter: RecordFilter): StoreRecord[] {
    return this.#records(this.#sql.list, filter);
  }

  unfinished(filter: RecordFilter): StoreRecord[] {
    return this.#records(this.#sql.unfinished, filter);
  }

  count(filter: RecordFilter): number {
    return withReadErrors(
      this.#connection,
      () =>
        Object.values(this.#sql.count.get(toParameters(filter)) as Record<string, number>)[0] ?? 0,
    );
  }

  tally(): { source: string; state: State; count: number; bytes: number; points: number }[] {
    return withReadErrors(this.#connection, () =>
      (this.#sql.tally.all() as Row[]).map((row) => {
        const read = new RowReader(row, `${this.#table} by source and state`);
        return {
          source: read.text('source'),
          state: read.readChoice('shown', kStates),
          count: read.count('count'),
          bytes: read.number('bytes'),
          points: read.number('points'),
        };
      }),
    );
  }

  places(): Place[] {
    return withReadErrors(this.#connection, () =>
      (this.#sql.places.all() as Row[]).map((row) => {
        const read = new RowReader(row, `${this.#table} of ${String(row['source'])}`);
        const bounds = [
          read.number('west'),
          read.number('south'),
          read.number('east'),
          read.number('north'),
        ] as const;
        return {
          source: read.text('source'),
          grid: read.text('grid'),
          state: read.readChoice('state', kStates),
          bounds,
        };
      }),
    );
  }

  lastErrors(limit: number): StoreRecord[] {
    return withReadErrors(this.#connection, () =>
      (this.#sql.errors.all({ limit }) as Row[]).map((row) => this.#record(row)),
    );
  }

  want(keys: Iterable<RecordKey>, again = false): number {
    return inTransaction(this.#connection, () => {
      const now = this.#now();
      const stale = new Date(Date.parse(now) - kMissingFor_ms).toISOString();
      let became = 0;
      for (const key of keys) {
        const { changes } = this.#sql.want.run({ ...toKey(key), now, stale, again: again ? 1 : 0 });
        if (changes === 0 && this.#sql.learned.get(toKey(key)) === undefined) {
          throw this.#noRecord('want', key);
        }
        became += changes;
      }
      if (became > 0) this.#contents.touch(now);
      return became;
    });
  }

  begin(key: RecordKey, url: string): void {
    this.#change('begin', key, { url });
  }

  located(key: RecordKey, block: string | null, urls: readonly string[]): void {
    this.#change('located', key, { block, urls: JSON.stringify(urls) });
  }

  fetched(key: RecordKey, file: StoredFile): void {
    this.#change('fetched', key, { now: this.#now(), ...file });
  }

  verified(key: RecordKey, facts: Verified): void {
    this.#change('verified', key, { now: this.#now(), ...toFacts(facts) });
  }

  converted(key: RecordKey, file: StoredFile, facts: Verified): void {
    this.#change('converted', key, { now: this.#now(), ...file, ...toFacts(facts) });
  }

  missing(key: RecordKey, reason: string): void {
    this.#change('missing', key, {
      now: this.#now(),
      code: 'MISSING',
      message: recordedMessage(reason),
    });
  }

  failed(key: RecordKey, code: string, message: string): void {
    this.#change('failed', key, { now: this.#now(), code, message: recordedMessage(message) });
  }

  forget(key: RecordKey): void {
    this.#change('forget', key, {});
  }

  #change(
    call: Exclude<keyof RecordSql, 'want'>,
    key: RecordKey,
    values: Readonly<Record<string, unknown>>,
  ): void {
    inTransaction(this.#connection, () => {
      if (this.#sql[call].run({ ...values, ...toKey(key) }).changes === 0) {
        throw this.#noRecord(call, key);
      }
      if (call === 'verified' || call === 'converted') this.#draw(key);
      this.#contents.touch(this.#now());
    });
  }

  /** Draws a square that its catalogue puts nowhere where the points of its file are. */
  #draw(key: RecordKey): void {
    const record = this.#record(this.#sql.get.get(toKey(key)) as Row);
    if (record.bounds !== null) return;
    const ground = findGround(record);
    const geom = encodeFootprint(ground?.bounds ?? null, ground?.crs ?? null);
    const { fid, geom: old } = this.#sql.learned.get(toKey(key)) as {
      fid: number;
      geom: Uint8Array | null;
    };
    if (geom === null || old === null ? geom === old : geom.equals(old)) return;
    this.#sql.redraw.run({ geom, fid });
    const extent = new Extent();
    extent.add(geom);
    if (old === null && extent.envelope !== undefined) this.#contents.grow(extent.envelope);
    else this.#contents.measure();
  }

  #records(statement: Statement, filter: RecordFilter): StoreRecord[] {
    return withReadErrors(this.#connection, () => {
      const records: StoreRecord[] = [];
      for (const row of statement.iterate(toParameters(filter)) as Iterable<Row>) {
        records.push(this.#record(row));
      }
      return records;
    });
  }

  #record(row: Row): StoreRecord {
    return recordOfRow(row, this.#table, this.#kind);
  }

  #noRecord(call: string, key: RecordKey): GrabberError {
    const known = this.#sql.learned.get(toKey(key)) !== undefined;
    const allowed = known ? 'a record whose file is there' : 'a record that was learnt before';
    return new GrabberError(
      'STORE_CONFLICT',
      `record "${call}" of ${this.#shown(key)}: ` +
        `${known ? 'it has no file' : 'no such record'}; allowed: ${allowed}`,
    );
  }

  #shown(key: RecordKey): string {
    return `${this.#table} ${key.source}/${key.grid}/${key.name}`;
  }

  #now(): string {
    return this.#connection.clock.now().toISOString();
  }
}

function toParameters(filter: RecordFilter): Record<string, string | number | null> {
  const list = (values: readonly string[] | undefined): string | null =>
    values === undefined ? null : JSON.stringify(values);
  const { source = null, grid = null } = filter;
  return {
    source,
    grid,
    states: list(filter.states),
    names: list(filter.names),
    usable: filter.usable === true ? 1 : null,
  };
}

import type { CatalogueSquare, RecordKey, Terms, Learned } from '../model/store.js';
import { type Contents, Extent, encodeFootprint } from './geometry.js';
import { checkedName } from './layout.js';
import { kLearned, type RecordSql } from './record-sql.js';
import { RowReader, type Row } from './record-row.js';
import type { Database, Statement } from './sqlite.js';

const kPlaced: readonly LearnedColumn[] = ['west', 'south', 'east', 'north', 'grid_crs'];

/** A catalogue as it is learnt. */
export type Catalogued = {
  readonly source: string;
  readonly grid: string;
  readonly gridCrs: string | null;
  readonly terms: Terms;
  readonly now: string;
};

/** Updates a table of records from catalogues; within the caller's transaction. */
export class Learner {
  readonly #table: string;
  readonly #sql: Readonly<Record<keyof RecordSql, Statement>>;
  readonly #contents: Contents;
  readonly #anyOf: Statement;

  constructor(
    db: Database,
    table: string,
    sql: Readonly<Record<keyof RecordSql, Statement>>,
    contents: Contents,
  ) {
    this.#table = table;
    this.#sql = sql;
    this.#contents = contents;
    this.#anyOf = db.prepare(`SELECT 1 FROM ${table} WHERE source = ? AND grid = ? LIMIT 1`);
  }

  learn(from: Catalogued, squares: Iterable<CatalogueSquare>): Learned {
    const source = checkedName('source', from.source);
    const grid = checkedName('grid', from.grid);
    // A new catalogue has hardly any square in the store; looking up each would take a third of the
    // time.
    const fresh = this.#anyOf.get(source, grid) === undefined;
    const extent = new Extent();
    let added = 0;
    let changed = 0;
    let moved = false;
    for (const square of squares) {
      const key = { source, grid, name: checkedName('name', square.name) };
      const old = fresh ? undefined : this.#old(key);
      if (old === undefined && this.#add(key, square, from, extent)) {
        ++added;
        continue;
      }
      const outcome = this.#update(key, square, from, old ?? this.#old(key));
      if (outcome !== 'same') ++changed;
      moved ||= outcome === 'moved';
    }
    if (moved) this.#contents.measure();
    else if (extent.envelope !== undefined) this.#contents.grow(extent.envelope);
    if (added + changed > 0) this.#contents.touch(from.now);
    return { added, changed };
  }

  #old(key: RecordKey): Row | undefined {
    return this.#sql.learned.get(key) as Row | undefined;
  }

  /** @return false when it is there already */
  #add(key: RecordKey, square: CatalogueSquare, from: Catalogued, extent: Extent): boolean {
    const geom = encodeFootprint(square.bounds, from.gridCrs);
    const { crs } = from.terms;
    const columns = toColumns(square, from.gridCrs, from.terms);
    const values = kLearned.map((name) => columns[name]);
    const { changes } = this.#sql.insert.run(
      key.source,
      key.grid,
      key.name,
      geom,
      crs,
      from.now,
      ...values,
    );
    if (changes === 1) extent.add(geom);
    return changes === 1;
  }

  #update(
    key: RecordKey,
    square: CatalogueSquare,
    from: Catalogued,
    old: Row | undefined,
  ): 'same' | 'changed' | 'moved' {
    if (old === undefined) return 'same';
    const columns = keepLocatedAddress(toColumns(square, from.gridCrs, from.terms), old);
    if (!differs(columns, old, kLearned)) return 'same';
    const known = new RowReader(old, `${this.#table} ${key.source}/${key.grid}/${key.name}`).texts(
      'warnings',
    );
    const warnings = isNewerFile(columns, old)
      ? withWarning(known, kNewerFile)
      : JSON.stringify(known);
    this.#sql.relearn.run({ ...columns, warnings, fid: old['fid'] });
    if (!differs(columns, old, kPlaced)) return 'changed';
    this.#sql.redraw.run({
      geom: encodeFootprint(square.bounds, from.gridCrs),
      fid: old['fid'],
    });
    return 'moved';
  }
}

export type LearnedColumn = (typeof kLearned)[number];
export type LearnedColumns = Record<LearnedColumn, string | number | null>;

export const kNewerFile = 'the source has a newer file';

/** What a catalogue says of a square, as columns. */
export function toColumns(
  square: CatalogueSquare,
  gridCrs: string | null,
  terms: Terms,
): LearnedColumns {
  const [west, south, east, north] = square.bounds ?? [null, null, null, null];
  return {
    block: square.block,
    west,
    south,
    east,
    north,
    grid_crs: gridCrs,
    urls: JSON.stringify(square.urls),
    expected_bytes: square.bytes,
    expected_sha256: square.sha256?.toLowerCase() ?? null,
    member: square.member,
    published: square.published,
    source_crs: terms.crs,
    class_table: terms.classTable,
    licence: terms.licence,
    attribution: terms.attribution,
  };
}

/**
 * A catalogue without the address must not erase the one that was found by trying.
 */
export function keepLocatedAddress(columns: LearnedColumns, old: Row): LearnedColumns {
  if (columns.urls !== '[]') return columns;
  return {
    ...columns,
    urls: old['urls'] as string,
    block: columns.block ?? (old['block'] as string | null),
  };
}

export function differs(
  columns: LearnedColumns,
  old: Row,
  names: readonly LearnedColumn[],
): boolean {
  return names.some((name) => columns[name] !== old[name]);
}

/**
 * Whether the catalogue has a newer file. Compares only what is known on both sides: a catalogue
 * that begins to give lengths has no newer files for that reason.
 */
export function isNewerFile(columns: LearnedColumns, old: Row): boolean {
  const changed = (name: LearnedColumn): boolean =>
    old[name] !== null && columns[name] !== null && old[name] !== columns[name];
  return old['file_path'] !== null && (changed('expected_bytes') || changed('expected_sha256'));
}

/** @return the warnings of the row as JSON, with `warning` once */
export function withWarning(warnings: readonly string[], warning: string): string {
  return JSON.stringify(warnings.includes(warning) ? warnings : [...warnings, warning]);
}

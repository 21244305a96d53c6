import type { CatalogueSquare, Terms } from '../model/square.js';
import type { kLearned } from './record-sql.js';
import type { Row } from './row-reader.js';

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

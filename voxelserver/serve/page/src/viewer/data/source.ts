import type { BoxArrays } from './box-arrays.js';
import type { ColumnKey } from './columns.js';
import type { DataError } from '../../http/errors.js';
import type { Facts } from './facts.js';

/** A box of a column; a hole is a box that could not be made. */
export type ColumnBox = BoxArrays | 'air' | 'hole';

/**
 * A column of boxes: `boxes[i]` has by = `byBegin` + i. Below and above is air; without boxes, all
 * of it is air.
 */
export type Column = ColumnKey & { readonly byBegin: number; readonly boxes: readonly ColumnBox[] };

/** A column, or why there is none. */
export type ColumnResult =
  { readonly column: Column } | { readonly failed: ColumnKey; readonly error: DataError };

/** A source of columns of boxes: an archive, or a voxel server. */
export type BoxSource = {
  readonly facts: Facts;
  /**
   * Loads what companions() needs to know about a column: the index.
   * @param others columns of which it may be asked next
   * @throws DataError; the reason of `signal`
   */
  prepare(column: ColumnKey, others: readonly ColumnKey[], signal: AbortSignal): Promise<void>;
  /**
   * Chooses what is fetched together with a column that prepare() has been called for.
   * @param candidates most wanted first
   * @return those that take no further request, in any order
   */
  companions(column: ColumnKey, candidates: readonly ColumnKey[]): readonly ColumnKey[];
  /**
   * Fetches columns, one request after the other. Gives one result for each, in any order; one that
   * fails does not end the others.
   * @throws DataError `changed`; the reason of `signal`
   */
  columns(
    columns: readonly ColumnKey[],
    signal: AbortSignal,
  ): AsyncGenerator<ColumnResult, void, undefined>;
};

/** Of the arrays of a column: larger ones are refused. */
export const kMaxColumnBytes = 64 * 1024 * 1024;

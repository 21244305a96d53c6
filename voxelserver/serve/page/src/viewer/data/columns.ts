import { bytesOfArrays, type BoxArrays, type BoxKey } from './box-arrays.js';
import { DataError } from '../../http/errors.js';
import { boxRange, hasLevel, isEmpty, type Facts } from './facts.js';

/** A column of boxes of a level: bx and bz count boxes of 64 x 64 voxels of that level. */
export type ColumnKey = { readonly level: number; readonly bx: number; readonly bz: number };

export const nameOfColumn = ({ level, bx, bz }: ColumnKey): string => `${level}/${bx}/${bz}`;

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

/**
 * The boxes of a column that may hold something, from the bottom up; none outside of the bounds.
 * @throws DataError `missing` for a level that the world does not have
 */
export function listKeys(column: ColumnKey, facts: Facts): BoxKey[] {
  const { world } = facts;
  const { level, bx, bz } = column;
  if (!hasLevel(facts, level)) {
    throw new DataError(
      'missing',
      `read column ${nameOfColumn(column)}: no such level; allowed: 0 to ${world.levels - 1}`,
    );
  }
  if (isEmpty(world)) return [];
  const { min, max } = boxRange(world, level);
  const isInside = bx >= min[0] && bx < max[0] && bz >= min[2] && bz < max[2];
  if (!isInside || !Number.isInteger(bx) || !Number.isInteger(bz)) return [];
  const keys: BoxKey[] = [];
  for (let by = min[1]; by < max[1]; ++by) keys.push({ level, bx, by, bz });
  return keys;
}

/** Puts the boxes of a column together as they arrive, in any order. */
export class ColumnBuilder {
  readonly key: ColumnKey;
  readonly #boxes = new Map<number, ColumnBox>();
  #bytes = 0;

  constructor(key: ColumnKey) {
    this.key = key;
  }

  /** @throws DataError `too-large` for a column that takes more memory than it should */
  add(by: number, box: ColumnBox): void {
    this.#boxes.set(by, box);
    this.#bytes += bytesOfBox(box);
    if (this.#bytes > kMaxColumnBytes) {
      throw new DataError(
        'too-large',
        `read column ${nameOfColumn(this.key)}: more than ${kMaxColumnBytes} bytes of boxes`,
      );
    }
  }

  /** The column: from the lowest to the highest box that is not air. */
  finish(): Column {
    const heights = [...this.#boxes].filter(([, box]) => box !== 'air').map(([by]) => by);
    const { level, bx, bz } = this.key;
    if (heights.length === 0) return { level, bx, bz, byBegin: 0, boxes: [] };
    heights.sort((a, b) => a - b);
    const byBegin = heights[0]!;
    const count = heights[heights.length - 1]! - byBegin + 1;
    const boxes = Array.from({ length: count }, (_, i) => this.#boxes.get(byBegin + i) ?? 'air');
    return { level, bx, bz, byBegin, boxes };
  }
}

/** Of a place in a column, air included: an entry in each of the lists that name it. */
const kSlotBytes = 64;

function bytesOfBox(box: ColumnBox): number {
  return typeof box === 'string' ? 0 : bytesOfArrays(box);
}

export function bytesOfColumn({ boxes }: Column): number {
  return boxes.reduce((sum, box) => sum + bytesOfBox(box), boxes.length * kSlotBytes);
}

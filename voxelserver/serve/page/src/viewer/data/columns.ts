import { bytesOfArrays, type BoxKey } from './box-arrays.js';
import { DataError } from '../../http/errors.js';
import { boxRange, hasLevel, isEmpty, type Facts } from './facts.js';
import { kMaxColumnBytes, type Column, type ColumnBox } from './source.js';

/** A column of boxes of a level: bx and bz count boxes of 64 x 64 voxels of that level. */
export type ColumnKey = { readonly level: number; readonly bx: number; readonly bz: number };

export const nameOfColumn = ({ level, bx, bz }: ColumnKey): string => `${level}/${bx}/${bz}`;

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

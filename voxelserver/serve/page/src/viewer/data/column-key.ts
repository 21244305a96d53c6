import type { BoxKey } from './box-arrays.js';
import { DataError } from '../../http/errors.js';
import { boxRange, hasLevel, isEmpty, type Facts } from './facts.js';

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

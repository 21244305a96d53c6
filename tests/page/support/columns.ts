import type { ColumnKey, Column } from '../../../voxelserver/serve/page/src/viewer/data/columns.js';

/** Columns for tests, by a number or two. */

export const toName = ({ level, bx, bz }: ColumnKey): string => `${level}/${bx}/${bz}`;

export const at = (bx: number, level = 0): ColumnKey => ({ level, bx, bz: 0 });

export const columnAt = (key: ColumnKey): Column => ({ ...key, byBegin: 0, boxes: [] });

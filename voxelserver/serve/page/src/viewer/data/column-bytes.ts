import { bytesOfArrays } from './box-arrays.js';
import type { Column, ColumnBox } from './source.js';

/** Memory that columns take. */

/** Of a place in a column, air included: an entry in each of the lists that name it. */
const kSlotBytes = 64;

export function bytesOfBox(box: ColumnBox): number {
  return typeof box === 'object' && 'cells' in box ? bytesOfArrays(box) : 0;
}

export function bytesOfColumn({ boxes }: Column): number {
  return boxes.reduce((sum, box) => sum + bytesOfBox(box), boxes.length * kSlotBytes);
}

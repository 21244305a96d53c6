import { bytesOfArrays } from './box-arrays.js';
import { nameOfColumn, type ColumnKey } from './column-key.js';
import { DataError } from '../../http/errors.js';
import { kMaxColumnBytes, type Column, type ColumnBox } from './source.js';

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
    if (typeof box === 'object' && 'cells' in box) this.#bytes += bytesOfArrays(box);
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

import { DataError } from '../../http/errors.js';

/** What the decoders of zstd frames share: errors, bounds, and streams that are read backwards. */

export function damagedFrame(what: string): DataError {
  return new DataError('damaged', `unpack a zstd frame: ${what}; the data are damaged`);
}

/** Index of the highest set bit of a positive number below 2^31. */
export const highestBit = (value: number): number => 31 - Math.clz32(value);

/**
 * Bits of a range of bytes from its end to its start, as the entropy streams of zstd are stored:
 * the last byte has a set bit above the first bit to read.
 */
export class BackwardBits {
  readonly view: DataView;
  /** Index of the first bit of the range, counted from the start of the view. */
  readonly start: number;
  /** One past the index of the next bit to read; never below `start` between two reads. */
  position: number;

  /**
   * @param view whole frame: at least 4 bytes precede the range
   * @param from, to the range, half-open
   * @throws DataError for an empty range, or one without the bit that marks its end
   */
  constructor(view: DataView, from: number, to: number) {
    const last = from < to ? view.getUint8(to - 1) : 0;
    if (last === 0) throw damagedFrame('a bit stream has no end mark');
    this.view = view;
    this.start = 8 * from;
    this.position = 8 * (to - 1) + highestBit(last);
  }

  /**
   * The next `count` bits, 0 to 25, without consuming them. Bits beyond the start of the range are
   * bits of what precedes it.
   */
  peek(count: number): number {
    const top = this.position - 1;
    const word = this.view.getUint32((top >> 3) - 3, true);
    return ((word << (7 - (top & 7))) >>> 1) >>> (31 - count);
  }

  /** @param count 0 to 25 @throws DataError beyond the start of the range */
  read(count: number): number {
    const bits = this.peek(count);
    this.position -= count;
    if (this.position < this.start) throw damagedFrame('a bit stream ends early');
    return bits;
  }

  get isAtEnd(): boolean {
    return this.position === this.start;
  }
}

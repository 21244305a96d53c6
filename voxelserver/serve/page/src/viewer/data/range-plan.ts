/** Merges ranges of a file into requests. Offsets and lengths in bytes. */

export type ByteRange = { readonly offset: number; readonly bytes: number };

/** One request, and the wanted ranges that lie within it, by offset. */
export type RangeRequest<T extends ByteRange> = {
  readonly offset: number;
  readonly bytes: number;
  readonly ranges: readonly T[];
};

/**
 * What lies between two wanted ranges is read over up to this: at 10 Mbit/s it takes as long as a
 * request over 50 ms of distance.
 */
export const kMaxGapBytes = 64 * 1024;
/** Of a request, unless a single range is larger. */
export const kMaxRequestBytes = 1024 * 1024;

/**
 * @param wanted in any order; ranges may overlap
 * @return requests by offset that together hold each wanted range once
 */
export function planRanges<T extends ByteRange>(wanted: readonly T[]): RangeRequest<T>[] {
  const sorted = [...wanted].sort((a, b) => a.offset - b.offset);
  const requests: RangeRequest<T>[] = [];
  let ranges: T[] = [];
  let offset = 0;
  let end = 0;
  const finish = (): void => {
    if (ranges.length > 0) requests.push({ offset, bytes: end - offset, ranges });
  };
  for (const range of sorted) {
    const newEnd = Math.max(end, range.offset + range.bytes);
    const isNear = range.offset - end <= kMaxGapBytes && newEnd - offset <= kMaxRequestBytes;
    if (ranges.length > 0 && isNear) {
      ranges.push(range);
      end = newEnd;
      continue;
    }
    finish();
    ranges = [range];
    offset = range.offset;
    end = range.offset + range.bytes;
  }
  finish();
  return requests;
}

/** What a request reads besides its ranges: the gaps between them. */
export function findGaps({ offset, ranges }: RangeRequest<ByteRange>): ByteRange[] {
  const gaps: ByteRange[] = [];
  let end = offset;
  for (const range of ranges) {
    if (range.offset > end) gaps.push({ offset: end, bytes: range.offset - end });
    end = Math.max(end, range.offset + range.bytes);
  }
  return gaps;
}

/** Stretches of a file, as one or more requests read them. */
export class Stretches {
  readonly #stretches: { offset: number; end: number }[];
  #bytes: number;

  /** @param ranges what is read in any case */
  constructor(ranges: readonly ByteRange[]) {
    const requests = planRanges(ranges);
    this.#stretches = requests.map(({ offset, bytes }) => ({ offset, end: offset + bytes }));
    this.#bytes = requests.reduce((sum, { bytes }) => sum + bytes, 0);
  }

  /**
   * Adds ranges if all of them lie close to what is read already, so that it takes no further
   * request, and all together stays within the size of one request.
   * @return whether they were added
   */
  extend(ranges: readonly ByteRange[]): boolean {
    const saved = this.#stretches.map((stretch) => ({ ...stretch }));
    const savedBytes = this.#bytes;
    if (ranges.every((range) => this.#extendBy(range))) return true;
    this.#stretches.splice(0, saved.length, ...saved);
    this.#bytes = savedBytes;
    return false;
  }

  #extendBy(range: ByteRange): boolean {
    const end = range.offset + range.bytes;
    const stretch = this.#stretches.find(
      (near) => range.offset - near.end <= kMaxGapBytes && near.offset - end <= kMaxGapBytes,
    );
    if (stretch === undefined) return false;
    const from = Math.min(stretch.offset, range.offset);
    const to = Math.max(stretch.end, end);
    this.#bytes += to - from - (stretch.end - stretch.offset);
    stretch.offset = from;
    stretch.end = to;
    return this.#bytes <= kMaxRequestBytes;
  }
}

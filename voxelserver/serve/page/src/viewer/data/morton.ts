import { kMaxLevel, type BoxKey } from './box-arrays.js';

/**
 * The sort order of an archive's index: by level, then along the Morton curve of (bx, by, bz), as
 * common/voxel/box.hpp defines it. A place in this order is two numbers, `high` and `low`, which
 * are compared in this order; the 63 bits of a Morton code do not fit into one.
 */

export type CurvePlace = { readonly high: number; readonly low: number };

const kHalf = 2 ** 20;
const kLowBits = 10;

/** Whether the key lies where its Morton code is unique, and its level exists. */
export function isInRange(key: BoxKey): boolean {
  const fits = (value: number): boolean => value >= -kHalf && value < kHalf;
  return key.level >= 0 && key.level <= kMaxLevel && fits(key.bx) && fits(key.by) && fits(key.bz);
}

/** @param key within isInRange() */
export function placeOnCurve(key: BoxKey): CurvePlace {
  const { level, bx, by, bz } = key;
  const mask = (1 << kLowBits) - 1;
  const low = spread(bx & mask) | (spread(by & mask) << 1) | (spread(bz & mask) << 2);
  const [x, y, z] = [bx >> kLowBits, by >> kLowBits, bz >> kLowBits];
  const middle = spread(x & mask) | (spread(y & mask) << 1) | (spread(z & mask) << 2);
  const top = ((x >> kLowBits) & 1) | (((y >> kLowBits) & 1) << 1) | (((z >> kLowBits) & 1) << 2);
  // The upper 33 bits of the code, and the level above them.
  return { high: (level * 8 + top) * 2 ** 30 + middle, low };
}

/** Whether `a` comes before `b`. */
export function isBefore(a: CurvePlace, b: CurvePlace): boolean {
  return a.high !== b.high ? a.high < b.high : a.low < b.low;
}

// Spreads 10 bits to every third bit.
function spread(bits: number): number {
  let spread = bits;
  spread = (spread | (spread << 16)) & 0x030000ff;
  spread = (spread | (spread << 8)) & 0x0300f00f;
  spread = (spread | (spread << 4)) & 0x030c30c3;
  return (spread | (spread << 2)) & 0x09249249;
}

import { toView } from '../../bytes.js';

/**
 * XXH64. The loop over a file's bytes works on 32-bit halves, as BigInt is too slow there; what
 * comes once for each hash is written with BigInt.
 * Ref: Collet, "XXH64", https://github.com/Cyan4973/xxHash/blob/dev/doc/xxhash_spec.md
 */

const kPrime1 = 0x9e3779b185ebca87n;
const kPrime2 = 0xc2b2ae3d27d4eb4fn;
const kPrime3 = 0x165667b19e3779f9n;
const kPrime4 = 0x85ebca77c2b2ae63n;
const kPrime5 = 0x27d4eb2f165667c5n;
const [kPrime1Low, kPrime1High] = [0x85ebca87 | 0, 0x9e3779b1 | 0];
const [kPrime2Low, kPrime2High] = [0x27d4eb4f | 0, 0xc2b2ae3d | 0];
const kStripeBytes = 32;

const wrap = (v: bigint): bigint => BigInt.asUintN(64, v);
const rotate = (v: bigint, bits: bigint): bigint => wrap(v << bits) | (v >> (64n - bits));
const mixed = (v: bigint): bigint => wrap(rotate(wrap(v * kPrime2), 31n) * kPrime1);

/** @param seed and result are 64 bits, unsigned */
export function xxh64(bytes: Uint8Array, seed = 0n): bigint {
  const view = toView(bytes);
  const end = bytes.length - (bytes.length % kStripeBytes);
  const start = end > 0 ? addStripes(view, end, seed) : seed + kPrime5;
  let hash = addTail(wrap(start + BigInt(bytes.length)), view, end);
  hash = wrap((hash ^ (hash >> 33n)) * kPrime2);
  hash = wrap((hash ^ (hash >> 29n)) * kPrime3);
  return hash ^ (hash >> 32n);
}

function addStripes(view: DataView, end: number, seed: bigint): bigint {
  // Four accumulators, the low and the high half of each.
  const halves = new Int32Array(8);
  const lanes = new BigUint64Array(halves.buffer);
  lanes.set([wrap(seed + kPrime1 + kPrime2), wrap(seed + kPrime2), seed, wrap(seed - kPrime1)]);
  for (let at = 0; at < end; at += kStripeBytes) {
    for (let lane = 0; lane < 4; ++lane) {
      const from = at + 8 * lane;
      round(halves, 2 * lane, view.getInt32(from, true), view.getInt32(from + 4, true));
    }
  }
  const [a, b, c, d] = lanes as unknown as [bigint, bigint, bigint, bigint];
  const sum = wrap(rotate(a, 1n) + rotate(b, 7n) + rotate(c, 12n) + rotate(d, 18n));
  return lanes.reduce((hash, lane) => wrap((hash ^ mixed(lane)) * kPrime1 + kPrime4), sum);
}

// What is left after the last stripe, fewer than 32 bytes.
function addTail(start: bigint, view: DataView, from: number): bigint {
  const end = view.byteLength;
  let hash = start;
  let at = from;
  for (; at + 8 <= end; at += 8) {
    const word = mixed(view.getBigUint64(at, true));
    hash = wrap(rotate(hash ^ word, 27n) * kPrime1 + kPrime4);
  }
  if (at + 4 <= end) {
    const word = wrap(BigInt(view.getUint32(at, true)) * kPrime1);
    hash = wrap(rotate(hash ^ word, 23n) * kPrime2 + kPrime3);
    at += 4;
  }
  for (; at < end; ++at) {
    const word = wrap(BigInt(view.getUint8(at)) * kPrime5);
    hash = wrap(rotate(hash ^ word, 11n) * kPrime1);
  }
  return hash;
}

// One step of an accumulator: += input * prime 2, rotated left by 31, *= prime 1. The hot loop.
function round(lanes: Int32Array, at: number, low: number, high: number): void {
  const productLow = Math.imul(low, kPrime2Low);
  const productHigh =
    highOfProduct(low, kPrime2Low) + Math.imul(low, kPrime2High) + Math.imul(high, kPrime2Low);
  const sumLow = (lanes[at]! + productLow) | 0;
  const carry = sumLow >>> 0 < productLow >>> 0 ? 1 : 0;
  const sumHigh = (lanes[at + 1]! + productHigh + carry) | 0;
  const turnedLow = (sumLow << 31) | (sumHigh >>> 1);
  const turnedHigh = (sumHigh << 31) | (sumLow >>> 1);
  lanes[at] = Math.imul(turnedLow, kPrime1Low);
  lanes[at + 1] =
    highOfProduct(turnedLow, kPrime1Low) +
    Math.imul(turnedLow, kPrime1High) +
    Math.imul(turnedHigh, kPrime1Low);
}

// The upper 32 bits of the product of two unsigned 32-bit numbers, from products of 16-bit halves.
// No sum on the way exceeds 2^32 - 1.
function highOfProduct(a: number, b: number): number {
  const aLow = a & 0xffff;
  const aHigh = a >>> 16;
  const bLow = b & 0xffff;
  const bHigh = b >>> 16;
  const lower = Math.imul(aLow, bLow) >>> 16;
  const middle = (Math.imul(aHigh, bLow) >>> 0) + lower;
  const other = (Math.imul(aLow, bHigh) >>> 0) + (middle & 0xffff);
  return (Math.imul(aHigh, bHigh) + (middle >>> 16) + (other >>> 16)) | 0;
}

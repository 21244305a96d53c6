/**
 * XXH64 with 32-bit arithmetic: 64-bit integers are two 32-bit halves, as BigInt is too slow for
 * every 8 bytes of a file.
 * Ref: Collet, "XXH64", https://github.com/Cyan4973/xxHash/blob/dev/doc/xxhash_spec.md
 */

/** Two unsigned 32-bit halves of a 64-bit number. */
export type Hash64 = { readonly low: number; readonly high: number };

const kPrime1Low = 0x85ebca87 | 0;
const kPrime1High = 0x9e3779b1 | 0;
const kPrime2Low = 0x27d4eb4f | 0;
const kPrime2High = 0xc2b2ae3d | 0;
const kPrime3Low = 0x9e3779f9 | 0;
const kPrime3High = 0x165667b1 | 0;
const kPrime4Low = 0xc2b2ae63 | 0;
const kPrime4High = 0x85ebca77 | 0;
const kPrime5Low = 0x165667c5 | 0;
const kPrime5High = 0x27d4eb2f | 0;

const kStripeBytes = 32;

/** A 64-bit number that is changed in place: low half, high half. */
type Words = Int32Array;

export function xxh64(bytes: Uint8Array, seed: Hash64 = { low: 0, high: 0 }): Hash64 {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const hash: Words = new Int32Array([seed.low, seed.high]);
  let at = 0;
  if (bytes.length >= kStripeBytes) at = addStripes(hash, view);
  else add(hash, kPrime5Low, kPrime5High);
  // The length: below 2^53, its high half matters only from 4 GiB.
  add(hash, bytes.length | 0, Math.floor(bytes.length / 2 ** 32));
  addTail(hash, view, at);
  return avalanche(hash);
}

export const sameHash = (a: Hash64, b: Hash64): boolean => a.low === b.low && a.high === b.high;

/** Reads a little-endian 64-bit number. @throws RangeError beyond the end */
export function hashAt(view: DataView, at: number): Hash64 {
  return { low: view.getUint32(at, true), high: view.getUint32(at + 4, true) };
}

/** @return how many bytes were read: whole stripes of 32 */
function addStripes(hash: Words, view: DataView): number {
  const seed = new Int32Array(hash);
  // Four accumulators, the low and the high half of each.
  const lanes = new Int32Array(8);
  setTo(lanes, 0, seed, kPrime1Low, kPrime1High);
  addTo(lanes, 0, kPrime2Low, kPrime2High);
  setTo(lanes, 2, seed, kPrime2Low, kPrime2High);
  setTo(lanes, 4, seed, 0, 0);
  setTo(lanes, 6, seed, 0, 0);
  subtractFrom(lanes, 6, kPrime1Low, kPrime1High);
  const end = view.byteLength - (view.byteLength % kStripeBytes);
  for (let at = 0; at < end; at += kStripeBytes) {
    for (let lane = 0; lane < 4; ++lane) {
      const from = at + 8 * lane;
      round(lanes, 2 * lane, view.getInt32(from, true), view.getInt32(from + 4, true));
    }
  }
  combine(hash, lanes);
  return end;
}

function combine(hash: Words, lanes: Int32Array): void {
  const lane: Words = new Int32Array(2);
  hash.fill(0);
  for (const [index, bits] of [1, 7, 12, 18].entries()) {
    lane.set(lanes.subarray(2 * index, 2 * index + 2));
    rotateLeft(lane, bits);
    add(hash, lane[0]!, lane[1]!);
  }
  for (let index = 0; index < 4; ++index) {
    lane.fill(0);
    round(lane, 0, lanes[2 * index]!, lanes[2 * index + 1]!);
    hash[0]! ^= lane[0]!;
    hash[1]! ^= lane[1]!;
    multiply(hash, kPrime1Low, kPrime1High);
    add(hash, kPrime4Low, kPrime4High);
  }
}

function addTail(hash: Words, view: DataView, from: number): void {
  const end = view.byteLength;
  const word: Words = new Int32Array(2);
  let at = from;
  for (; at + 8 <= end; at += 8) {
    word.fill(0);
    round(word, 0, view.getInt32(at, true), view.getInt32(at + 4, true));
    hash[0]! ^= word[0]!;
    hash[1]! ^= word[1]!;
    rotateLeft(hash, 27);
    multiply(hash, kPrime1Low, kPrime1High);
    add(hash, kPrime4Low, kPrime4High);
  }
  if (at + 4 <= end) {
    word[0] = view.getInt32(at, true);
    word[1] = 0;
    multiply(word, kPrime1Low, kPrime1High);
    hash[0]! ^= word[0];
    hash[1]! ^= word[1];
    rotateLeft(hash, 23);
    multiply(hash, kPrime2Low, kPrime2High);
    add(hash, kPrime3Low, kPrime3High);
    at += 4;
  }
  for (; at < end; ++at) {
    word[0] = view.getUint8(at);
    word[1] = 0;
    multiply(word, kPrime5Low, kPrime5High);
    hash[0]! ^= word[0];
    hash[1]! ^= word[1];
    rotateLeft(hash, 11);
    multiply(hash, kPrime1Low, kPrime1High);
  }
}

function avalanche(hash: Words): Hash64 {
  xorShiftRight(hash, 33);
  multiply(hash, kPrime2Low, kPrime2High);
  xorShiftRight(hash, 29);
  multiply(hash, kPrime3Low, kPrime3High);
  xorShiftRight(hash, 32);
  return { low: hash[0]! >>> 0, high: hash[1]! >>> 0 };
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

function add(words: Words, low: number, high: number): void {
  addTo(words, 0, low, high);
}

function addTo(words: Int32Array, at: number, low: number, high: number): void {
  const sum = (words[at]! >>> 0) + (low >>> 0);
  words[at] = sum | 0;
  words[at + 1] = words[at + 1]! + high + (sum > 0xffffffff ? 1 : 0);
}

function subtractFrom(words: Int32Array, at: number, low: number, high: number): void {
  const difference = (words[at]! >>> 0) - (low >>> 0);
  words[at] = difference | 0;
  words[at + 1] = words[at + 1]! - high - (difference < 0 ? 1 : 0);
}

function setTo(words: Int32Array, at: number, base: Words, low: number, high: number): void {
  words[at] = base[0]!;
  words[at + 1] = base[1]!;
  addTo(words, at, low, high);
}

function multiply(words: Words, low: number, high: number): void {
  const a = words[0]!;
  words[1] = highOfProduct(a, low) + Math.imul(a, high) + Math.imul(words[1]!, low);
  words[0] = Math.imul(a, low);
}

/** @param bits 1 to 31 */
function rotateLeft(words: Words, bits: number): void {
  const low = words[0]!;
  const high = words[1]!;
  words[0] = (low << bits) | (high >>> (32 - bits));
  words[1] = (high << bits) | (low >>> (32 - bits));
}

/** @param bits 1 to 63 */
function xorShiftRight(words: Words, bits: number): void {
  const low = words[0]!;
  const high = words[1]!;
  if (bits >= 32) {
    words[0] = low ^ (high >>> (bits - 32));
    return;
  }
  words[0] = low ^ ((low >>> bits) | (high << (32 - bits)));
  words[1] = high ^ (high >>> bits);
}

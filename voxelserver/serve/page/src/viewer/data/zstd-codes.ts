import { buildFseTable, type FseTable } from './zstd-fse.js';

/**
 * The codes of sequences: limits, tables where a block has none, and what the numbers stand for.
 * Ref: Collet & Kucherawy, RFC 8878, "Zstandard Compression", 3.1.1.3.2.1.1 and 3.1.1.3.2.2.
 */

export type Code = {
  readonly table: FseTable;
  readonly maxLog: number;
  readonly maxSymbol: number;
};

export const kLiteralLengths: Code = {
  table: buildFseTable(
    Int16Array.of(
      ...[4, 3, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 1, 1, 1, 2, 2],
      ...[2, 2, 2, 2, 2, 2, 2, 3, 2, 1, 1, 1, 1, 1, -1, -1, -1, -1],
    ),
    6,
  ),
  maxLog: 9,
  maxSymbol: 35,
};

export const kMatchLengths: Code = {
  table: buildFseTable(
    Int16Array.of(
      ...[1, 4, 3, 2, 2, 2, 2, 2, 2, 1, 1, 1, 1, 1, 1, 1, 1, 1],
      ...[1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1],
      ...[1, 1, 1, 1, 1, 1, 1, 1, 1, 1, -1, -1, -1, -1, -1, -1, -1],
    ),
    6,
  ),
  maxLog: 9,
  maxSymbol: 52,
};

export const kOffsets: Code = {
  table: buildFseTable(
    Int16Array.of(
      ...[1, 1, 1, 1, 1, 1, 2, 2, 2, 1, 1, 1, 1, 1, 1],
      ...[1, 1, 1, 1, 1, 1, 1, 1, 1, -1, -1, -1, -1, -1],
    ),
    5,
  ),
  maxLog: 8,
  maxSymbol: 31,
};

const kLiteralExtraBits = [
  ...[0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1],
  ...[1, 1, 2, 2, 3, 3, 4, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16],
];
const kMatchExtraBits = [
  ...[0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0],
  ...[0, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 3, 3, 4, 4, 5, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16],
];

/** Lengths by their codes: a base, to which a number of so many bits is added. */
export const kLengths = {
  literalBits: Uint8Array.from(kLiteralExtraBits),
  literalBase: computeBases(kLiteralExtraBits, 0),
  matchBits: Uint8Array.from(kMatchExtraBits),
  matchBase: computeBases(kMatchExtraBits, 3),
};

function computeBases(bits: readonly number[], first: number): Uint32Array {
  const bases = new Uint32Array(bits.length);
  let base = first;
  bits.forEach((count, code) => {
    bases[code] = base;
    base += 1 << count;
  });
  return bases;
}

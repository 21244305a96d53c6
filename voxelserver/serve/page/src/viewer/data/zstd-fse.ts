import { damagedFrame, highestBit } from './zstd-bits.js';

/**
 * Tables of finite state entropy.
 * Ref: Collet & Kucherawy, RFC 8878, "Zstandard Compression", 4.1.
 */

/** 2^log states: the symbol of each, and how to get to the next one. */
export type FseTable = {
  readonly log: number;
  readonly symbols: Uint8Array;
  /** How many bits to read after a state; the next state is `base` plus these bits. */
  readonly bits: Uint8Array;
  readonly base: Uint16Array;
};

/** Probability of a symbol that is less likely than one state. */
const kLessThanOne = -1;

/**
 * Reads the description of a table.
 * @param from, to where it begins, and where it must have ended
 * @param maxLog, maxSymbol limits by the use of the table
 * @return the table, and the place after the description
 * @throws DataError for a description that is none, or beyond the limits
 */
export function readFseTable(
  bytes: Uint8Array,
  from: number,
  to: number,
  maxLog: number,
  maxSymbol: number,
): { readonly table: FseTable; readonly next: number } {
  let position = 8 * from;
  const read = (count: number): number => {
    const at = position >> 3;
    position += count;
    if (position > 8 * to) throw damagedFrame('an entropy table ends early');
    const word = bytes[at]! | ((bytes[at + 1] ?? 0) << 8) | ((bytes[at + 2] ?? 0) << 16);
    return (word >> ((position - count) & 7)) & ((1 << count) - 1);
  };
  const log = 5 + read(4);
  if (log > maxLog) throw damagedFrame(`an entropy table of 2^${log} states`);
  const counts = new Int16Array(maxSymbol + 1);
  let symbol = 0;
  let remaining = 1 << log;
  while (remaining > 0) {
    if (symbol > maxSymbol) throw damagedFrame('an entropy table has too many symbols');
    // Values from 0 to remaining + 1; the smaller ones take one bit less.
    const width = highestBit(remaining + 1) + 1;
    const lowMask = (1 << (width - 1)) - 1;
    const short = (1 << width) - 2 - remaining;
    let value = read(width);
    if ((value & lowMask) < short) {
      value &= lowMask;
      --position;
    } else if (value > lowMask) {
      value -= short;
    }
    const count = value - 1;
    counts[symbol] = count;
    symbol += 1;
    remaining -= Math.abs(count);
    if (count === 0) symbol += readRepeats(read);
  }
  return { table: buildFseTable(counts, log), next: (position + 7) >> 3 };
}

// Of symbols without states after one without: twos of bits, of which 3 means that more follow.
function readRepeats(read: (count: number) => number): number {
  let sum = 0;
  for (;;) {
    const repeat = read(2);
    sum += repeat;
    if (repeat < 3) return sum;
  }
}

/**
 * @param counts states of each symbol, -1: less than one; they must add up to 2^log
 * @throws DataError when they do not
 */
export function buildFseTable(counts: Int16Array, log: number): FseTable {
  const size = 1 << log;
  const table: FseTable = {
    log,
    symbols: new Uint8Array(size),
    bits: new Uint8Array(size),
    base: new Uint16Array(size),
  };
  const next = new Uint16Array(counts.length);
  spreadSymbols(counts, table.symbols, next);
  for (let state = 0; state < size; ++state) {
    const symbol = table.symbols[state]!;
    const number = next[symbol]!;
    next[symbol] = number + 1;
    const bits = log - highestBit(number);
    table.bits[state] = bits;
    table.base[state] = (number << bits) - size;
  }
  return table;
}

function spreadSymbols(counts: Int16Array, symbols: Uint8Array, next: Uint16Array): void {
  const size = symbols.length;
  let sum = 0;
  for (const count of counts) sum += Math.abs(count);
  if (sum !== size) throw damagedFrame('an entropy table does not add up');
  let high = size;
  for (let symbol = 0; symbol < counts.length; ++symbol) {
    const count = counts[symbol]!;
    next[symbol] = Math.abs(count);
    if (count !== kLessThanOne) continue;
    high -= 1;
    symbols[high] = symbol;
  }
  const step = (size >> 1) + (size >> 3) + 3;
  let place = 0;
  for (let symbol = 0; symbol < counts.length; ++symbol) {
    for (let i = 0; i < counts[symbol]!; ++i) {
      symbols[place] = symbol;
      // There is a place below `high`: the sum of the counts is the number of places.
      do place = (place + step) & (size - 1);
      while (place >= high);
    }
  }
}

/** The table of a single symbol, which takes no bits. */
export function singleSymbolTable(symbol: number): FseTable {
  return {
    log: 0,
    symbols: new Uint8Array([symbol]),
    bits: new Uint8Array(1),
    base: new Uint16Array(1),
  };
}

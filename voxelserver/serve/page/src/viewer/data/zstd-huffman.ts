import { BackwardBits, damagedFrame, highestBit } from './zstd-bits.js';
import { readFseTable } from './zstd-fse.js';

/**
 * Huffman codes of literals.
 * Ref: Collet & Kucherawy, RFC 8878, "Zstandard Compression", 4.2.
 */

/** For each `log` bits that may come next: the symbol, and above it, from bit 8, its length. */
export type HuffmanTable = { readonly log: number; readonly entries: Uint16Array };

const kMaxLog = 11;
const kMaxWeightLog = 6;
const kMaxSymbols = 256;

/**
 * Reads the description of a code.
 * @param from, to where it begins, and where it must have ended
 * @throws DataError for a description that is none
 */
export function readHuffmanTable(
  bytes: Uint8Array,
  view: DataView,
  from: number,
  to: number,
): { readonly table: HuffmanTable; readonly next: number } {
  if (from >= to) throw damagedFrame('a Huffman table ends early');
  const head = bytes[from]!;
  const isPlain = head >= 128;
  const next = from + 1 + (isPlain ? (head - 127 + 1) >> 1 : head);
  if (next > to) throw damagedFrame('a Huffman table ends early');
  const weights = new Uint8Array(kMaxSymbols);
  const count = isPlain
    ? plainWeights(bytes, from + 1, head - 127, weights)
    : packedWeights(bytes, view, from + 1, next, weights);
  return { table: buildHuffmanTable(weights, count), next };
}

// Two weights a byte, the first in the upper half.
function plainWeights(bytes: Uint8Array, from: number, count: number, out: Uint8Array): number {
  for (let i = 0; i < count; ++i) {
    const pair = bytes[from + (i >> 1)]!;
    out[i] = i % 2 === 0 ? pair >> 4 : pair & 15;
  }
  return count;
}

// Two interleaved states over one stream, until it has too few bits for the next state: then the
// other state has a last symbol. The number of symbols is limited, as a state may take no bits.
function packedWeights(
  bytes: Uint8Array,
  view: DataView,
  from: number,
  to: number,
  out: Uint8Array,
): number {
  const { table, next } = readFseTable(bytes, from, to, kMaxWeightLog, kMaxLog + 1);
  const stream = new BackwardBits(view, next, to);
  const states = [stream.read(table.log), stream.read(table.log)] as [number, number];
  for (let count = 0; count < kMaxSymbols - 2; ++count) {
    const turn = count % 2 === 0 ? 0 : 1;
    const state = states[turn];
    out[count] = table.symbols[state]!;
    const bits = table.bits[state]!;
    if (stream.position - stream.start < bits) {
      out[count + 1] = table.symbols[states[1 - turn]!]!;
      return count + 2;
    }
    states[turn] = table.base[state]! + stream.read(bits);
  }
  throw damagedFrame('a Huffman table has too many symbols');
}

// The weight of the last symbol is what is missing to a power of two.
function buildHuffmanTable(weights: Uint8Array, count: number): HuffmanTable {
  let sum = 0;
  for (let i = 0; i < count; ++i) {
    if (weights[i]! > kMaxLog) throw damagedFrame(`a Huffman code of weight ${weights[i]!}`);
    sum += (1 << weights[i]!) >> 1;
  }
  const log = sum === 0 ? 0 : highestBit(sum) + 1;
  if (log === 0 || log > kMaxLog || count >= kMaxSymbols) {
    throw damagedFrame(`a Huffman code of ${count} symbols and up to ${log} bits`);
  }
  const missing = (1 << log) - sum;
  if ((missing & (missing - 1)) !== 0) throw damagedFrame('a Huffman code does not add up');
  weights[count] = highestBit(missing) + 1;
  return fillHuffmanTable(weights, count + 1, log);
}

// The longest codes first; codes of one length in the order of their symbols.
function fillHuffmanTable(weights: Uint8Array, count: number, log: number): HuffmanTable {
  const begin = new Uint16Array(kMaxLog + 3);
  for (let i = 0; i < count; ++i) {
    const weight = weights[i]!;
    begin[weight + 1] = begin[weight + 1]! + ((1 << weight) >> 1);
  }
  const longest = begin[2]!;
  if (longest < 2 || longest % 2 !== 0) throw damagedFrame('a Huffman code does not add up');
  for (let weight = 1; weight < begin.length; ++weight) {
    begin[weight] = begin[weight]! + begin[weight - 1]!;
  }
  const entries = new Uint16Array(1 << log);
  for (let i = 0; i < count; ++i) {
    const weight = weights[i]!;
    if (weight === 0) continue;
    const from = begin[weight]!;
    const to = from + (1 << (weight - 1));
    entries.fill(i | ((log + 1 - weight) << 8), from, to);
    begin[weight] = to;
  }
  return { log, entries };
}

/**
 * Decodes one stream of symbols.
 * @param from, to the stream in the view
 * @param out filled from `outFrom` up to `outTo`
 * @throws DataError unless the stream holds exactly that many symbols
 */
export function decodeHuffman(
  view: DataView,
  from: number,
  to: number,
  table: HuffmanTable,
  out: Uint8Array,
  outFrom: number,
  outTo: number,
): void {
  const { start, position: first } = new BackwardBits(view, from, to);
  const { log, entries } = table;
  const unused = 32 - log;
  let position = first;
  let at = outFrom;
  // One word of 32 bits has the bits of two symbols: 7 that are used up, and 22.
  while (at < outTo && position > start) {
    const top = position - 1;
    const word = view.getUint32((top >> 3) - 3, true) << (7 - (top & 7));
    const entry = entries[word >>> unused]!;
    out[at] = entry;
    at += 1;
    position -= entry >> 8;
    if (at === outTo) break;
    const other = entries[(word << (entry >> 8)) >>> unused]!;
    if (position <= start) break;
    out[at] = other;
    at += 1;
    position -= other >> 8;
  }
  if (position !== start || at !== outTo) {
    throw damagedFrame('a Huffman stream has another length than its symbols');
  }
}

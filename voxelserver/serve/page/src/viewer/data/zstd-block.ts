import { BackwardBits, damagedFrame } from './zstd-bits.js';
import { kLengths, kLiteralLengths, kMatchLengths, kOffsets, type Code } from './zstd-codes.js';
import { readFseTable, singleSymbolTable, type FseTable } from './zstd-fse.js';
import { decodeHuffman, readHuffmanTable, type HuffmanTable } from './zstd-huffman.js';

/**
 * Compressed blocks of zstd frames.
 * Ref: Collet & Kucherawy, RFC 8878, "Zstandard Compression", 3.1.1.3.
 */

/** No block unpacks to more. */
export const kMaxBlockBytes = 128 * 1024;

/** What blocks of a frame take over from the blocks before them. */
export type FrameState = {
  readonly bytes: Uint8Array;
  /** The same bytes. */
  readonly view: DataView;
  readonly out: Uint8Array;
  /** How many bytes of `out` are done. */
  done: number;
  huffman: HuffmanTable | undefined;
  /** Of literal lengths, offsets and match lengths. */
  readonly tables: [FseTable | undefined, FseTable | undefined, FseTable | undefined];
  /** The three offsets that were used last. */
  readonly offsets: [number, number, number];
};

/** Offsets of larger codes exceed the largest frame that is unpacked (zstd.ts). */
const kMaxOffsetCode = 25;

type Literals = { readonly bytes: Uint8Array; readonly from: number; readonly to: number };

// Literals of the block in progress. Decoding is synchronous, so one buffer is enough.
const literalBuffer = new Uint8Array(kMaxBlockBytes);

/**
 * Unpacks the block in [from, to) of the frame to the end of what is done.
 * @throws DataError unless it is a block that fits into the rest of `out`
 */
export function unpackBlock(frame: FrameState, from: number, to: number): void {
  const { literals, next } = readLiterals(frame, from, to);
  const first = byteAt(frame, next, to);
  let count = first;
  let at = next + 1;
  if (first === 255) {
    count = 0x7f00 + byteAt(frame, at, to) + (byteAt(frame, at + 1, to) << 8);
    at += 2;
  } else if (first >= 128) {
    count = ((first - 128) << 8) + byteAt(frame, at, to);
    at += 1;
  }
  if (count === 0) {
    if (at !== to) throw damagedFrame('bytes after the last literal of a block');
    copyRest(frame, literals, literals.from);
    return;
  }
  at = readTables(frame, at, to);
  const rest = copySequences(frame, count, new BackwardBits(frame.view, at, to), literals);
  copyRest(frame, literals, rest);
}

function byteAt(frame: FrameState, at: number, to: number): number {
  if (at >= to) throw damagedFrame('a block ends early');
  return frame.bytes[at]!;
}

function readLiterals(
  frame: FrameState,
  from: number,
  to: number,
): { readonly literals: Literals; readonly next: number } {
  const head = byteAt(frame, from, to);
  const type = head & 3;
  const format = (head >> 2) & 3;
  if (type >= 2) return compressedLiterals(frame, from, to);
  const headBytes = [1, 2, 1, 3][format]!;
  byteAt(frame, from + headBytes - 1, to);
  const shift = headBytes === 1 ? 3 : 4;
  const size = littleEndian(frame.bytes, from, headBytes) >>> shift;
  if (size > kMaxBlockBytes) throw damagedFrame(`a block has ${size} literals`);
  const at = from + headBytes;
  if (type === 1) {
    literalBuffer.fill(byteAt(frame, at, to), 0, size);
    return { literals: { bytes: literalBuffer, from: 0, to: size }, next: at + 1 };
  }
  if (size > to - at) throw damagedFrame('a block ends within its literals');
  return { literals: { bytes: frame.bytes, from: at, to: at + size }, next: at + size };
}

function compressedLiterals(
  frame: FrameState,
  from: number,
  to: number,
): { readonly literals: Literals; readonly next: number } {
  const head = frame.bytes[from]!;
  const hasNewTable = (head & 3) === 2;
  const format = (head >> 2) & 3;
  const headBytes = [3, 3, 4, 5][format]!;
  const sizeBits = [10, 10, 14, 18][format]!;
  byteAt(frame, from + headBytes - 1, to);
  // Up to 40 bits: as a number, not as a 32-bit integer.
  const bits = Math.floor(littleEndian(frame.bytes, from, headBytes) / 16);
  const size = bits % 2 ** sizeBits;
  const next = from + headBytes + Math.floor(bits / 2 ** sizeBits);
  if (size > kMaxBlockBytes || next > to) {
    throw damagedFrame(`a block has ${size} literals, or ends within them`);
  }
  let at = from + headBytes;
  if (hasNewTable) {
    const made = readHuffmanTable(frame.bytes, frame.view, at, next);
    frame.huffman = made.table;
    at = made.next;
  }
  if (frame.huffman === undefined) throw damagedFrame('literals without a Huffman table');
  const streams = format === 0 ? 1 : 4;
  decodeStreams(frame, at, next, frame.huffman, size, streams);
  return { literals: { bytes: literalBuffer, from: 0, to: size }, next };
}

// Four streams have their lengths before them, but for that of the last.
function decodeStreams(
  frame: FrameState,
  from: number,
  to: number,
  table: HuffmanTable,
  size: number,
  streams: number,
): void {
  if (streams === 1) {
    decodeHuffman(frame.view, from, to, table, literalBuffer, 0, size);
    return;
  }
  const quarter = (size + 3) >> 2;
  if (to - from < 6 || size < 3 * quarter) throw damagedFrame('four streams are too short');
  let at = from + 6;
  for (let i = 0; i < 4; ++i) {
    const end = i === 3 ? to : at + frame.view.getUint16(from + 2 * i, true);
    if (end > to) throw damagedFrame('a stream of literals ends early');
    const outTo = i === 3 ? size : (i + 1) * quarter;
    decodeHuffman(frame.view, at, end, table, literalBuffer, i * quarter, outTo);
    at = end;
  }
}

/** @return the place after the tables */
function readTables(frame: FrameState, from: number, to: number): number {
  const modes = byteAt(frame, from, to);
  if ((modes & 3) !== 0) throw damagedFrame('reserved bits are set');
  let at = from + 1;
  for (const [index, code] of [kLiteralLengths, kOffsets, kMatchLengths].entries()) {
    at = readTable(frame, at, to, index, (modes >> (6 - 2 * index)) & 3, code);
  }
  return at;
}

function readTable(
  frame: FrameState,
  at: number,
  to: number,
  index: number,
  mode: number,
  code: Code,
): number {
  if (mode === 0) {
    frame.tables[index] = code.table;
    return at;
  }
  if (mode === 1) {
    const symbol = byteAt(frame, at, to);
    if (symbol > code.maxSymbol) throw damagedFrame(`a code of number ${symbol}`);
    frame.tables[index] = singleSymbolTable(symbol);
    return at + 1;
  }
  if (mode === 2) {
    const { table, next } = readFseTable(frame.bytes, at, to, code.maxLog, code.maxSymbol);
    frame.tables[index] = table;
    return next;
  }
  if (frame.tables[index] === undefined) throw damagedFrame('no table to repeat');
  return at;
}

// Each sequence is some literals, then a copy of what was unpacked before. A copy has at least
// three bytes and nothing is written beyond `out`, so the work is limited by its size.
/** @return the place of the first literal that is left */
function copySequences(
  frame: FrameState,
  count: number,
  stream: BackwardBits,
  literals: Literals,
): number {
  const [lengths, offsets, matches] = frame.tables as [FseTable, FseTable, FseTable];
  let lengthState = stream.read(lengths.log);
  let offsetState = stream.read(offsets.log);
  let matchState = stream.read(matches.log);
  const { literalBase, literalBits, matchBase, matchBits } = kLengths;
  const out = frame.out;
  const end = Math.min(out.length, frame.done + kMaxBlockBytes);
  let from = literals.from;
  let to = frame.done;
  for (let left = count; left > 0; --left) {
    const offsetCode = offsets.symbols[offsetState]!;
    const matchCode = matches.symbols[matchState]!;
    const lengthCode = lengths.symbols[lengthState]!;
    if (offsetCode > kMaxOffsetCode) throw damagedFrame('a copy from before the start');
    const value = (1 << offsetCode) + stream.read(offsetCode);
    const match = matchBase[matchCode]! + stream.read(matchBits[matchCode]!);
    const length = literalBase[lengthCode]! + stream.read(literalBits[lengthCode]!);
    const offset = useOffset(frame.offsets, value, length === 0);
    if (left > 1) {
      lengthState = lengths.base[lengthState]! + stream.read(lengths.bits[lengthState]!);
      matchState = matches.base[matchState]! + stream.read(matches.bits[matchState]!);
      offsetState = offsets.base[offsetState]! + stream.read(offsets.bits[offsetState]!);
    }
    if (length > literals.to - from || length + match > end - to) {
      throw damagedFrame('a block has more bytes than it may');
    }
    copyLiterals(literals.bytes, from, out, to, length);
    from += length;
    to += length;
    if (offset === 0 || offset > to) throw damagedFrame('a copy from before the start');
    copyMatch(out, to, offset, match);
    to += match;
  }
  if (!stream.isAtEnd) throw damagedFrame('bits after the last sequence');
  frame.done = to;
  return from;
}

// Values up to 3 name one of the three last offsets, another one after no literals.
function useOffset(last: [number, number, number], value: number, hasNoLiterals: boolean): number {
  if (value > 3) {
    last[2] = last[1];
    last[1] = last[0];
    last[0] = value - 3;
    return value - 3;
  }
  const index = value - 1 + (hasNoLiterals ? 1 : 0);
  if (index === 0) return last[0];
  const offset = index === 3 ? last[0] - 1 : last[index]!;
  if (index > 1) last[2] = last[1];
  last[1] = last[0];
  last[0] = offset;
  return offset;
}

// Most runs are short: for these a loop is faster than a call.
const kShortRun = 24;

function copyLiterals(
  bytes: Uint8Array,
  from: number,
  out: Uint8Array,
  to: number,
  count: number,
): void {
  if (count > kShortRun) {
    out.set(bytes.subarray(from, from + count), to);
    return;
  }
  for (let i = 0; i < count; ++i) out[to + i] = bytes[from + i]!;
}

// A copy may overlap what it writes: then it repeats, and what is done doubles with each step.
function copyMatch(out: Uint8Array, to: number, offset: number, count: number): void {
  const from = to - offset;
  if (count <= kShortRun || (offset < 8 && count < 8 * kShortRun)) {
    for (let i = 0; i < count; ++i) out[to + i] = out[from + i]!;
    return;
  }
  let done = Math.min(offset, count);
  out.copyWithin(to, from, from + done);
  while (done < count) {
    const step = Math.min(done, count - done);
    out.copyWithin(to + done, to, to + step);
    done += step;
  }
}

function copyRest(frame: FrameState, literals: Literals, from: number): void {
  const count = literals.to - from;
  if (count > frame.out.length - frame.done) {
    throw damagedFrame('a block has more bytes than it may');
  }
  copyLiterals(literals.bytes, from, frame.out, frame.done, count);
  frame.done += count;
}

function littleEndian(bytes: Uint8Array, from: number, count: number): number {
  let value = 0;
  for (let i = count - 1; i >= 0; --i) value = value * 256 + bytes[from + i]!;
  return value;
}

import { toView } from '../../bytes.js';
import { DataError } from '../../http/errors.js';
import { xxh64 } from './xxh64.js';
import { damagedFrame } from './zstd-bits.js';
import { kMaxBlockBytes, unpackBlock, type FrameState } from './zstd-block.js';

/**
 * Unpacks zstd frames of unknown origin. Time and memory are limited by the declared size, which is
 * checked before memory is taken, and by the size of the frame.
 * Ref: Collet & Kucherawy, RFC 8878, "Zstandard Compression".
 */

const kMagic = 0xfd2fb528;
/** Offsets of 2^26 and more are refused without reading them (zstd-block.ts). */
const kMaxUnpackedBytes = 32 * 1024 * 1024;
const kMaxWindowLog = 31;
/** Blocks of fewer bytes are not worth their tables; an encoder makes blocks of 128 KiB. */
const kMinMeanBlockBytes = 256;
const kSmallBlocks = 64;

type FrameHeader = {
  /** Of the first block. */
  readonly next: number;
  readonly size: number;
  readonly hasChecksum: boolean;
};

/**
 * @param frame exactly one frame that declares the size of its content, without a dictionary
 * @param maxBytes of the content; up to 32 MiB
 * @return the content, in a buffer of its own
 * @throws DataError `too-large` for a declared size above maxBytes, `damaged` for everything that
 * is not such a frame
 */
export function unpack(frame: Uint8Array, maxBytes: number): Uint8Array<ArrayBuffer> {
  if (maxBytes > kMaxUnpackedBytes) throw new RangeError(`unpack up to ${maxBytes} bytes`);
  const view = toView(frame);
  const header = readHeader(frame, view);
  if (header.size > maxBytes) {
    throw new DataError(
      'too-large',
      `unpack a zstd frame: it claims ${header.size} bytes; allowed: up to ${maxBytes}`,
    );
  }
  const out = new Uint8Array(header.size);
  const state: FrameState = {
    bytes: frame,
    view,
    out,
    done: 0,
    huffman: undefined,
    tables: [undefined, undefined, undefined],
    offsets: [1, 4, 8],
  };
  let end = unpackBlocks(state, header.next);
  if (state.done !== header.size) {
    throw damagedFrame(`it has ${state.done} bytes and claims ${header.size}`);
  }
  if (header.hasChecksum) {
    if (frame.length - end < 4 || view.getUint32(end, true) !== Number(xxh64(out) & 0xffffffffn)) {
      throw damagedFrame('its checksum differs');
    }
    end += 4;
  }
  if (end !== frame.length) throw damagedFrame(`${frame.length - end} bytes follow it`);
  return out;
}

function readHeader(frame: Uint8Array, view: DataView): FrameHeader {
  if (frame.length < 6 || view.getUint32(0, true) !== kMagic) {
    throw damagedFrame('it does not begin like one');
  }
  const flags = frame[4]!;
  const isSingleSegment = (flags & 0x20) !== 0;
  if ((flags & 0x08) !== 0) throw damagedFrame('a reserved bit is set');
  const sizeBytes = [isSingleSegment ? 1 : 0, 2, 4, 8][flags >> 6]!;
  const dictionaryBytes = [0, 1, 2, 4][flags & 3]!;
  let at = 5 + (isSingleSegment ? 0 : 1);
  const next = at + dictionaryBytes + sizeBytes;
  if (next > frame.length) throw damagedFrame('it ends within its header');
  if (!isSingleSegment && 10 + (frame[5]! >> 3) > kMaxWindowLog) {
    throw damagedFrame('its window is too large');
  }
  if (sizeBytes === 0) throw damagedFrame('it does not declare its size');
  for (let i = 0; i < dictionaryBytes; ++i) {
    if (frame[at + i] !== 0) throw damagedFrame('it needs a dictionary');
  }
  at += dictionaryBytes;
  return { next, size: declaredSize(view, at, sizeBytes), hasChecksum: (flags & 4) !== 0 };
}

function declaredSize(view: DataView, at: number, bytes: number): number {
  if (bytes === 1) return view.getUint8(at);
  if (bytes === 2) return view.getUint16(at, true) + 256;
  const low = view.getUint32(at, true);
  return bytes === 4 ? low : view.getUint32(at + 4, true) * 2 ** 32 + low;
}

/** @return the place after the last block */
function unpackBlocks(frame: FrameState, first: number): number {
  const { bytes, out } = frame;
  const maxBlocks = kSmallBlocks + Math.floor(out.length / kMinMeanBlockBytes);
  let at = first;
  for (let count = 0; count < maxBlocks; ++count) {
    if (bytes.length - at < 3) throw damagedFrame('it ends within a block');
    const head = bytes[at]! | (bytes[at + 1]! << 8) | (bytes[at + 2]! << 16);
    const type = (head >> 1) & 3;
    const size = head >> 3;
    const stored = type === 1 ? 1 : size;
    at += 3;
    if (size > kMaxBlockBytes || type === 3) throw damagedFrame(`a block of ${size} bytes`);
    if (stored > bytes.length - at) throw damagedFrame('it ends within a block');
    if (type !== 2 && size > out.length - frame.done) {
      throw damagedFrame('it has more bytes than it claims');
    }
    if (type === 0) out.set(bytes.subarray(at, at + size), frame.done);
    if (type === 1) out.fill(bytes[at]!, frame.done, frame.done + size);
    if (type === 2) unpackBlock(frame, at, at + size);
    else frame.done += size;
    at += stored;
    if ((head & 1) !== 0) return at;
  }
  throw damagedFrame(`it has more than ${maxBlocks} blocks`);
}

import { makeBox, type Voxel } from './make-box.js';

/**
 * Box archives of version 1 for tests: made independently of the page's reader. Frames have raw and
 * RLE blocks only, so no compressor is needed.
 */

export type Key = readonly [level: number, bx: number, by: number, bz: number];
export type TestBox = {
  readonly key: Key;
  /** Of the box; else `frame` or `hole` is there. */
  readonly voxels?: readonly Voxel[];
  /** Instead of a zstd frame of the box. */
  readonly frame?: Uint8Array;
  readonly hole?: string;
};

export type RawEntry = { key: Key; offset: number; bytes: number; kind: number };
export type RawLeaf = { first: Key; offset: number; bytes: number; entries: number };

/** What to make other than it should be. */
export type ArchiveOptions = {
  readonly facts?: Readonly<Record<string, unknown>>;
  /** Of a leaf. */
  readonly entriesPerLeaf?: number;
  readonly changeEntries?: (entries: RawEntry[]) => RawEntry[];
  readonly changeLeaves?: (leaves: RawLeaf[]) => RawLeaf[];
  readonly header?: {
    readonly version?: number;
    readonly damage?: number;
    readonly rootOffset?: number;
    readonly rootBytes?: number;
    readonly fileBytes?: number;
    readonly infoBytes?: number;
  };
  /** Between two records, as in an archive with more boxes. */
  readonly gapBytes?: number;
  /** After each leaf. */
  readonly leafGapBytes?: number;
};

const k64 = (1n << 64n) - 1n;
const kPrimes = [
  0x9e3779b185ebca87n,
  0xc2b2ae3d27d4eb4fn,
  0x165667b19e3779f9n,
  0x85ebca77c2b2ae63n,
  0x27d4eb2f165667c5n,
] as const;

const rotate = (x: bigint, bits: bigint): bigint => ((x << bits) | (x >> (64n - bits))) & k64;

/** XXH64 as its specification reads, slowly. */
export function slowXxh64(data: Uint8Array, seed = 0n): bigint {
  const [p1, p2, p3, p4, p5] = kPrimes;
  const bytes = Buffer.from(data.buffer, data.byteOffset, data.byteLength);
  const round = (acc: bigint, lane: bigint): bigint =>
    (rotate((acc + lane * p2) & k64, 31n) * p1) & k64;
  let at = 0;
  let hash = (seed + p5) & k64;
  if (bytes.length >= 32) {
    const lanes = [seed + p1 + p2, seed + p2, seed, seed - p1].map((lane) => lane & k64);
    for (; at + 32 <= bytes.length; at += 32) {
      for (let i = 0; i < 4; ++i) lanes[i] = round(lanes[i]!, bytes.readBigUInt64LE(at + 8 * i));
    }
    hash = [1n, 7n, 12n, 18n].reduce((sum, bits, i) => sum + rotate(lanes[i]!, bits), 0n) & k64;
    for (const lane of lanes) hash = (((hash ^ round(0n, lane)) & k64) * p1 + p4) & k64;
  }
  hash = (hash + BigInt(bytes.length)) & k64;
  for (; at + 8 <= bytes.length; at += 8) {
    hash = (rotate(hash ^ round(0n, bytes.readBigUInt64LE(at)), 27n) * p1 + p4) & k64;
  }
  for (; at + 4 <= bytes.length; at += 4) {
    hash = (rotate(hash ^ ((BigInt(bytes.readUInt32LE(at)) * p1) & k64), 23n) * p2 + p3) & k64;
  }
  for (; at < bytes.length; ++at) {
    hash = (rotate(hash ^ ((BigInt(bytes[at]!) * p5) & k64), 11n) * p1) & k64;
  }
  hash = ((hash ^ (hash >> 33n)) * p2) & k64;
  hash = ((hash ^ (hash >> 29n)) * p3) & k64;
  return hash ^ (hash >> 32n);
}

/** Puts the key and the checksum into the header of a box. Changes and returns it. */
export function sealBox(box: Uint8Array, key: Key): Uint8Array {
  const bytes = Buffer.from(box.buffer, box.byteOffset, box.byteLength);
  key.forEach((number, i) => bytes.writeInt32LE(number, 12 + 4 * i));
  const seed = slowXxh64(bytes.subarray(0, 56));
  bytes.writeBigUInt64LE(slowXxh64(bytes.subarray(64), seed), 56);
  return box;
}

export function boxBytes(key: Key, voxels: readonly Voxel[]): Uint8Array {
  return sealBox(makeBox(voxels), key);
}

const kMaxBlock = 128 * 1024;

/** A block of a frame: `size` is its length, or for RLE that of the run. */
export function zstdBlock(
  type: 'raw' | 'rle' | 'compressed',
  size: number,
  body: Uint8Array,
): Buffer {
  const number = { raw: 0, rle: 1, compressed: 2 }[type];
  const head = Buffer.alloc(3);
  head.writeUIntLE((size << 3) | (number << 1), 0, 3);
  return Buffer.concat([head, body]);
}

/** A frame in a single segment that declares 4 bytes of size. The last block is marked. */
export function makeZstdFrame(size: number, blocks: readonly Uint8Array[]): Uint8Array {
  const head = Buffer.from([0x28, 0xb5, 0x2f, 0xfd, 0xa0, 0, 0, 0, 0]);
  head.writeUInt32LE(size, 5);
  const copies = blocks.map((block) => Buffer.from(block));
  const last = copies[copies.length - 1]!;
  last[0] = last[0]! | 1;
  return new Uint8Array(Buffer.concat([head, ...copies]));
}

/** Runs of equal bytes from 32 on are RLE blocks, all else is raw blocks. */
export function zstdFrame(content: Uint8Array): Uint8Array {
  const blocks: Uint8Array[] = [];
  let start = 0;
  const endRaw = (end: number): void => {
    for (let at = start; at < end; at += kMaxBlock) {
      const part = content.subarray(at, Math.min(end, at + kMaxBlock));
      blocks.push(zstdBlock('raw', part.length, part));
    }
  };
  for (let at = 0; at < content.length;) {
    let end = at + 1;
    while (end < content.length && content[end] === content[at] && end - at < kMaxBlock) ++end;
    if (end - at >= 32) {
      endRaw(at);
      blocks.push(zstdBlock('rle', end - at, content.subarray(at, at + 1)));
      start = end;
    }
    at = end;
  }
  endRaw(content.length);
  if (blocks.length === 0) blocks.push(zstdBlock('raw', 0, new Uint8Array(0)));
  return makeZstdFrame(content.length, blocks);
}

/** Facts about a world of 4 x 2 x 4 boxes around the origin, 3 levels. */
export const kFacts = {
  version: 2,
  software: 'terravox test',
  title: 'small',
  bounds: { min: [-128, -256, -128], max: [128, 256, 128] },
  voxel_m: 0.5,
  box: [64, 256, 64],
  levels: 3,
  crs: 'EPSG:3794',
  crs_wkt: '',
  crs_units_per_voxel: 0.5,
  materials: ['air', 'rock'],
  licence: 'CC0',
  attribution: 'nobody',
};

function morton([, bx, by, bz]: Key): bigint {
  let code = 0n;
  for (let bit = 0n; bit < 21n; ++bit) {
    [bx, by, bz].forEach((value, axis) => {
      const set = (BigInt.asUintN(21, BigInt(value)) >> bit) & 1n;
      code |= set << (3n * bit + BigInt(axis));
    });
  }
  return code;
}

export function inOrder(a: Key, b: Key): number {
  if (a[0] !== b[0]) return a[0] - b[0];
  return morton(a) < morton(b) ? -1 : Number(morton(a) > morton(b));
}

function words(numbers: readonly number[]): Buffer {
  const bytes = Buffer.alloc(4 * numbers.length);
  numbers.forEach((number, i) => bytes.writeInt32LE(number | 0, 4 * i));
  return bytes;
}

function long(number: number | bigint): Buffer {
  const bytes = Buffer.alloc(8);
  bytes.writeBigUInt64LE(BigInt(number));
  return bytes;
}

export function makeArchive(boxes: readonly TestBox[], options: ArchiveOptions = {}): Uint8Array {
  const info = Buffer.from(JSON.stringify({ ...kFacts, ...options.facts }));
  const parts: Uint8Array[] = [Buffer.alloc(64), info];
  let at = 64 + info.length;
  const add = (bytes: Uint8Array): number => {
    parts.push(bytes);
    at += bytes.length;
    return at - bytes.length;
  };
  let entries: RawEntry[] = boxes.map((box) => {
    const kind = box.hole === undefined ? 0 : 1;
    const frame =
      box.hole === undefined
        ? (box.frame ?? zstdFrame(boxBytes(box.key, box.voxels ?? [])))
        : Buffer.from(box.hole);
    add(words([...box.key, frame.length, kind]));
    add(long(slowXxh64(frame)));
    const offset = add(frame);
    add(Buffer.alloc(options.gapBytes ?? 0));
    return { key: box.key, offset, bytes: frame.length, kind };
  });
  entries.sort((a, b) => inOrder(a.key, b.key));
  entries = options.changeEntries?.(entries) ?? entries;
  let leaves: RawLeaf[] = [];
  const perLeaf = options.entriesPerLeaf ?? 1024;
  for (let from = 0; from < entries.length; from += perLeaf) {
    const own = entries.slice(from, from + perLeaf);
    const raw = own.map((e) => [words(e.key), long(e.offset), words([e.bytes, e.kind])]).flat();
    const frame = zstdFrame(Buffer.concat(raw));
    leaves.push({ first: own[0]!.key, offset: at, bytes: frame.length, entries: own.length });
    add(frame);
    add(Buffer.alloc(options.leafGapBytes ?? 0));
  }
  const frames = new Map(leaves.map((leaf) => [leaf.offset, leaf.bytes]));
  leaves = options.changeLeaves?.(leaves) ?? leaves;
  const written = Buffer.concat(parts);
  const root = leaves.map((leaf) => {
    const frame = written.subarray(leaf.offset, leaf.offset + (frames.get(leaf.offset) ?? 0));
    const tail = [long(leaf.offset), words([leaf.bytes, leaf.entries]), long(slowXxh64(frame))];
    return Buffer.concat([words(leaf.first), ...tail]);
  });
  const rootBytes = Buffer.concat(root);
  const rootOffset = add(rootBytes);
  add(long(slowXxh64(rootBytes)));
  const archive = Buffer.concat(parts);
  const head = options.header ?? {};
  archive.write('TVXARC\r\n', 'latin1');
  archive.writeUInt32LE(head.version ?? 1, 8);
  archive.writeUInt32LE(head.damage ?? 0, 12);
  const places = [
    64,
    head.infoBytes ?? info.length,
    head.rootOffset ?? rootOffset,
    head.rootBytes ?? rootBytes.length + 8,
    head.fileBytes ?? archive.length,
  ];
  places.forEach((place, i) => archive.writeBigUInt64LE(BigInt(place), 16 + 8 * i));
  archive.writeBigUInt64LE(slowXxh64(archive.subarray(0, 56)), 56);
  return new Uint8Array(archive);
}

import { kMaxLevel, nameOfBox, type BoxKey } from './box-arrays.js';
import { toView } from '../../bytes.js';
import { DataError } from '../../http/errors.js';
import { kMaxFactsBytes } from './facts.js';
import { xxh64 } from './xxh64.js';
import { unpack } from './zstd.js';

/**
 * The bytes of a box archive, version 1 (docs/formats/box-archive.md). What is refused here is what
 * common/voxel/archive/archive_world.cpp refuses, and what no writer makes: entries that are there
 * twice or lie in the wrong leaf, unknown kinds, frames without room for their record. Sizes are
 * checked before memory is taken. All numbers little-endian.
 */

export type ArchiveHeader = Readonly<ReturnType<typeof parseHeader>>;

/** Where a leaf of the index lies. */
export type LeafPlace = {
  readonly first: BoxKey;
  readonly offset: number;
  readonly bytes: number;
  readonly entries: number;
  readonly checksum: bigint;
};

/** Where a box lies: of its frame. */
export type Entry = {
  readonly offset: number;
  readonly bytes: number;
  readonly kind: 'box' | 'hole';
};

/** What an index may name. */
export type IndexLimits = {
  readonly fileBytes: number;
  /** Whether the box lies in the world that the archive declares. */
  readonly hasRoomFor: (key: BoxKey) => boolean;
};

export const kHeaderBytes = 64;
/** Precedes each frame. */
export const kRecordBytes = 32;

const kMagic = [0x41585654, 0x0a0d4352]; // TVXARC\r\n
const kVersion = 1;
const kRootEntryBytes = 40;
const kEntryBytes = 32;
const kMaxEntries = 1024;
/** The C++ reader allows 256 MiB; 32 MiB are some 800 million boxes. */
const kMaxRootBytes = 32 * 1024 * 1024;
/** ZSTD_compressBound() of a leaf of 1024 entries. */
const kMaxLeafBytes = 32_944;
/** Of a box or hole. */
const kMaxFrameBytes = 16 * 1024 * 1024;
const kMaxHoleBytes = 64 * 1024;

/** @throws DataError `damaged`, or `too-large` for a larger index than a page should hold */
export const readHeader = (bytes: Uint8Array, name: string): ArchiveHeader =>
  parseHeader(bytes, name);

function parseHeader(bytes: Uint8Array, name: string) {
  const fail = (what: string): DataError => damaged(name, what);
  const view = toView(bytes);
  const isArchive =
    bytes.length >= kHeaderBytes &&
    view.getUint32(0, true) === kMagic[0] &&
    view.getUint32(4, true) === kMagic[1];
  if (!isArchive) throw fail('not a box archive');
  const version = view.getUint32(8, true);
  if (version !== kVersion) throw fail(`version ${version}; allowed: ${kVersion}`);
  if (xxh64(bytes.subarray(0, 56)) !== view.getBigUint64(56, true)) {
    throw fail('its header is damaged');
  }
  const header = {
    /** Number of damaged places in the data that the archive was made from. */
    damage: view.getUint32(12, true),
    infoOffset: sizeAt(view, 16),
    infoBytes: sizeAt(view, 24),
    rootOffset: sizeAt(view, 32),
    rootBytes: sizeAt(view, 40),
    fileBytes: sizeAt(view, 48),
  };
  if (header.rootOffset === 0) throw fail('it was never finished; convert again to go on');
  const { infoOffset, infoBytes, rootOffset, rootBytes, fileBytes } = header;
  const isSound =
    infoBytes <= kMaxFactsBytes &&
    rootBytes >= 8 &&
    (rootBytes - 8) % kRootEntryBytes === 0 &&
    infoOffset + infoBytes <= fileBytes &&
    rootOffset + rootBytes <= fileBytes;
  if (!isSound) throw fail('its header leads outside');
  if (rootBytes > kMaxRootBytes) {
    throw new DataError(
      'too-large',
      `open the box archive ${name}: an index of ${rootBytes} bytes; ` +
        `the viewer can open ${kMaxRootBytes}: convert a smaller area`,
    );
  }
  return header;
}

/** The root of the index: leaves in the order of their first boxes. */
export class RootIndex {
  readonly count: number;
  readonly #view: DataView;

  /** @throws DataError `damaged` */
  constructor(bytes: Uint8Array, limits: IndexLimits, name: string) {
    this.#view = toView(bytes);
    const payload = bytes.length - 8;
    if (xxh64(bytes.subarray(0, payload)) !== this.#view.getBigUint64(payload, true)) {
      throw damaged(name, 'its index is damaged');
    }
    this.count = payload / kRootEntryBytes;
    let before: BoxKey | undefined;
    for (let i = 0; i < this.count; ++i) {
      const leaf = this.leaf(i);
      const isSound =
        leaf.entries >= 1 &&
        leaf.entries <= kMaxEntries &&
        leaf.bytes <= kMaxLeafBytes &&
        leaf.offset + leaf.bytes <= limits.fileBytes &&
        isInRange(leaf.first) &&
        isAscending(before, leaf.first);
      if (!isSound) throw damaged(name, 'its index is damaged');
      if (!limits.hasRoomFor(leaf.first)) throw damaged(name, `its index: ${outside(leaf.first)}`);
      before = leaf.first;
    }
  }

  /** @param index below `count` */
  leaf(index: number): LeafPlace {
    const at = kRootEntryBytes * index;
    return {
      first: keyAt(this.#view, at),
      offset: sizeAt(this.#view, at + 16),
      bytes: this.#view.getUint32(at + 24, true),
      entries: this.#view.getUint32(at + 28, true),
      checksum: this.#view.getBigUint64(at + 32, true),
    };
  }

  /** The leaf that has the box if any has it. */
  findLeaf(key: BoxKey): number | undefined {
    const after = countUpTo(key, this.count, (i) => keyAt(this.#view, kRootEntryBytes * i));
    return after === 0 ? undefined : after - 1;
  }

  /** Whether the box comes before the first one of leaf `index`; true beyond the last leaf. */
  isBeforeLeaf(key: BoxKey, index: number): boolean {
    return index >= this.count || isBefore(key, this.leaf(index).first);
  }
}

/** A leaf of the index: entries in the order of their boxes. */
export class LeafIndex {
  readonly count: number;
  readonly #view: DataView;

  /**
   * @param frame of leaf `index` of the root
   * @throws DataError `damaged`, without the name of the archive
   */
  constructor(frame: Uint8Array, root: RootIndex, index: number, limits: IndexLimits) {
    const place = root.leaf(index);
    const fail = (what: string): DataError => new DataError('damaged', what);
    if (xxh64(frame) !== place.checksum) throw fail('its checksum differs');
    const bytes = unpack(frame, kMaxEntries * kEntryBytes);
    if (bytes.length !== place.entries * kEntryBytes) {
      throw fail(`${bytes.length} bytes; the root states ${place.entries} entries`);
    }
    this.count = place.entries;
    this.#view = toView(bytes);
    let before: BoxKey | undefined;
    for (let i = 0; i < this.count; ++i) {
      const key = this.#key(i);
      if (!isInRange(key) || !limits.hasRoomFor(key)) throw fail(outside(key));
      if (!isAscending(before, key)) throw fail(`box ${nameOfBox(key)} is out of order`);
      if (!this.#isSound(i, limits.fileBytes)) {
        throw fail(`the entry of box ${nameOfBox(key)} leads outside`);
      }
      before = key;
    }
    const last = this.#key(this.count - 1);
    if (nameOfBox(this.#key(0)) !== nameOfBox(place.first) || !root.isBeforeLeaf(last, index + 1)) {
      throw fail('it has boxes of another leaf');
    }
  }

  /** Of memory. */
  get bytes(): number {
    return this.#view.byteLength;
  }

  /** @return undefined for a box that is air */
  find(key: BoxKey): Entry | undefined {
    const index = countUpTo(key, this.count, (i) => this.#key(i)) - 1;
    const isThere = index >= 0 && !isBefore(this.#key(index), key);
    return isThere ? this.#entry(index) : undefined;
  }

  #key(index: number): BoxKey {
    return keyAt(this.#view, kEntryBytes * index);
  }

  #entry(index: number): Entry {
    const at = kEntryBytes * index;
    return {
      offset: sizeAt(this.#view, at + 16),
      bytes: this.#view.getUint32(at + 24, true),
      kind: this.#view.getUint32(at + 28, true) === 0 ? 'box' : 'hole',
    };
  }

  #isSound(index: number, fileBytes: number): boolean {
    const kind = this.#view.getUint32(kEntryBytes * index + 28, true);
    const { offset, bytes } = this.#entry(index);
    const limit = kind === 0 ? kMaxFrameBytes : kMaxHoleBytes;
    return (
      kind <= 1 &&
      bytes <= limit &&
      offset >= kHeaderBytes + kRecordBytes &&
      offset + bytes <= fileBytes
    );
  }
}

/**
 * The frame of a box, checked.
 * @param bytes the record and the frame
 * @throws DataError `damaged` when the record is that of another box, or the checksum differs
 */
export function extractFrame(bytes: Uint8Array, key: BoxKey, entry: Entry): Uint8Array {
  const fail = (what: string): DataError =>
    new DataError('damaged', `read box ${nameOfBox(key)} of an archive: ${what}`);
  const view = toView(bytes);
  const kind = entry.kind === 'box' ? 0 : 1;
  const isRecord =
    nameOfBox(keyAt(view, 0)) === nameOfBox(key) &&
    view.getUint32(16, true) === entry.bytes &&
    view.getUint32(20, true) === kind;
  if (!isRecord) throw fail('the index leads to another record');
  const frame = bytes.subarray(kRecordBytes, kRecordBytes + entry.bytes);
  if (xxh64(frame) !== view.getBigUint64(24, true)) throw fail('its checksum differs');
  return frame;
}

/** Of a coordinate of boxes in a Morton code. */
const kBits = 21;
const kMask = 2 ** kBits - 1;

/** Whether the key lies where its Morton code is unique, and its level exists. */
function isInRange({ level, bx, by, bz }: BoxKey): boolean {
  const half = 2 ** (kBits - 1);
  const fits = (value: number): boolean => value >= -half && value < half;
  return level >= 0 && level <= kMaxLevel && fits(bx) && fits(by) && fits(bz);
}

/**
 * Whether box `a` comes before `b` in an index: by level, then along the Morton curve of
 * (bx, by, bz), as common/voxel/box.hpp defines it. The coordinate that differs in the highest bit
 * decides.
 * Ref: Chan, "Closest-Point Problems Simplified on the RAM", SODA 2002.
 */
function isBefore(a: BoxKey, b: BoxKey): boolean {
  if (a.level !== b.level) return a.level < b.level;
  let axis: 'bx' | 'by' | 'bz' = 'bz';
  let most = 0;
  // Of differences in the same bit, z comes first.
  for (const next of ['bz', 'by', 'bx'] as const) {
    const difference = (a[next] ^ b[next]) & kMask;
    if (most < difference && most < (most ^ difference)) {
      axis = next;
      most = difference;
    }
  }
  return (a[axis] & kMask) < (b[axis] & kMask);
}

const isAscending = (before: BoxKey | undefined, key: BoxKey): boolean =>
  before === undefined || isBefore(before, key);

/** How many of ascending boxes do not come after a box. */
function countUpTo(key: BoxKey, count: number, at: (index: number) => BoxKey): number {
  let from = 0;
  let to = count;
  while (from < to) {
    const middle = (from + to) >> 1;
    if (isBefore(key, at(middle))) to = middle;
    else from = middle + 1;
  }
  return from;
}

function damaged(name: string, what: string): DataError {
  return new DataError('damaged', `open the box archive ${name}: ${what}`);
}

const outside = (key: BoxKey): string => `box ${nameOfBox(key)} lies outside of the bounds`;

function keyAt(view: DataView, at: number): BoxKey {
  return {
    level: view.getInt32(at, true),
    bx: view.getInt32(at + 4, true),
    by: view.getInt32(at + 8, true),
    bz: view.getInt32(at + 12, true),
  };
}

// 64 bits as a number: exact below 2^53, and above it larger than any file.
function sizeAt(view: DataView, at: number): number {
  return view.getUint32(at + 4, true) * 2 ** 32 + view.getUint32(at, true);
}

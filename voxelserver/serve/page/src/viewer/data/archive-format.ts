import { nameOfBox, type BoxKey } from './box-arrays.js';
import { toView } from '../../bytes.js';
import { DataError } from '../../http/errors.js';
import { kMaxFactsBytes } from './facts.js';
import { isBefore, isInRange, placeOnCurve, type CurvePlace } from './morton.js';
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
  readonly #order: CurveOrder;

  /** @throws DataError `damaged` */
  constructor(bytes: Uint8Array, limits: IndexLimits, name: string) {
    this.#view = toView(bytes);
    const payload = bytes.length - 8;
    if (xxh64(bytes.subarray(0, payload)) !== this.#view.getBigUint64(payload, true)) {
      throw damaged(name, 'its index is damaged');
    }
    this.count = payload / kRootEntryBytes;
    this.#order = new CurveOrder(this.count);
    for (let i = 0; i < this.count; ++i) {
      const leaf = this.leaf(i);
      const isSound =
        leaf.entries >= 1 &&
        leaf.entries <= kMaxEntries &&
        leaf.bytes <= kMaxLeafBytes &&
        leaf.offset + leaf.bytes <= limits.fileBytes &&
        isInRange(leaf.first) &&
        this.#order.append(i, leaf.first);
      if (!isSound) throw damaged(name, 'its index is damaged');
      if (!limits.hasRoomFor(leaf.first)) throw damaged(name, `its index: ${outside(leaf.first)}`);
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
    const after = this.#order.firstAfter(placeOnCurve(key));
    return after === 0 ? undefined : after - 1;
  }

  /** Whether the box comes before the first one of leaf `index`; true beyond the last leaf. */
  isBeforeLeaf(key: BoxKey, index: number): boolean {
    return index >= this.count || this.#order.isBefore(placeOnCurve(key), index);
  }
}

/** A leaf of the index: entries in the order of their boxes. */
export class LeafIndex {
  readonly count: number;
  readonly #view: DataView;
  readonly #order: CurveOrder;

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
    this.#order = new CurveOrder(this.count);
    for (let i = 0; i < this.count; ++i) {
      const key = keyAt(this.#view, kEntryBytes * i);
      if (!isInRange(key) || !limits.hasRoomFor(key)) throw fail(outside(key));
      if (!this.#order.append(i, key)) throw fail(`box ${nameOfBox(key)} is out of order`);
      if (!this.#isSound(i, limits.fileBytes)) {
        throw fail(`the entry of box ${nameOfBox(key)} leads outside`);
      }
    }
    const first = keyAt(this.#view, 0);
    const last = keyAt(this.#view, kEntryBytes * (this.count - 1));
    if (nameOfBox(first) !== nameOfBox(place.first) || !root.isBeforeLeaf(last, index + 1)) {
      throw fail('it has boxes of another leaf');
    }
  }

  /** Of memory. */
  get bytes(): number {
    return this.#view.byteLength + this.#order.bytes;
  }

  /** @return undefined for a box that is air */
  find(key: BoxKey): Entry | undefined {
    const index = this.#order.find(placeOnCurve(key));
    return index === undefined ? undefined : this.#entry(index);
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

/** Places on the curve, each after the one before. */
class CurveOrder {
  readonly #high: Float64Array;
  readonly #low: Uint32Array;
  #count = 0;

  constructor(capacity: number) {
    this.#high = new Float64Array(capacity);
    this.#low = new Uint32Array(capacity);
  }

  get bytes(): number {
    return this.#high.byteLength + this.#low.byteLength;
  }

  /** @param index how many there are @return whether the key comes after the last one */
  append(index: number, key: BoxKey): boolean {
    const place = placeOnCurve(key);
    this.#high[index] = place.high;
    this.#low[index] = place.low;
    this.#count = index + 1;
    return index === 0 || isBefore(this.#at(index - 1), place);
  }

  isBefore(place: CurvePlace, index: number): boolean {
    return isBefore(place, this.#at(index));
  }

  /** Index of the first place after the given one. */
  firstAfter(place: CurvePlace): number {
    let from = 0;
    let to = this.#count;
    while (from < to) {
      const middle = (from + to) >> 1;
      if (isBefore(place, this.#at(middle))) to = middle;
      else from = middle + 1;
    }
    return from;
  }

  find(place: CurvePlace): number | undefined {
    const index = this.firstAfter(place) - 1;
    const isThere = index >= 0 && !isBefore(this.#at(index), place);
    return isThere ? index : undefined;
  }

  #at(index: number): CurvePlace {
    return { high: this.#high[index]!, low: this.#low[index]! };
  }
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

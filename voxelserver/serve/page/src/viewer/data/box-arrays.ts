import type { Vec3 } from '../../vec3.js';
import { DataError } from '../../http/errors.js';
import { xxh64 } from './xxh64.js';

/**
 * Reads boxes of version 1 (docs/formats/box.md) into the arrays that the draw layer uploads.
 * Checks what voxel::Box::from_blob checks (common/voxel/box.cpp): no walk through the arrays can
 * leave them. All numbers are little-endian, as on every machine that runs a browser.
 */

export type BoxKey = {
  readonly level: number;
  readonly bx: number;
  readonly by: number;
  readonly bz: number;
};

export type BoxArrays = {
  /** 4 words a cell: mask low, mask high, detail low, detail high. The first 4 cells are roots. */
  readonly cells: Uint32Array<ArrayBuffer>;
  /** A word a cell: index of its first child, a cell or, for bricks, an attribute. */
  readonly first: Uint32Array<ArrayBuffer>;
  /**
   * A word an attribute: red, green << 8, blue << 16, material << 24 (0 to 32), bit 30 where the
   * colour is typical of a building or tree, and bit 31 where it was measured.
   */
  readonly attributes: Uint32Array<ArrayBuffer>;
  /** The source class of each attribute, as the survey has it. */
  readonly classes: Uint8Array<ArrayBuffer>;
};

export const kBoxSize = [64, 256, 64] as const;
export const kMaxLevel = 20;

const kMagic = [0x42585654, 0x0a0d584f]; // TVXBOX\r\n
const kVersion = 1;
const kHeaderBytes = 64;
const kChecksumAt = 56;
const kCellWords = 6;
const kAttributeWords = 2;
const kRoots = 4;
/** Roots, 16^3 cells and bricks of a box in which every cell has details. */
const kMaxCells = kRoots + kRoots * 64 + kRoots * 64 * 64;
const kMaxAttributes = kBoxSize[0] * kBoxSize[1] * kBoxSize[2];
/** Of any box. */
export const kMaxBoxBytes =
  kHeaderBytes + 4 * (kMaxCells * kCellWords + kMaxAttributes * kAttributeWords);

/** How many there are, and which stands for all others: common/voxel/material.hpp; tested. */
export const kMaterials = 33;
export const kUnknownMaterial = 23;
const kTinted = 0x40000000;
const kHasColour = 0x80000000;

export const nameOfBox = (key: BoxKey): string => `${key.level}/${key.bx}/${key.by}/${key.bz}`;

/** What an attribute says; a colour is undefined where none was measured. */
export type VoxelLook = { readonly material: number; readonly colour: Vec3 | undefined };

/** @param attribute a word of BoxArrays.attributes */
export function readLook(attribute: number): VoxelLook {
  const colour = [attribute & 255, (attribute >> 8) & 255, (attribute >> 16) & 255] as const;
  const hasColour = (attribute & kHasColour) !== 0;
  return { material: (attribute >> 24) & 63, colour: hasColour ? colour : undefined };
}

/** `y` is that of a voxel within its box; `look` is unknown for rock that no one can see. */
export type TopVoxel = { readonly y: number; readonly look: VoxelLook | undefined };

/** The highest solid voxel above column (x, z) of a box, 0 to 63 each. */
export function findTop(box: BoxArrays, x: number, z: number): TopVoxel | undefined {
  for (let y = kBoxSize[1] - 1; y >= 0; --y) {
    const found = findVoxel(box, x, y, z);
    if (found !== 'air') return { y, look: found === 'hidden' ? undefined : found };
  }
  return undefined;
}

// Root (64^3), then 16^3, then the brick (4^3) whose children are voxels.
function findVoxel(box: BoxArrays, x: number, y: number, z: number): VoxelLook | 'hidden' | 'air' {
  const { cells, first, attributes } = box;
  let next = y >> 6;
  for (const shift of [4, 2, 0]) {
    const bit = ((x >> shift) & 3) + 4 * ((z >> shift) & 3) + 16 * ((y >> shift) & 3);
    const word = (offset: number): number => cells[4 * next + offset]!;
    const has = (offset: number): boolean => ((word(offset + (bit >> 5)) >>> (bit & 31)) & 1) === 1;
    if (!has(0)) return 'air';
    if (!has(2)) return 'hidden';
    const inWord = onesIn(word(2 + (bit >> 5)) & ((1 << (bit & 31)) - 1));
    next = first[next]! + inWord + (bit >= 32 ? onesIn(word(2)) : 0);
  }
  return readLook(attributes[next]!);
}

/** Bytes of memory of the arrays. */
export function bytesOfArrays(box: BoxArrays): number {
  const { cells, first, attributes, classes } = box;
  return cells.byteLength + first.byteLength + attributes.byteLength + classes.byteLength;
}

/**
 * @param bytes the box, unpacked
 * @param key of the box that was requested
 * @throws DataError `damaged` for everything that is not that box
 */
export function readBoxArrays(bytes: Uint8Array, key: BoxKey): BoxArrays {
  const fail = (what: string): DataError =>
    new DataError('damaged', `read box ${nameOfBox(key)}: ${what}`);
  if (bytes.length < kHeaderBytes) {
    throw fail(`${bytes.length} bytes; at least ${kHeaderBytes} are needed`);
  }
  // Words can only be read from multiples of 4.
  const aligned = bytes.byteOffset % 4 === 0 ? bytes : new Uint8Array(bytes);
  const words = new Uint32Array(aligned.buffer, aligned.byteOffset, aligned.length >> 2);
  if (words[0] !== kMagic[0] || words[1] !== kMagic[1]) throw fail('not in the box format');
  if (words[2] !== kVersion) throw fail(`format version ${words[2]}; allowed: ${kVersion}`);
  const found = toKey(words);
  if (found.level < 0 || found.level > kMaxLevel) {
    throw fail(`level ${found.level}; allowed: 0 to ${kMaxLevel}`);
  }
  const cellCount = words[7]!;
  const attributeCount = words[8]!;
  if (cellCount < kRoots || cellCount > kMaxCells) {
    throw fail(`${cellCount} cells; allowed: ${kRoots} to ${kMaxCells}`);
  }
  if (attributeCount > kMaxAttributes) {
    throw fail(`${attributeCount} attributes; allowed: 0 to ${kMaxAttributes}`);
  }
  const size = kHeaderBytes + 4 * (cellCount * kCellWords + attributeCount * kAttributeWords);
  if (bytes.length !== size) throw fail(`${bytes.length} bytes; its header states ${size}`);
  if (!checksumHolds(aligned)) throw fail('its checksum differs');
  if (nameOfBox(found) !== nameOfBox(key)) throw fail(`it is box ${nameOfBox(found)}`);

  const { cells, first } = splitCells(words, cellCount);
  if (!indicesHold(cells, first, attributeCount)) throw fail('an index leads outside its arrays');
  const from = kHeaderBytes / 4 + cellCount * kCellWords;
  return { cells, first, ...packAttributes(words, from, attributeCount) };
}

function toKey(words: Uint32Array): BoxKey {
  return { level: words[3]! | 0, bx: words[4]! | 0, by: words[5]! | 0, bz: words[6]! | 0 };
}

// The hash of everything after the header; its seed is the hash of what precedes the checksum.
function checksumHolds(bytes: Uint8Array): boolean {
  const view = new DataView(bytes.buffer, bytes.byteOffset, kHeaderBytes);
  const seed = xxh64(bytes.subarray(0, kChecksumAt));
  return xxh64(bytes.subarray(kHeaderBytes), seed) === view.getBigUint64(kChecksumAt, true);
}

function splitCells(words: Uint32Array, count: number): Pick<BoxArrays, 'cells' | 'first'> {
  const cells = new Uint32Array(4 * count);
  const first = new Uint32Array(count);
  for (let i = 0; i < count; ++i) {
    const from = kHeaderBytes / 4 + kCellWords * i;
    cells[4 * i] = words[from]!;
    cells[4 * i + 1] = words[from + 1]!;
    cells[4 * i + 2] = words[from + 2]!;
    cells[4 * i + 3] = words[from + 3]!;
    first[i] = words[from + 4]!;
  }
  return { cells, first };
}

// Each level follows the one above it, in the order of the parents and of their bits: the first
// child of a cell with children is the next item that has no parent yet.
function indicesHold(cells: Uint32Array, first: Uint32Array, attributeCount: number): boolean {
  let begin = 0;
  let end = kRoots;
  for (let depth = 0; depth < 3; ++depth) {
    const firstChild = depth < 2 ? end : 0;
    let children = 0;
    for (let i = begin; i < end; ++i) {
      const detailLow = cells[4 * i + 2]!;
      const detailHigh = cells[4 * i + 3]!;
      if ((detailLow & ~cells[4 * i]!) !== 0 || (detailHigh & ~cells[4 * i + 1]!) !== 0) {
        return false;
      }
      const count = onesIn(detailLow) + onesIn(detailHigh);
      if (count !== 0 && first[i] !== firstChild + children) return false;
      children += count;
    }
    if (depth === 2) return end === first.length && children === attributeCount;
    begin = end;
    end += children;
    if (end > first.length) return false;
  }
  return false;
}

function packAttributes(
  words: Uint32Array,
  from: number,
  count: number,
): Pick<BoxArrays, 'attributes' | 'classes'> {
  const attributes = new Uint32Array(count);
  const classes = new Uint8Array(count);
  for (let i = 0; i < count; ++i) {
    // Material, class, flags, reserved; red, green, blue, reserved.
    const properties = words[from + 2 * i]!;
    const colour = words[from + 2 * i + 1]! & 0xffffff;
    const number = properties & 0xff;
    // As MaterialTable does (raytracer/core/material/material_table.hpp).
    const material = number < kMaterials ? number : kUnknownMaterial;
    const hasColour = (properties & 0x10000) !== 0 ? kHasColour : 0;
    const tinted = (properties & 0x20000) !== 0 ? kTinted : 0;
    attributes[i] = colour | (material << 24) | tinted | hasColour;
    classes[i] = properties >>> 8;
  }
  return { attributes, classes };
}

/** How many bits of a 32-bit word are set. */
function onesIn(word: number): number {
  const pairs = word - ((word >>> 1) & 0x55555555);
  const fours = (pairs & 0x33333333) + ((pairs >>> 2) & 0x33333333);
  return Math.imul((fours + (fours >>> 4)) & 0x0f0f0f0f, 0x01010101) >>> 24;
}

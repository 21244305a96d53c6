/** Reads boxes of version 1 (docs/formats/box.md): the top of a column, and its material. */

export type Look = { readonly material: number; readonly colour: string | undefined };
/** `y` is that of the highest solid voxel within the box, 0 to 255; `look` is unknown for rock that no one can see. */
export type TopVoxel = { readonly y: number; readonly look: Look | undefined };

const kHeaderBytes = 64;
const kCellBytes = 24;
const kAttributeBytes = 8;
const kMagic = 'TVXBOX\r\n';
const kBoxHeight = 256;

/** @param bytes the body as fetch hands it out: a Content-Encoding is undone by then. @throws Error when it is no box */
export function readBox(bytes: Uint8Array): BoxView {
  return new BoxView(bytes);
}

export class BoxView {
  readonly #view: DataView;
  readonly #cells: number;
  readonly #attributes: number;

  /** @throws Error when the bytes are no box of version 1 */
  constructor(bytes: Uint8Array) {
    this.#view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    const magic =
      bytes.byteLength >= kHeaderBytes ? String.fromCharCode(...bytes.subarray(0, 8)) : '';
    if (magic !== kMagic || this.#view.getUint32(8, true) !== 1) {
      throw new Error('read a box: not a box of version 1');
    }
    this.#cells = this.#view.getUint32(28, true);
    this.#attributes = this.#view.getUint32(32, true);
    if (
      this.#cells < 4 ||
      bytes.byteLength !==
        kHeaderBytes + this.#cells * kCellBytes + this.#attributes * kAttributeBytes
    ) {
      throw new Error('read a box: its size is not that of its header');
    }
  }

  /** The highest solid voxel above column (x, z), 0 to 63 each. */
  top(x: number, z: number): TopVoxel | undefined {
    for (let y = kBoxHeight - 1; y >= 0; --y) {
      const found = this.#voxel(x, y, z);
      if (found !== undefined) return { y, look: found === 'hidden' ? undefined : found };
    }
    return undefined;
  }

  // Root (64^3), then 16^3, then the brick (4^3) whose children are voxels.
  #voxel(x: number, y: number, z: number): Look | 'hidden' | undefined {
    let cell = y >> 6;
    for (const shift of [4, 2, 0]) {
      const bit = BigInt(((x >> shift) & 3) + 4 * ((z >> shift) & 3) + 16 * ((y >> shift) & 3));
      const at = kHeaderBytes + cell * kCellBytes;
      if (((this.#view.getBigUint64(at, true) >> bit) & 1n) === 0n) return undefined;
      const detail = this.#view.getBigUint64(at + 8, true);
      if (((detail >> bit) & 1n) === 0n) return 'hidden';
      const next = this.#view.getUint32(at + 16, true) + ones(detail & ((1n << bit) - 1n));
      if (shift === 0) return this.#look(next);
      if (next >= this.#cells) throw new Error('read a box: a cell beyond the end');
      cell = next;
    }
    return undefined;
  }

  #look(index: number): Look {
    if (index >= this.#attributes) throw new Error('read a box: an attribute beyond the end');
    const at = kHeaderBytes + this.#cells * kCellBytes + index * kAttributeBytes;
    const byte = (offset: number): number => this.#view.getUint8(at + offset);
    const hex = [4, 5, 6].map((offset) => byte(offset).toString(16).padStart(2, '0')).join('');
    return { material: byte(0), colour: (byte(2) & 1) === 1 ? `#${hex}` : undefined };
  }
}

function ones(bits: bigint): number {
  let sum = 0;
  for (let rest = bits; rest !== 0n; rest &= rest - 1n) ++sum;
  return sum;
}

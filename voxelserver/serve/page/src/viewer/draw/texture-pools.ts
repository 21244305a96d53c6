/**
 * The textures that hold boxes on the GPU: cells (16 + 4 bytes each) and attributes (4 + 1 bytes
 * each), in layers of 2^18 texels, as walk.glsl addresses them. Boxes take whole rows, and go on
 * in the next layer where one ends.
 */
import { clamp } from '../../vec3.js';
import type { BoxArrays } from '../data/box-arrays.js';
import type { Column } from '../data/columns.js';
import type { BoxSlot } from './column-table.js';
import type { StoredColumn } from './residency.js';
import { RowPool } from './row-pool.js';

/** As data/source.ts has a column. */
export type ColumnData = Pick<Column, 'byBegin' | 'boxes'>;

const kCellsRow = 256;
const kCellRows = 1024;
const kAttributesRow = 1024;
const kAttributeRows = 256;
const kLayerTexels = 2 ** 18;
const kCellBytes = 20;
const kAttributeBytes = 5;
// Of the bytes: surveyed land with woods and houses has 18 attributes a cell, which is a share of
// 0.21; what is flatter or sparser has fewer attributes.
const kCellShare = 0.3;

export class TexturePools {
  readonly cells: WebGLTexture;
  readonly first: WebGLTexture;
  readonly attributes: WebGLTexture;
  readonly classes: WebGLTexture;
  readonly bytes: number;
  readonly #gl: WebGL2RenderingContext;
  readonly #cellRows: RowPool;
  readonly #attributeRows: RowPool;
  readonly #rows = new Map<BoxSlot, { cells: number; attributes: number }>();

  /** @param bytes of all pools together @throws Error when the textures cannot be made */
  constructor(gl: WebGL2RenderingContext, bytes: number) {
    this.#gl = gl;
    const layers = Number(gl.getParameter(gl.MAX_ARRAY_TEXTURE_LAYERS));
    const share = bytes / kLayerTexels;
    const cellLayers = clamp(Math.floor((share * kCellShare) / kCellBytes), 1, layers);
    const attributeShare = (share * (1 - kCellShare)) / kAttributeBytes;
    const attributeLayers = clamp(Math.floor(attributeShare), 1, layers);
    this.#cellRows = new RowPool(cellLayers * kCellRows);
    this.#attributeRows = new RowPool(attributeLayers * kAttributeRows);
    this.cells = this.#make(gl.RGBA32UI, kCellsRow, kCellRows, cellLayers);
    this.first = this.#make(gl.R32UI, kCellsRow, kCellRows, cellLayers);
    this.attributes = this.#make(gl.RGBA8UI, kAttributesRow, kAttributeRows, attributeLayers);
    this.classes = this.#make(gl.R8UI, kAttributesRow, kAttributeRows, attributeLayers);
    this.bytes = kLayerTexels * (cellLayers * kCellBytes + attributeLayers * kAttributeBytes);
  }

  /** Share of the pools that is in use, [0, 1]. */
  get fill(): number {
    return Math.max(
      this.#cellRows.used / this.#cellRows.capacity,
      this.#attributeRows.used / this.#attributeRows.capacity,
    );
  }

  /** @return undefined when there is no room: drop something and try again */
  store(column: ColumnData): StoredColumn | undefined {
    const slots: BoxSlot[] = [];
    for (const box of column.boxes) {
      const slot = typeof box === 'string' ? { kind: box } : this.#storeBox(box);
      if (slot === undefined) {
        this.drop({ byBegin: column.byBegin, slots });
        return undefined;
      }
      slots.push(slot);
    }
    return { byBegin: column.byBegin, slots };
  }

  drop(column: StoredColumn): void {
    for (const slot of column.slots) {
      const rows = this.#rows.get(slot);
      if (rows === undefined || slot.kind !== 'box') continue;
      this.#cellRows.free(slot.cells / kCellsRow, rows.cells);
      if (rows.attributes > 0) {
        this.#attributeRows.free(slot.attributes / kAttributesRow, rows.attributes);
      }
      this.#rows.delete(slot);
    }
  }

  #storeBox(box: BoxArrays): BoxSlot | undefined {
    const rows = {
      cells: Math.ceil(box.first.length / kCellsRow),
      attributes: Math.ceil(box.attributes.length / kAttributesRow),
    };
    const cellRow = this.#cellRows.take(rows.cells);
    if (cellRow === undefined) return undefined;
    const attributeRow = rows.attributes === 0 ? 0 : this.#attributeRows.take(rows.attributes);
    if (attributeRow === undefined) {
      this.#cellRows.free(cellRow, rows.cells);
      return undefined;
    }
    const gl = this.#gl;
    const cells = padded(box.cells, rows.cells * kCellsRow * 4, Uint32Array);
    const first = padded(box.first, rows.cells * kCellsRow, Uint32Array);
    const at = { width: kCellsRow, row: cellRow, rows: rows.cells, layerRows: kCellRows };
    this.#upload(this.cells, at, gl.RGBA_INTEGER, gl.UNSIGNED_INT, cells);
    this.#upload(this.first, at, gl.RED_INTEGER, gl.UNSIGNED_INT, first);
    const length = rows.attributes * kAttributesRow;
    const words = padded(box.attributes, length, Uint32Array);
    const bytes = new Uint8Array(words.buffer, words.byteOffset, words.byteLength);
    const classes = padded(box.classes, length, Uint8Array);
    const size = { width: kAttributesRow, layerRows: kAttributeRows };
    const on = { ...size, row: attributeRow, rows: rows.attributes };
    this.#upload(this.attributes, on, gl.RGBA_INTEGER, gl.UNSIGNED_BYTE, bytes);
    this.#upload(this.classes, on, gl.RED_INTEGER, gl.UNSIGNED_BYTE, classes);
    const slot: BoxSlot = {
      kind: 'box',
      cells: cellRow * kCellsRow,
      attributes: attributeRow * kAttributesRow,
    };
    this.#rows.set(slot, rows);
    return slot;
  }

  #make(format: number, width: number, height: number, layers: number): WebGLTexture {
    const gl = this.#gl;
    const texture = gl.createTexture();
    if (texture === null) throw new Error('make the pools of boxes: the graphics context is lost');
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, texture);
    gl.texStorage3D(gl.TEXTURE_2D_ARRAY, 1, format, width, height, layers);
    gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    if (gl.getError() === gl.OUT_OF_MEMORY) {
      throw new Error('make the pools of boxes: the graphics memory does not suffice');
    }
    return texture;
  }

  /** @param data of all rows */
  #upload(
    texture: WebGLTexture,
    at: { width: number; row: number; rows: number; layerRows: number },
    format: number,
    type: number,
    data: Uint32Array | Uint8Array,
  ): void {
    const gl = this.#gl;
    const { width, layerRows } = at;
    const ofRow = data.length / at.rows;
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, texture);
    for (let done = 0; done < at.rows;) {
      const layer = Math.floor((at.row + done) / layerRows);
      const row = (at.row + done) % layerRows;
      const rows = Math.min(at.rows - done, layerRows - row);
      const part = data.subarray(done * ofRow, (done + rows) * ofRow);
      gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, 0, 0, row, layer, width, rows, 1, format, type, part);
      done += rows;
    }
  }
}

function padded<T extends Uint32Array | Uint8Array>(
  data: T,
  length: number,
  make: new (length: number) => T,
): T {
  if (data.length === length) return data;
  const out = new make(length);
  out.set(data);
  return out;
}

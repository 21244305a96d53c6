import { inflate, toView } from './bytes.js';

/**
 * Reads the rasters of analyses: Cloud Optimized GeoTIFFs as the server writes them. Tiled 32-bit
 * floats, pixel by pixel, compressed by DEFLATE with the predictor for floats. Not thread-safe.
 * Ref: Adobe, "TIFF Revision 6.0", 1992, and "TIFF Technical Note 3", 2005.
 */

/** @return the bytes [offset, offset + length) of the file, fewer at its end */
export type ReadAt = (offset: number, length: number) => Promise<Uint8Array>;

/** One resolution of a raster. */
export type RasterLevel = Readonly<ReturnType<typeof parseLevel>>;
export type RasterInfo = Readonly<ReturnType<typeof parseInfo>>;
type Bounds = [west: number, south: number, east: number, north: number];

const kHeadBytes = 1 << 16;
const kMaxHeadBytes = 1 << 24;
const kMaxSide = 65_536;
const kMaxTile = 4096;
const kMaxBands = 64;
const kMaxTiles = 1 << 20;
const kMaxLevels = 24;
/** Of a level that is read: its values are in memory at once. */
const kMaxCells = 1 << 24;

const kBytesOf: Readonly<Record<number, number>> = { 2: 1, 3: 2, 4: 4, 12: 8 };

type Fields = Map<number, readonly number[] | string>;

function refuse(what: string): never {
  throw new Error(`read the raster: ${what}`);
}

class Head {
  readonly #bytes: DataView;

  constructor(bytes: Uint8Array) {
    this.#bytes = toView(bytes);
  }

  /** @throws RangeError where the head that was read ends before */
  fields(at: number): { readonly fields: Fields; readonly next: number } {
    const fields: Fields = new Map();
    const count = this.#bytes.getUint16(at, true);
    for (let i = 0; i < count; ++i) {
      const entry = at + 2 + 12 * i;
      const type = this.#bytes.getUint16(entry + 2, true);
      const values = this.#bytes.getUint32(entry + 4, true);
      const size = kBytesOf[type];
      if (size === undefined) continue;
      if (values > kMaxTiles * 4) refuse(`a field of ${values} values`);
      const place = values * size <= 4 ? entry + 8 : this.#bytes.getUint32(entry + 8, true);
      fields.set(this.#bytes.getUint16(entry, true), this.#values(place, type, values));
    }
    return { fields, next: this.#bytes.getUint32(at + 2 + 12 * count, true) };
  }

  first(): number {
    if (this.#bytes.getUint32(0, true) !== 0x002a4949) refuse('not a TIFF of less than 4 GiB');
    return this.#bytes.getUint32(4, true);
  }

  #values(at: number, type: number, count: number): readonly number[] | string {
    if (type === 2) {
      const text = new Uint8Array(this.#bytes.buffer, this.#bytes.byteOffset + at, count);
      return new TextDecoder().decode(text).replace(/\0+$/, '');
    }
    const size = kBytesOf[type]!;
    return Array.from({ length: count }, (_, i) => {
      if (type === 3) return this.#bytes.getUint16(at + i * size, true);
      return type === 4
        ? this.#bytes.getUint32(at + i * size, true)
        : this.#bytes.getFloat64(at + i * size, true);
    });
  }
}

const numbers = (fields: Fields, tag: number): readonly number[] => {
  const found = fields.get(tag);
  return found === undefined || typeof found === 'string' ? [] : found;
};

function whole(fields: Fields, tag: number, what: string, max: number): number {
  const [value] = numbers(fields, tag);
  if (value === undefined || value < 1 || value > max) {
    refuse(`${what} ${String(value)}; allowed: 1 to ${max}`);
  }
  return value;
}

function parseLevel(fields: Fields, bands: number) {
  const [compression, predictor, planar] = [259, 317, 284].map((tag) => numbers(fields, tag)[0]);
  const isFloat =
    numbers(fields, 339).every((format) => format === 3) &&
    numbers(fields, 258).every((bits) => bits === 32);
  if (compression !== 8 || predictor !== 3 || planar !== 1 || !isFloat) {
    refuse('not 32-bit floats by DEFLATE, pixel by pixel');
  }
  if (whole(fields, 277, 'bands', kMaxBands) !== bands) refuse('levels of different bands');
  const level = {
    width: whole(fields, 256, 'columns', kMaxSide),
    height: whole(fields, 257, 'rows', kMaxSide),
    tileWidth: whole(fields, 322, 'columns of a tile', kMaxTile),
    tileHeight: whole(fields, 323, 'rows of a tile', kMaxTile),
    offsets: numbers(fields, 324),
    lengths: numbers(fields, 325),
  };
  const tiles =
    Math.ceil(level.width / level.tileWidth) * Math.ceil(level.height / level.tileHeight);
  if (level.offsets.length !== tiles || level.lengths.length !== tiles) {
    refuse(`${level.offsets.length} tiles instead of ${tiles}`);
  }
  return level;
}

/** Names and units of the bands: GDAL writes them as XML, of which these two forms are read. */
function parseBands(fields: Fields, count: number): { name: string; unit: string }[] {
  const text = fields.get(42112);
  const items = typeof text === 'string' ? text : '';
  const find = (role: string): Map<number, string> => {
    const pattern = new RegExp(
      `<Item name="[^"<>]*" sample="(\\d+)" role="${role}">([^<]*)</Item>`,
      'g',
    );
    return new Map(
      [...items.matchAll(pattern)].map(([, sample, value]) => [Number(sample), value ?? '']),
    );
  };
  const [names, units] = [find('description'), find('unittype')];
  return Array.from({ length: count }, (_, i) => ({
    name: names.get(i) ?? `band ${i + 1}`,
    unit: units.get(i) ?? '',
  }));
}

function readExtent(fields: Fields, width: number, height: number): Bounds {
  const [across, down] = numbers(fields, 33550);
  const [, , , west, north] = numbers(fields, 33922);
  if (across === undefined || down === undefined || west === undefined || north === undefined) {
    refuse('it has no place');
  }
  return [west, north - down * height, west + across * width, north];
}

function parseInfo(bytes: Uint8Array) {
  const head = new Head(bytes);
  const levels: RasterLevel[] = [];
  let first: Fields | undefined;
  for (let at = head.first(); at !== 0 && levels.length < kMaxLevels;) {
    const { fields, next } = head.fields(at);
    first ??= fields;
    levels.push(parseLevel(fields, whole(first, 277, 'bands', kMaxBands)));
    at = next;
  }
  const finest = levels[0];
  if (first === undefined || finest === undefined) refuse('it is empty');
  return {
    /** Finest first. */
    levels,
    bands: parseBands(first, whole(first, 277, 'bands', kMaxBands)),
    /** CRS units. */
    extent: readExtent(first, finest.width, finest.height),
    noData: Number(first.get(42113) ?? NaN),
  };
}

/** @throws Error for what is no such raster */
export async function readRasterInfo(readAt: ReadAt): Promise<RasterInfo> {
  // Heads are at the beginning; their size is known only by reading them.
  for (let size = kHeadBytes; size <= kMaxHeadBytes; size *= 4) {
    const bytes = await readAt(0, size);
    try {
      return parseInfo(bytes);
    } catch (error) {
      if (!(error instanceof RangeError) || bytes.length < size) throw error;
    }
  }
  return refuse('its head is too long');
}

/** The finest level that has so many cells at most; else the coarsest. */
export function levelFor(info: RasterInfo, maxCells: number): RasterLevel {
  return info.levels.find(({ width, height }) => width * height <= maxCells) ?? info.levels.at(-1)!;
}

/**
 * Undoes the predictor of a row: bytes are differences to those of the pixel before, and the first
 * bytes of all values come before their second ones, the highest first.
 */
function decodeFloats(row: Uint8Array, bands: number, band: number, out: Float32Array): void {
  for (let i = bands; i < row.length; ++i) row[i] = (row[i]! + row[i - bands]!) & 255;
  const values = row.length / 4;
  const bytes = new DataView(new ArrayBuffer(4));
  for (let x = 0; x < out.length; ++x) {
    const at = x * bands + band;
    for (let b = 0; b < 4; ++b) bytes.setUint8(b, row[b * values + at]!);
    out[x] = bytes.getFloat32(0);
  }
}

/**
 * Reads the values of a band, row by row from the north-west.
 * @param band from 0 on
 * @throws Error where the file is damaged, or cannot be read
 */
export async function readBand(
  readAt: ReadAt,
  info: RasterInfo,
  level: RasterLevel,
  band: number,
): Promise<Float32Array> {
  const bands = info.bands.length;
  if (level.width * level.height > kMaxCells) {
    refuse(`${level.width} x ${level.height} cells in one level`);
  }
  const out = new Float32Array(level.width * level.height).fill(info.noData);
  const columns = Math.ceil(level.width / level.tileWidth);
  for (const [tile, length] of level.lengths.entries()) {
    if (length === 0) continue;
    const bytes = await readAt(level.offsets[tile]!, length);
    const rowBytes = level.tileWidth * bands * 4;
    const size = rowBytes * level.tileHeight;
    const plain = await inflate(bytes, 'deflate', size);
    if (plain === undefined) refuse('a tile is longer than it may be');
    if (plain.length < size) refuse('a tile is cut short');
    const [x0, y0] = [
      (tile % columns) * level.tileWidth,
      Math.floor(tile / columns) * level.tileHeight,
    ];
    const row = new Float32Array(Math.min(level.tileWidth, level.width - x0));
    for (let y = 0; y < level.tileHeight && y0 + y < level.height; ++y) {
      decodeFloats(plain.subarray(y * rowBytes, (y + 1) * rowBytes), bands, band, row);
      out.set(row, (y0 + y) * level.width + x0);
    }
  }
  return out;
}

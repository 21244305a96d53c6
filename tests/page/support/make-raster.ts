import { deflateSync } from 'node:zlib';

/**
 * A raster as the server writes them: one level, tiled 32-bit floats by DEFLATE with predictor 3.
 */
export type MadeRaster = {
  readonly width: number;
  readonly height: number;
  readonly tile: number;
  /** By band, row by row. */
  readonly bands: readonly {
    readonly name: string;
    readonly unit: string;
    /** How it is drawn; undefined: not at all. */
    readonly about?: Readonly<Record<string, string>>;
    readonly values: readonly number[];
  }[];
  readonly west: number;
  readonly north: number;
  readonly cell: number;
};

export const kNoData = -9999;

/** The predictor of a row of `tile` pixels: bytes by their rank, then differences. */
function predicted(values: readonly number[], bands: number): Buffer {
  const plain = Buffer.alloc(4 * values.length);
  values.forEach((value, i) => {
    const bytes = Buffer.alloc(4);
    bytes.writeFloatBE(value);
    for (let b = 0; b < 4; ++b) plain[b * values.length + i] = bytes[b]!;
  });
  const out = Buffer.from(plain);
  for (let i = bands; i < out.length; ++i) out[i] = (plain[i]! - plain[i - bands]!) & 255;
  return out;
}

function makeTiles({ width, height, tile, bands }: MadeRaster): Buffer[] {
  const out: Buffer[] = [];
  for (let y0 = 0; y0 < height; y0 += tile) {
    for (let x0 = 0; x0 < width; x0 += tile) {
      const rows: Buffer[] = [];
      for (let y = y0; y < y0 + tile; ++y) {
        const row: number[] = [];
        for (let x = x0; x < x0 + tile; ++x) {
          row.push(
            ...bands.map(({ values }) =>
              x < width && y < height ? values[y * width + x]! : kNoData,
            ),
          );
        }
        rows.push(predicted(row, bands.length));
      }
      out.push(deflateSync(Buffer.concat(rows)));
    }
  }
  return out;
}

function makeMetadata({ bands }: MadeRaster): string {
  const items = bands.flatMap(({ name, unit, about = {} }, i) => [
    `<Item name="DESCRIPTION" sample="${i}" role="description">${name}</Item>`,
    `<Item name="UNITTYPE" sample="${i}" role="unittype">${unit}</Item>`,
    ...Object.entries(about).map(
      ([item, text]) => `<Item name="terravox_${item}" sample="${i}">${text}</Item>`,
    ),
  ]);
  // So long that a reader fetches it apart from the numbers of the image.
  const long = `<Item name="ABOUT">${'x'.repeat(8192)}</Item>`;
  return `<GDALMetadata>${items.join('')}${long}</GDALMetadata>\0`;
}

export function makeRaster(raster: MadeRaster): Buffer {
  const tiles = makeTiles(raster);
  const count = raster.bands.length;
  const fields = new Map<number, { type: number; values: number[] | string }>([
    [256, { type: 3, values: [raster.width] }],
    [257, { type: 3, values: [raster.height] }],
    [258, { type: 3, values: raster.bands.map(() => 32) }],
    [259, { type: 3, values: [8] }],
    [277, { type: 3, values: [count] }],
    [284, { type: 3, values: [1] }],
    [317, { type: 3, values: [3] }],
    [322, { type: 3, values: [raster.tile] }],
    [323, { type: 3, values: [raster.tile] }],
    [324, { type: 4, values: tiles.map(() => 0) }], // set below
    [325, { type: 4, values: tiles.map((tile) => tile.length) }],
    [339, { type: 3, values: raster.bands.map(() => 3) }],
    [33550, { type: 12, values: [raster.cell, raster.cell, 0] }],
    [33922, { type: 12, values: [0, 0, 0, raster.west, raster.north, 0] }],
    [42112, { type: 2, values: makeMetadata(raster) }],
    [42113, { type: 2, values: `${kNoData}\0` }],
  ]);
  const toBytes = ({ type, values }: { type: number; values: number[] | string }): Buffer => {
    if (typeof values === 'string') return Buffer.from(values, 'latin1');
    const size = { 3: 2, 4: 4, 12: 8 }[type]!;
    const out = Buffer.alloc(size * values.length);
    for (const [i, value] of values.entries()) {
      if (type === 3) out.writeUInt16LE(value, i * size);
      else if (type === 4) out.writeUInt32LE(value, i * size);
      else out.writeDoubleLE(value, i * size);
    }
    return out;
  };
  const headBytes = 8 + 2 + 12 * fields.size + 4;
  const longBytes = [...fields.values()]
    .map((field) => toBytes(field).length)
    .filter((length) => length > 4)
    .reduce((sum, length) => sum + length, 0);
  let at = headBytes + longBytes;
  fields.get(324)!.values = tiles.map((tile) => {
    at += tile.length;
    return at - tile.length;
  });
  const head = Buffer.alloc(headBytes);
  head.write('II*\0', 'latin1');
  head.writeUInt32LE(8, 4);
  head.writeUInt16LE(fields.size, 8);
  const long: Buffer[] = [];
  let place = headBytes;
  [...fields].forEach(([tag, field], i) => {
    const entry = 10 + 12 * i;
    const bytes = toBytes(field);
    head.writeUInt16LE(tag, entry);
    head.writeUInt16LE(field.type, entry + 2);
    head.writeUInt32LE(field.values.length, entry + 4);
    if (bytes.length <= 4) bytes.copy(head, entry + 8);
    else {
      head.writeUInt32LE(place, entry + 8);
      place += bytes.length;
      long.push(bytes);
    }
  });
  return Buffer.concat([head, ...long, ...tiles]);
}

import { deflateSync } from 'node:zlib';

/** Side of the pixels of the synthetic picture. */
export const kPatternStep_m = 0.5;

/**
 * The synthetic picture: each pixel of a grid of 0.5 m has a colour that identifies it, so
 * that a picture that is shifted by half a pixel, turned, or joined wrongly differs everywhere.
 */
export function patternAt(easting: number, northing: number): [number, number, number] {
  const column = Math.floor(easting / kPatternStep_m);
  const row = Math.floor(northing / kPatternStep_m);
  return [column & 255, row & 255, ((column >> 8) & 15) | (((row >> 8) & 15) << 4)];
}

/** Draws west, south, east, north into pixels; rows from the north. */
export function drawPattern(
  bounds: readonly number[],
  width_px: number,
  height_px: number,
): Buffer {
  const [west = 0, south = 0, east = 0, north = 0] = bounds;
  const pixels = Buffer.alloc(width_px * height_px * 3);
  for (let y = 0; y < height_px; ++y) {
    for (let x = 0; x < width_px; ++x) {
      const colour = patternAt(
        west + ((x + 0.5) * (east - west)) / width_px,
        north - ((y + 0.5) * (north - south)) / height_px,
      );
      pixels.set(colour, (y * width_px + x) * 3);
    }
  }
  return pixels;
}

/**
 * Ref: ISO/IEC 15948:2004 (PNG).
 * @param pixels RGB, or grey with `channels` 1
 */
export function encodePng(
  pixels: Buffer,
  width_px: number,
  height_px: number,
  channels: 1 | 3 = 3,
): Buffer {
  const line = width_px * channels;
  const raw = Buffer.alloc((line + 1) * height_px);
  for (let y = 0; y < height_px; ++y) {
    pixels.copy(raw, y * (line + 1) + 1, y * line, (y + 1) * line);
  }
  const header = Buffer.alloc(13);
  header.writeUInt32BE(width_px, 0);
  header.writeUInt32BE(height_px, 4);
  header.set([8, channels === 3 ? 2 : 0, 0, 0, 0], 8);
  const signature = Buffer.from([0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a]);
  return Buffer.concat([
    signature,
    chunk('IHDR', header),
    chunk('IDAT', deflateSync(raw)),
    chunk('IEND', Buffer.alloc(0)),
  ]);
}

function chunk(type: string, data: Buffer): Buffer {
  const body = Buffer.concat([Buffer.from(type, 'latin1'), data]);
  const out = Buffer.alloc(body.length + 8);
  out.writeUInt32BE(data.length, 0);
  body.copy(out, 4);
  out.writeUInt32BE(crc32(body), body.length + 4);
  return out;
}

function crc32(bytes: Buffer): number {
  let crc = ~0;
  for (const byte of bytes) {
    crc ^= byte;
    for (let bit = 0; bit < 8; ++bit) crc = (crc >>> 1) ^ (crc & 1 ? 0xedb88320 : 0);
  }
  return ~crc >>> 0;
}

/**
 * Numbers in [0, 1) that depend on the seed only.
 * Ref: Ettinger, "mulberry32", 2017.
 */
export function seededRandom(seed: number): () => number {
  let state = seed >>> 0;
  return () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let mixed = Math.imul(state ^ (state >>> 15), state | 1);
    mixed ^= mixed + Math.imul(mixed ^ (mixed >>> 7), mixed | 61);
    return ((mixed ^ (mixed >>> 14)) >>> 0) / 2 ** 32;
  };
}

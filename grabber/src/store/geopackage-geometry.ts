import { GrabberError } from '../util/errors.js';

/** [longitude, latitude], degrees. */
export type Position = readonly [number, number];
/** The first ring is the outer one; each closes, its last position is its first. */
export type Rings = readonly (readonly Position[])[];
/** West, east, south, north: the order of the format's envelope. */
export type Envelope = readonly [minX: number, maxX: number, minY: number, maxY: number];

const kWgs84 = 4326;
const kHeaderBytes = 40;
/** Version 0 (bits 1-3: envelope of x and y), little-endian (bit 0). */
const kFlags = 0b0000_0011;
const kPolygon = 3;
/** More than any area has; a damaged count must not fill the memory. */
const kMaxPositions = 1_000_000;

/**
 * A polygon in EPSG:4326 as GeoPackageBinary: header with envelope, then little-endian WKB.
 * Ref: OGC 12-128r19, "OGC GeoPackage Encoding Standard", 2024, clause 2.1.3.
 */
export function encodePolygon(rings: Rings): Buffer {
  const positions = rings.reduce((sum, ring) => sum + ring.length, 0);
  const out = Buffer.alloc(kHeaderBytes + 9 + 4 * rings.length + 16 * positions);
  out.write('GP', 0, 'latin1');
  out.writeUInt8(kFlags, 3);
  out.writeInt32LE(kWgs84, 4);
  measureEnvelope(rings).forEach((value, index) => out.writeDoubleLE(value, 8 + 8 * index));
  let at = kHeaderBytes;
  at = out.writeUInt8(1, at);
  at = out.writeUInt32LE(kPolygon, at);
  at = out.writeUInt32LE(rings.length, at);
  for (const ring of rings) {
    at = out.writeUInt32LE(ring.length, at);
    for (const [x, y] of ring) {
      at = out.writeDoubleLE(x, at);
      at = out.writeDoubleLE(y, at);
    }
  }
  return out;
}

/**
 * @param shown names the geometry in messages
 * @throws GrabberError STORE_DAMAGED
 */
export function decodePolygon(blob: Uint8Array, shown: string): Position[][] {
  const bytes = Buffer.from(blob.buffer, blob.byteOffset, blob.byteLength);
  const fail = (what: string): never => {
    throw new GrabberError(
      'STORE_DAMAGED',
      `read geometry of ${shown}: ${what}; allowed: a GeoPackage polygon in EPSG:4326`,
    );
  };
  let at = polygonStart(bytes, fail);
  const count = (): number => {
    if (at + 4 > bytes.length) return fail('it is cut off');
    at += 4;
    return bytes.readUInt32LE(at - 4);
  };
  const rings: Position[][] = [];
  const ringCount = count();
  if (ringCount < 1 || ringCount > kMaxPositions) fail(`${ringCount} rings`);
  for (let index = 0; index < ringCount; ++index) {
    const length = count();
    if (length > kMaxPositions || at + 16 * length > bytes.length) return fail('it is cut off');
    const ring = Array.from({ length }, (_unused, i): Position => [
      bytes.readDoubleLE(at + 16 * i),
      bytes.readDoubleLE(at + 16 * i + 8),
    ]);
    if (ring.some(([x, y]) => !Number.isFinite(x) || !Number.isFinite(y))) {
      fail('a position is no number');
    }
    rings.push(ring);
    at += 16 * length;
  }
  return rings;
}

/** Of the header that encodePolygon and every GIS program write; undefined when there is none. */
export function envelopeOfBlob(blob: Uint8Array): Envelope | undefined {
  const bytes = Buffer.from(blob.buffer, blob.byteOffset, blob.byteLength);
  if (
    bytes.length < kHeaderBytes ||
    bytes.toString('latin1', 0, 2) !== 'GP' ||
    (bytes.readUInt8(3) & 1) === 0
  ) {
    return undefined;
  }
  if (((bytes.readUInt8(3) >> 1) & 7) === 0) return undefined;
  return [
    bytes.readDoubleLE(8),
    bytes.readDoubleLE(16),
    bytes.readDoubleLE(24),
    bytes.readDoubleLE(32),
  ];
}

export function measureEnvelope(rings: Rings): Envelope {
  let minX = Infinity;
  let maxX = -Infinity;
  let minY = Infinity;
  let maxY = -Infinity;
  for (const ring of rings) {
    for (const [x, y] of ring) {
      minX = Math.min(minX, x);
      maxX = Math.max(maxX, x);
      minY = Math.min(minY, y);
      maxY = Math.max(maxY, y);
    }
  }
  return [minX, maxX, minY, maxY];
}

/**
 * GIS programs may have written the geometry anew, so every envelope is understood.
 * @return where the count of rings stands
 */
function polygonStart(bytes: Buffer, fail: (what: string) => never): number {
  if (bytes.length < 8 || bytes.toString('latin1', 0, 2) !== 'GP') {
    fail('it does not start with "GP"');
  }
  const flags = bytes.readUInt8(3);
  const envelopeBytes = [0, 32, 48, 48, 64][(flags >> 1) & 7];
  if (bytes.readUInt8(2) !== 0 || (flags & 1) === 0 || envelopeBytes === undefined) {
    return fail(`version or flags ${flags}`);
  }
  if (bytes.readInt32LE(4) !== kWgs84) fail(`its srs_id is ${bytes.readInt32LE(4)}`);
  const at = 8 + envelopeBytes;
  if (bytes.length < at + 9) fail('it is cut off');
  if (bytes.readUInt8(at) !== 1 || bytes.readUInt32LE(at + 1) !== kPolygon) {
    fail('it is no little-endian polygon');
  }
  return at + 5;
}

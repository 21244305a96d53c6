import { type Point, findProjection } from '../geo/crs.js';
import { measureBounds, ringOfBox } from '../geo/bounds.js';
import type { Database, Statement } from './sqlite.js';
import type { BoundsM } from '../model/store.js';
import { GrabberError } from '../util/errors.js';

/**
 * Keeps the row of a layer in gpkg_contents up to date: its extent, and when it last changed.
 * Called within the change's transaction.
 */
export class Contents {
  readonly #touch: Statement;
  readonly #grow: Statement;
  readonly #set: Statement;
  readonly #geometries: Statement;

  constructor(db: Database, table: string) {
    const where = `WHERE table_name = '${table}'`;
    this.#touch = db.prepare(`UPDATE gpkg_contents SET last_change = ? ${where}`);
    this.#grow = db.prepare(
      'UPDATE gpkg_contents SET min_x = min(coalesce(min_x, @a), @a), max_x = ' +
        'max(coalesce(max_x, @b), @b), ' +
        `min_y = min(coalesce(min_y, @c), @c), max_y = max(coalesce(max_y, @d), @d) ${where}`,
    );
    this.#set = db.prepare(
      `UPDATE gpkg_contents SET min_x = ?, max_x = ?, min_y = ?, max_y = ? ${where}`,
    );
    this.#geometries = db.prepare(
      `SELECT substr(geom, 1, 40) AS start FROM ${table} WHERE geom IS NOT NULL`,
    );
  }

  touch(now: string): void {
    this.#touch.run(now);
  }

  grow([a, b, c, d]: Envelope): void {
    this.#grow.run({ a, b, c, d });
  }

  /** After a geometry has moved: the extent may have shrunk. */
  measure(): void {
    const extent = new Extent();
    for (const { start } of this.#geometries.iterate() as Iterable<{ start: Uint8Array }>) {
      extent.add(start);
    }
    this.#set.run(...(extent.envelope ?? [null, null, null, null]));
  }
}

/** Collects the extent of geometries. */
export class Extent {
  envelope: Envelope | undefined;

  add(blob: Uint8Array | null): void {
    const one = blob === null ? undefined : envelopeOfBlob(blob);
    if (one === undefined) return;
    const [a, b, c, d] = this.envelope ?? one;
    this.envelope = [
      Math.min(a, one[0]),
      Math.max(b, one[1]),
      Math.min(c, one[2]),
      Math.max(d, one[3]),
    ];
  }
}

/**
 * Encodes a square in metres as a polygon in degrees.
 * @return GeoPackageBinary, null where the ground is not known: a picture for maps, on which
 * nothing else depends
 */
export function encodeFootprint(bounds: BoundsM | null, crs: string | null): Buffer | null {
  if (bounds === null || crs === null) return null;
  let ring: Point[];
  try {
    const projection = findProjection(crs);
    ring = ringOfBox(bounds).map((corner) => projection.toDegrees(corner));
  } catch (error) {
    if (error instanceof GrabberError) return null;
    throw error;
  }
  return ring.every(onEarth) ? encodeRing(ring) : null;
}

function onEarth([longitude, latitude]: Point): boolean {
  return Math.abs(longitude) <= 180 && Math.abs(latitude) <= 90;
}

/** West, east, south, north: the order of the format's envelope. */
export type Envelope = readonly [minX: number, maxX: number, minY: number, maxY: number];

const kWgs84 = 4326;
const kHeaderBytes = 40;
/** Version 0 (bits 1-3: envelope of x and y), little-endian (bit 0). */
const kFlags = 0b0000_0011;
const kPolygon = 3;

/**
 * A polygon of one closed ring in EPSG:4326 as GeoPackageBinary: header with envelope, then
 * little-endian WKB.
 * Ref: OGC 12-128r19, "OGC GeoPackage Encoding Standard", 2024, clause 2.1.3.
 */
function encodeRing(ring: readonly Point[]): Buffer {
  const out = Buffer.alloc(kHeaderBytes + 13 + 16 * ring.length);
  out.write('GP', 0, 'latin1');
  out.writeUInt8(kFlags, 3);
  out.writeInt32LE(kWgs84, 4);
  const [west, south, east, north] = measureBounds(ring);
  [west, east, south, north].forEach((value, index) => out.writeDoubleLE(value, 8 + 8 * index));
  let at = out.writeUInt8(1, kHeaderBytes);
  for (const count of [kPolygon, 1, ring.length]) at = out.writeUInt32LE(count, at);
  for (const value of ring.flat()) at = out.writeDoubleLE(value, at);
  return out;
}

/** Of the header that encodeRing and every GIS program write; undefined when there is none. */
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

import { createHash } from 'node:crypto';
import { mkdir, writeFile } from 'node:fs/promises';
import { dirname, join } from 'node:path';
import type {
  CatalogueSquare,
  RecordKey,
  StoredFile,
  Terms,
  Store,
  Verified,
} from '../../../grabber/src/model/store.js';
import { kPlaces } from '../../../grabber/src/store/layout.js';
import { seededRandom } from '../portal/pattern.js';
import { makeSquare } from './store-fixture.js';

export const kTerms: Terms = {
  crs: 'EPSG:3794',
  classTable: 'si-lss',
  licence: 'CC BY 4.0',
  attribution: 'ARSO',
};

/** A square E_N of 1 km, as a catalogue has it. */
export function catalogueSquare(
  e: number,
  n: number,
  more: Partial<CatalogueSquare> = {},
): CatalogueSquare {
  return makeSquare(`${e}_${n}`, [`http://h/${e}_${n}.laz`], more);
}

export function keyOfSquare(name: string, source = 'si-lss', grid = source): RecordKey {
  return { source, grid, name };
}

export function storedFile(name: string, bytes = 5, digit = '0', source = 'si-lss'): StoredFile {
  return { path: `lidar/${source}/${name}.laz`, bytes, sha256: digit.repeat(64) };
}

export const kVerified: Verified = {
  points: { pointCount: 10, lasVersion: '1.2', pointFormat: 1, min: [1, 2, 3.5], max: [4, 5, 6] },
  image: null,
  crs: null,
  warnings: [],
};

/** Whole numbers below a limit that depend on the seed only. */
export function seeded(seed: number): (below: number) => number {
  const random = seededRandom(seed);
  return (below) => Math.floor(random() * below);
}

/** Puts a file into a store as a fetch does: on the disk, and into the record of its square. */
export async function bringIn(
  store: Store,
  key: RecordKey,
  body: Buffer,
  extension = 'laz',
): Promise<string> {
  const path = kPlaces.finished('lidar', key, extension);
  await put(store.root, path, body);
  store.squares.want([key]);
  store.squares.begin(key, 'http://h/a');
  store.squares.fetched(key, { path, bytes: body.length, sha256: computeSha256(body) });
  return path;
}

export async function put(root: string, path: string, body: string | Buffer): Promise<void> {
  await mkdir(dirname(join(root, path)), { recursive: true });
  await writeFile(join(root, path), body);
}

export function computeSha256(body: Buffer): string {
  return createHash('sha256').update(body).digest('hex');
}

/** The positions of the first ring of a polygon in a store: after 40 bytes of header, as WKB. */
export function readRing(blob: Uint8Array): [number, number][] {
  const bytes = Buffer.from(blob.buffer, blob.byteOffset, blob.byteLength);
  return Array.from({ length: bytes.readUInt32LE(49) }, (_unused, index) => [
    bytes.readDoubleLE(53 + 16 * index),
    bytes.readDoubleLE(61 + 16 * index),
  ]);
}

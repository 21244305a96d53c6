import type {
  BoundsM,
  CatalogueSquare,
  RecordKey,
  StoredFile,
  Terms,
} from '../../../grabber/src/model/square.js';
import type { Verified } from '../../../grabber/src/model/store.js';

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
  const bounds: BoundsM = [e * 1000, n * 1000, e * 1000 + 1000, n * 1000 + 1000];
  const name = `${e}_${n}`;
  return {
    name,
    block: null,
    bounds,
    urls: [`http://h/${name}.laz`],
    bytes: null,
    sha256: null,
    member: null,
    published: null,
    ...more,
  };
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

/**
 * A small generator whose seed a failing test prints. Ref: Steele, Lea, Flood, "Fast Splittable
 * Pseudorandom Number Generators", 2014.
 */
export function seeded(seed: number): (below: number) => number {
  let state = seed >>> 0;
  return (below) => {
    state = (state + 0x9e3779b9) >>> 0;
    let mixed = Math.imul(state ^ (state >>> 16), 0x21f0aaad);
    mixed = Math.imul(mixed ^ (mixed >>> 15), 0x735a2d97);
    return ((mixed ^ (mixed >>> 15)) >>> 0) % below;
  };
}

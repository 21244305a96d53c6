import type { Vec2, Vec3 } from './vec3.js';
import { isFields, isNumber, toList, toText } from './json.js';

/** LiDAR squares and kept boxes, as the server lists them. */

export type SquareState = 'wanted' | 'fetched' | 'prepared' | 'failed';
export const kSquareStates: readonly SquareState[] = ['wanted', 'fetched', 'prepared', 'failed'];

/** Easting and northing in units of the CRS. */
export type Position = Vec2;
/** A square with its outline, the outer ring first. */
export type Square = Readonly<NonNullable<ReturnType<typeof readSquare>>>;
/** Boxes (bx, by, bz) of one level. */
export type CachedBoxes = Readonly<ReturnType<typeof parseCachedBoxes>>;

const numberOrNot = (value: unknown): number | undefined => (isNumber(value) ? value : undefined);

/** Leaves out what is no list of so many numbers. */
function readTuples<T extends readonly number[]>(value: unknown, length: T['length']): T[] {
  const tuples = toList(value).map((item) => toList(item).slice(0, length).filter(isNumber));
  return tuples.filter((tuple) => tuple.length === length) as unknown as T[];
}

/** Leaves out what is no polygon: one bad square must not hide the others. */
export function readSquares(json: unknown): Square[] {
  if (!isFields(json) || !Array.isArray(json['features'])) {
    throw new Error('read the squares: no GeoJSON FeatureCollection');
  }
  return toList(json['features'])
    .map(readSquare)
    .filter((square) => square !== undefined);
}

function readSquare(feature: unknown) {
  if (!isFields(feature) || !isFields(feature['geometry']) || !isFields(feature['properties'])) {
    return undefined;
  }
  const rings: readonly (readonly Position[])[] = toList(feature['geometry']['coordinates'])
    .map((ring) => readTuples<Position>(ring, 2))
    .filter((ring) => ring.length >= 3);
  if (feature['geometry']['type'] !== 'Polygon' || rings.length === 0) return undefined;
  const p = feature['properties'];
  return {
    name: toText(p['name']),
    state: kSquareStates.find((state) => state === p['state']) ?? 'wanted',
    file: toText(p['file']),
    points: numberOrNot(p['points']),
    densityPerM2: numberOrNot(p['density_per_m2']),
    bytes: numberOrNot(p['bytes']),
    source: toText(p['source']),
    licence: toText(p['licence']),
    attribution: toText(p['attribution']),
    error: toText(p['error']),
    rings,
  };
}

export const readCachedBoxes = (json: unknown): CachedBoxes => parseCachedBoxes(json);

function parseCachedBoxes(json: unknown) {
  if (!isFields(json) || !isNumber(json['level'])) throw new Error('read the kept boxes: no level');
  return {
    level: json['level'],
    changes: numberOrNot(json['changes']) ?? 0,
    memory: readTuples<Vec3>(json['memory'], 3),
    disk: readTuples<Vec3>(json['disk'], 3),
    truncated: json['truncated'] === true,
  };
}

/** The even-odd rule over all rings. */
export function squareContains(square: Square, [e, n]: Position): boolean {
  let inside = false;
  for (const ring of square.rings) {
    for (const [i, [ax, ay]] of ring.entries()) {
      const [bx, by] = ring.at(i - 1)!;
      if (ay > n !== by > n && e < ((bx - ax) * (n - ay)) / (by - ay) + ax) inside = !inside;
    }
  }
  return inside;
}

/**
 * Finds the name of the square at a place; '' where there is none.
 * @param fetchList is called with the first question, and again after it has failed
 */
export function squareNames(fetchList: () => Promise<unknown>): (at: Position) => Promise<string> {
  let list: Promise<readonly Square[]> | undefined;
  return async (at) => {
    list ??= fetchList().then(readSquares);
    try {
      return (await list).find((square) => squareContains(square, at))?.name ?? '';
    } catch (error) {
      list = undefined;
      throw error;
    }
  };
}

export type Extent = [number, number, number, number];

/** @return west, south, east, north */
export function measureExtent(square: Square): Extent {
  const all = square.rings.flat();
  const es = all.map((p) => p[0]);
  const ns = all.map((p) => p[1]);
  return [Math.min(...es), Math.min(...ns), Math.max(...es), Math.max(...ns)];
}

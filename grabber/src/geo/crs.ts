import { createRequire } from 'node:module';
import type proj4 from 'proj4';
import { GrabberError, describeError, causedError } from '../util/errors.js';

/** East and north in the CRS's own unit, or longitude and latitude in degrees: always x first. */
export type Point = readonly [x: number, y: number];

/**
 * A projected CRS against WGS 84, enough to choose squares, not to move points: good to a few
 * metres for the CRSs of the shipped sources (tests compare them with PROJ), for some older
 * national datums only to about 200 m.
 */
export type Projection = {
  /** `EPSG:n` */
  readonly code: string;
  /** @throws GrabberError CRS where the projection has no value */
  fromDegrees(lonLat: Point): Point;
  /** @throws GrabberError CRS where the projection has no value */
  toDegrees(eastNorth: Point): Point;
};

type Entry = { readonly kind: string; readonly proj4: string | null };

const kCode = /^EPSG:(\d{4,6})$/;
const kWgs84 = 'WGS84';
const kCovered = 'points the projection is made for';

/**
 * Datum shifts that the index has in other units and with other signs than proj4 reads them, which
 * puts places 170 m away. Metres, seconds of arc (position vector), parts per million. Ref:
 * EPSG:15934 for the Netherlands, its rotations turned from microradians (coordinate frame) to
 * seconds.
 */
const kDatumShifts: Readonly<Record<string, string>> = {
  'EPSG:28992': '565.4171,50.3319,465.5524,-0.398957,0.343988,-1.877403,4.0725',
};
const require = createRequire(import.meta.url);
const known = new Map<string, Projection | GrabberError>();

/**
 * @param code `EPSG:n`
 * @throws GrabberError CRS when its projection is not known
 */
export function findProjection(code: string): Projection {
  const found = known.get(code) ?? makeProjection(code);
  known.set(code, found);
  if (found instanceof GrabberError) throw found;
  return found;
}

/** @return the error, which is kept too: a whole catalogue may be in a CRS that is not known */
function makeProjection(code: string): Projection | GrabberError {
  // Loaded when the first place is projected: commands that only read the store start faster
  // without.
  const project = require('proj4') as typeof proj4;
  let converter: proj4.Converter;
  try {
    converter = project(kWgs84, findDefinition(code));
  } catch (error) {
    return error instanceof GrabberError ? error : unknownCrs(code, describeError(error), error);
  }
  return {
    code,
    fromDegrees: (point) =>
      checked(`project ${point.join(',')} to ${code}`, () => converter.forward([...point])),
    toDegrees: (point) =>
      checked(`project ${point.join(',')} of ${code} to degrees`, () =>
        converter.inverse([...point]),
      ),
  };
}

function findDefinition(code: string): string {
  const number = kCode.exec(code)?.[1];
  if (number === undefined) throw unknownCrs(code, 'not a code');
  let entry: Entry;
  try {
    // The index holds a file for each code; all of it together would be megabytes at every start.
    entry = require(`epsg-index/s/${Number(number)}.json`) as Entry;
  } catch (error) {
    throw unknownCrs(code, 'not in the EPSG index', error);
  }
  if (entry.proj4 === null || entry.proj4 === '') {
    throw unknownCrs(code, `no projection (${entry.kind})`);
  }
  if (/\+proj=(longlat|geocent)/.test(entry.proj4)) {
    throw unknownCrs(code, `not projected (${entry.kind})`);
  }
  const shift = kDatumShifts[code];
  return shift === undefined
    ? entry.proj4
    : entry.proj4.replace(/\+towgs84=\S+/, `+towgs84=${shift}`);
}

function unknownCrs(code: string, why: string, cause?: unknown): GrabberError {
  return new GrabberError(
    'CRS',
    `use CRS ${code}: ${why}; allowed: EPSG:<number> of a projected CRS, such as EPSG:3794`,
    { cause },
  );
}

/** proj4 throws for some points out of range and returns NaN or infinity for others. */
function checked(attempt: string, action: () => number[]): Point {
  let [x, y]: (number | undefined)[] = [];
  try {
    [x, y] = action();
  } catch (error) {
    throw causedError('CRS', attempt, error, kCovered);
  }
  if (x !== undefined && y !== undefined && Number.isFinite(x) && Number.isFinite(y)) return [x, y];
  throw new GrabberError('CRS', `${attempt}: no finite value; allowed: ${kCovered}`);
}

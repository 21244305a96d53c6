import type { LatLon, WorldProjection } from './world-projection.js';

/** Coordinates as users write and read them. */

export type FoundPlace = { readonly easting: number; readonly northing: number };

const kNumber = /^[-+]?(\d+(\.\d*)?|\.\d+)$/;

/**
 * Reads "easting, northing" or "latitude, longitude", separated by a comma, a semicolon or blanks;
 * N, S, E and W may follow a number. Two numbers that lie within the world as easting and northing
 * are read so; others are latitude and longitude where they can be.
 * @return the place, or a sentence with the reason why there is none
 */
export function parsePlace(text: string, projection: WorldProjection): FoundPlace | string {
  const parts = text
    .replace(/°/g, ' ')
    .replace(/([NSEWnsew])/g, ' $1 ')
    .split(/[\s,;]+/)
    .filter((part) => part !== '');
  const numbers: number[] = [];
  let hasLetter = false;
  for (const part of parts) {
    if (kNumber.test(part)) numbers.push(Number(part));
    else if (/^[NSEW]$/i.test(part) && numbers.length > 0) {
      hasLetter = true;
      if (/^[SW]$/i.test(part)) numbers[numbers.length - 1]! *= -1;
    } else return `“${part}” is no number. Write easting, northing or latitude, longitude.`;
  }
  const [first, second] = numbers;
  if (first === undefined || second === undefined || numbers.length > 2) {
    return 'Write two numbers: easting, northing or latitude, longitude.';
  }
  const inside = isInside(first, second, projection);
  const canBeDegrees = Math.abs(first) <= 90 && Math.abs(second) <= 180;
  if (!hasLetter && (inside || !canBeDegrees)) return { easting: first, northing: second };
  if (!canBeDegrees) return 'A latitude is -90 to 90, a longitude -180 to 180.';
  const [easting, northing] = projection.fromLatLon({ latDeg: first, lonDeg: second }) ?? [];
  if (easting === undefined || northing === undefined) {
    return 'Latitude and longitude are not known in this world. Write easting, northing.';
  }
  return { easting, northing };
}

export function isInside(
  easting: number,
  northing: number,
  { extent: [west, south, east, north] }: WorldProjection,
): boolean {
  return easting >= west && easting < east && northing > south && northing <= north;
}

/** Decimals that resolve a tenth of a voxel, 0 to 6. */
export function decimalsFor(unitsPerVoxel: number): number {
  return Math.min(6, Math.max(0, Math.ceil(-Math.log10(unitsPerVoxel) + 1)));
}

export const formatLatLon = ({ latDeg, lonDeg }: LatLon): string =>
  `${latDeg.toFixed(6)}, ${lonDeg.toFixed(6)}`;

/** The place in an address: "#e=462500&n=101500&r=1.5" (r: CRS units in a pixel). */
export function placeToHash(
  easting: number,
  northing: number,
  resolution: number,
  decimals: number,
): string {
  const [e, n] = [easting.toFixed(decimals), northing.toFixed(decimals)];
  return `#e=${e}&n=${n}&r=${Number(resolution.toPrecision(3))}`;
}

export function placeFromHash(
  hash: string,
): (FoundPlace & { readonly resolution: number }) | undefined {
  const fields = new URLSearchParams(hash.replace(/^#/, ''));
  const [easting, northing, resolution] = ['e', 'n', 'r'].map((name) =>
    kNumber.test(fields.get(name) ?? '') ? Number(fields.get(name)) : NaN,
  );
  if (easting === undefined || northing === undefined || resolution === undefined) return undefined;
  if (!Number.isFinite(easting) || !Number.isFinite(northing) || !(resolution > 0)) {
    return undefined;
  }
  return { easting, northing, resolution };
}

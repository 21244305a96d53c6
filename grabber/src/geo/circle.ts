import type { BoundsM } from '../model/square.js';
import type { Point } from './crs.js';
import type { Polygon } from './polygon.js';

/**
 * Metres of a degree of latitude at the equator and of longitude there, on the ellipsoid of WGS 84.
 */
const kMajor_m = 6_378_137;
const kFlattening = 1 / 298.257223563;
const kCorners = 128;

/** Whether the square has ground nearer to the centre than the radius. */
export function circleTouchesSquare(
  centre: Point,
  radius: number,
  [west, south, east, north]: BoundsM,
): boolean {
  const dx = Math.max(west - centre[0], 0, centre[0] - east);
  const dy = Math.max(south - centre[1], 0, centre[1] - north);
  return Math.hypot(dx, dy) < radius;
}

/**
 * A circle on the ground as a polygon in degrees, around the circle rather than in it, so that none
 * of its ground is left out. Good to a thousandth of the radius up to 100 km.
 */
export function circlePolygonDeg(centre: Point, radius_m: number): Polygon {
  const [lon, lat] = centre;
  const { east_m, north_m } = metresPerDegree(lat);
  const reach = radius_m / Math.cos(Math.PI / kCorners);
  const ring: Point[] = [];
  for (let corner = 0; corner <= kCorners; ++corner) {
    const angle = (2 * Math.PI * (corner % kCorners)) / kCorners;
    ring.push([
      lon + (reach * Math.cos(angle)) / east_m,
      lat + (reach * Math.sin(angle)) / north_m,
    ]);
  }
  return [ring];
}

function metresPerDegree(lat: number): { east_m: number; north_m: number } {
  const phi = (lat * Math.PI) / 180;
  const eccentricity2 = kFlattening * (2 - kFlattening);
  const w = 1 - eccentricity2 * Math.sin(phi) ** 2;
  const degree = Math.PI / 180;
  return {
    east_m: (degree * kMajor_m * Math.cos(phi)) / Math.sqrt(w),
    north_m: (degree * kMajor_m * (1 - eccentricity2)) / w ** 1.5,
  };
}

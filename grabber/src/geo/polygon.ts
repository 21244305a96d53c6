import type { BoundsM } from '../model/store.js';
import { measureBounds, overlap } from './bounds.js';
import type { Point } from './crs.js';

/**
 * Closed rings, the first the outer one, the others holes; inside is what an odd number of rings
 * encloses.
 */
export type Polygon = readonly (readonly Point[])[];

type Edge = { readonly from: Point; readonly to: Point };

/**
 * Height of a row of edges: about a square, so that a square needs few rows and an edge of an
 * outline lies in few.
 */
const kRowHeight = 1000;
const kMaxRows = 4096;

/**
 * Whether the open square and the polygon share ground; for many squares PolygonIndex is faster.
 */
export function touchesSquare(polygon: Polygon, square: BoundsM): boolean {
  return new PolygonIndex(polygon).touches(square);
}

/**
 * A polygon with an index, for fast tests of which squares it touches: its edges are sorted into
 * rows from south to north.
 */
export class PolygonIndex {
  readonly bounds: BoundsM;
  readonly #rows: Edge[][] = [];
  readonly #rowHeight: number;

  constructor(polygon: Polygon) {
    this.bounds = measureBounds(polygon.flat());
    this.#rowHeight = Math.max(kRowHeight, (this.bounds[3] - this.bounds[1]) / kMaxRows);
    for (const edge of listEdges(polygon)) {
      const low = this.#rowAt(Math.min(edge.from[1], edge.to[1]));
      const high = this.#rowAt(Math.max(edge.from[1], edge.to[1]));
      for (let row = low; row <= high; ++row) (this.#rows[row] ??= []).push(edge);
    }
  }

  /**
   * Whether the open square and the polygon share ground: common edges and corners are none.
   * Without a tolerance: either an edge of the polygon enters the square, or none does, and then
   * the square is all inside or all outside, as its centre is.
   */
  touches(square: BoundsM): boolean {
    if (!overlap(this.bounds, square)) return false;
    const high = this.#rowAt(Math.min(square[3], this.bounds[3]));
    for (let row = this.#rowAt(Math.max(square[1], this.bounds[1])); row <= high; ++row) {
      if (this.#rows[row]?.some(({ from, to }) => entersBox(from, to, square)) === true) {
        return true;
      }
    }
    return this.contains([(square[0] + square[2]) / 2, (square[1] + square[3]) / 2]);
  }

  /** Whether the polygon contains a point, by the even-odd rule. */
  contains([x, y]: Point): boolean {
    if (y < this.bounds[1] || y > this.bounds[3]) return false;
    let inside = false;
    for (const { from, to } of this.#rows[this.#rowAt(y)] ?? []) {
      if (from[1] > y === to[1] > y) continue;
      // The edge crosses the horizontal line through the point. It counts when it does so east of
      // the point.
      const share = (y - from[1]) / (to[1] - from[1]);
      if (x < from[0] + share * (to[0] - from[0])) inside = !inside;
    }
    return inside;
  }

  /** @param y within the bounds */
  #rowAt(y: number): number {
    return Math.floor((y - this.bounds[1]) / this.#rowHeight);
  }
}

function* listEdges(polygon: Polygon): Generator<Edge> {
  for (const ring of polygon) {
    for (let index = 1; index < ring.length; ++index) {
      const from = ring[index - 1];
      const to = ring[index];
      if (from !== undefined && to !== undefined) yield { from, to };
    }
  }
}

/**
 * Ref: Liang & Barsky, "A New Concept and Method for Line Clipping", ACM Transactions on Graphics
 * 1984.
 */
function entersBox(from: Point, to: Point, [west, south, east, north]: BoundsM): boolean {
  const dx = to[0] - from[0];
  const dy = to[1] - from[1];
  let enter = 0;
  let leave = 1;
  for (const [step, room] of [
    [-dx, from[0] - west],
    [dx, east - from[0]],
    [-dy, from[1] - south],
    [dy, north - from[1]],
  ] as const) {
    if (step === 0) {
      // Along this side: on it or beyond it is outside the open box.
      if (room <= 0) return false;
    } else if (step < 0) {
      enter = Math.max(enter, room / step);
    } else {
      leave = Math.min(leave, room / step);
    }
  }
  return enter < leave;
}

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

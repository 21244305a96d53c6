import type { BoundsM } from '../model/store.js';
import type { Point, Projection } from './crs.js';

/** West, south, east, north in degrees of WGS 84; west < east, so none crosses the date line. */
export type BoundsDeg = readonly [west: number, south: number, east: number, north: number];

export const kEverywhere: BoundsM = [-Infinity, -Infinity, Infinity, Infinity];

/**
 * Share of a box's edge that is added around it after projecting: straight lines bulge between the
 * sampled points.
 */
const kBoxPadding = 0.002;
const kEdgePieces = 20;

/** Whether two boxes share ground; a common edge is none. */
export function overlap(a: BoundsM, b: BoundsM): boolean {
  return a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3];
}

/** @return undefined when they share no ground */
export function intersectBounds(a: BoundsM, b: BoundsM): BoundsM | undefined {
  if (!overlap(a, b)) return undefined;
  const west = Math.max(a[0], b[0]);
  const south = Math.max(a[1], b[1]);
  const east = Math.min(a[2], b[2]);
  const north = Math.min(a[3], b[3]);
  return [west, south, east, north];
}

/** @param points at least one */
export function measureBounds(points: Iterable<Point>): BoundsM {
  let west = Infinity;
  let south = Infinity;
  let east = -Infinity;
  let north = -Infinity;
  for (const [x, y] of points) {
    west = Math.min(west, x);
    south = Math.min(south, y);
    east = Math.max(east, x);
    north = Math.max(north, y);
  }
  return [west, south, east, north];
}

/**
 * The smallest box around all of them.
 * @param boxes at least one
 */
export function uniteBounds(boxes: Iterable<BoundsM>): BoundsM {
  const corners: Point[] = [];
  for (const [west, south, east, north] of boxes) corners.push([west, south], [east, north]);
  return measureBounds(corners);
}

/** A closed ring around the box, counter-clockwise, each edge in `pieces` equal parts. */
export function ringOfBox([west, south, east, north]: BoundsM, pieces = 1): Point[] {
  const corners: Point[] = [
    [west, south],
    [east, south],
    [east, north],
    [west, north],
    [west, south],
  ];
  return withPieces(corners, () => pieces);
}

function between(from: Point, to: Point, share: number): Point {
  return [from[0] + (to[0] - from[0]) * share, from[1] + (to[1] - from[1]) * share];
}

/** How many pieces withShortEdges would make. */
export function countPieces(line: readonly Point[], longest: number): number {
  let pieces = 0;
  line.slice(1).forEach((to, index) => {
    pieces += piecesBetween(line[index] ?? to, to, longest);
  });
  return pieces;
}

function piecesBetween(from: Point, to: Point, longest: number): number {
  return Math.max(1, Math.ceil(Math.hypot(to[0] - from[0], to[1] - from[1]) / longest));
}

/** A closed or open line with points at most `longest` apart. */
export function withShortEdges(line: readonly Point[], longest: number): Point[] {
  return withPieces(line, (from, to) => piecesBetween(from, to, longest));
}

function withPieces(line: readonly Point[], count: (from: Point, to: Point) => number): Point[] {
  const out: Point[] = line[0] === undefined ? [] : [line[0]];
  line.slice(1).forEach((to, index) => {
    const from = line[index] ?? to;
    const pieces = count(from, to);
    for (let piece = 1; piece < pieces; ++piece) out.push(between(from, to, piece / pieces));
    out.push(to);
  });
  return out;
}

/**
 * A box in degrees that encloses the box, a little wider than needed: for queries to catalogues.
 */
export function boundsToDegrees(bounds: BoundsM, projection: Projection): BoundsDeg {
  return padded(
    measureBounds(ringOfBox(bounds, kEdgePieces).map((point) => projection.toDegrees(point))),
  );
}

function padded([west, south, east, north]: BoundsM): BoundsM {
  const x = (east - west) * kBoxPadding;
  const y = (north - south) * kBoxPadding;
  return [west - x, south - y, east + x, north + y];
}

import {
  kEverywhere,
  overlap,
  countPieces,
  ringOfBox,
  uniteBounds,
  withShortEdges,
  type BoundsDeg,
} from '../geo/bounds.js';
import { circlePolygonDeg, circleTouchesSquare } from '../geo/circle.js';
import { findProjection, type Point, type Projection } from '../geo/crs.js';
import { PolygonIndex, type Polygon } from '../geo/polygon.js';
import type { BoundsM } from '../model/square.js';
import type { Region } from '../model/store.js';
import { boundsOfSquare } from '../sources/naming.js';
import type { Square } from '../sources/square.js';
import { usage } from './usage.js';

/** Straight lines in degrees are curves on a map: no piece of an outline is longer, about 500 m. */
const kPiece_deg = 0.005;
const kBoxPieces = 64;
const kMaxPieces = 2_000_000;

/** All squares there are. */
export const kAll: Region = { bounds: kEverywhere, touches: () => true, names: undefined };

/**
 * Exactly these squares.
 * @param squares at least one; bounds are everywhere when they have no corners
 */
export function regionOfSquares(squares: readonly Square[], square_m: number): Region {
  const boxes = squares
    .map((square) => boundsOfSquare(square, square_m))
    .filter((box) => box !== null);
  const names = new Set(squares.map((square) => square.name));
  if (boxes.length === 0) return { ...kAll, names };
  const places = new Set(boxes.map((box) => box.join(' ')));
  return { bounds: uniteBounds(boxes), names, touches: (square) => places.has(square.join(' ')) };
}

export function regionOfBox(box: BoundsM): Region {
  return { bounds: box, names: undefined, touches: (square) => overlap(box, square) };
}

/** @param circle centre and radius in the unit of the CRS */
export function regionOfCircle([east, north, radius]: readonly [number, number, number]): Region {
  return {
    bounds: [east - radius, north - radius, east + radius, north + radius],
    names: undefined,
    touches: (square) => circleTouchesSquare([east, north], radius, square),
  };
}

/**
 * @param polygons in degrees, at least one
 * @param crs `EPSG:n` of the squares
 * @throws GrabberError USAGE for outlines that are too long to follow
 */
export function regionOfPolygons(polygons: readonly Polygon[], crs: string): Region {
  const projection = findProjection(crs);
  const pieces = polygons.flat().reduce((sum, ring) => sum + countPieces(ring, kPiece_deg), 0);
  if (pieces > kMaxPieces) {
    throw usage(
      `read polygons: an outline of ${pieces} pieces of 500 m or less; allowed: at most ` +
        `${kMaxPieces}`,
    );
  }
  const indices = polygons.map(
    (polygon) => new PolygonIndex(polygon.map((ring) => projectRing(ring, projection))),
  );
  return {
    bounds: uniteBounds(indices.map(({ bounds }) => bounds)),
    names: undefined,
    touches: (square) => indices.some((index) => index.touches(square)),
  };
}

function projectRing(ring: readonly Point[], projection: Projection): Point[] {
  return withShortEdges(ring, kPiece_deg).map((point) => projection.fromDegrees(point));
}

export function regionOfBoxDeg(box: BoundsDeg, crs: string): Region {
  return regionOfPolygons([[ringOfBox(box, kBoxPieces)]], crs);
}

/** @param circle longitude, latitude and radius in metres on the ground */
export function regionOfCircleDeg(
  [lon, lat, radius_m]: readonly [number, number, number],
  crs: string,
): Region {
  return regionOfPolygons([circlePolygonDeg([lon, lat], radius_m)], crs);
}

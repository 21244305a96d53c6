import { z } from 'zod';
import {
  overlap,
  kEverywhere,
  countPieces,
  ringOfBox,
  uniteBounds,
  withShortEdges,
  type BoundsDeg,
} from '../geo/bounds.js';
import type { BoundsM, Region } from '../model/store.js';
import { type Square, kMaxSquares, parseSquare, squareAt, type Grid } from '../sources/square.js';
import { findArea, loadAreas } from './areas.js';
import type { SelectionOptions } from './selection.js';
import { usage, GrabberError } from '../util/errors.js';
import {
  circlePolygonDeg,
  circleTouchesSquare,
  PolygonIndex,
  type Polygon,
} from '../geo/polygon.js';
import { findProjection, type Point, type Projection } from '../geo/crs.js';
import { boundsOfSquare } from '../sources/naming.js';
import { readVectorFile, type VectorFeature } from '../geo/vector-file.js';

/** What is known of the squares that are chosen from. */
export type GridInfo = {
  readonly crs: string | null;
  /** null: files have names only. */
  readonly square_m: number | null;
  readonly extent_m: BoundsM | undefined;
};

const kRegionOptions = {
  squares: '--squares',
  bbox: '--bbox',
  bboxDeg: '--bbox-deg',
  circle: '--circle',
  circleDeg: '--circle-deg',
  polygon: '--polygon',
  area: '--area',
} as const;
type RegionOption = keyof typeof kRegionOptions;
export const kRegionOptionNames = Object.values(kRegionOptions).join(', ');

/**
 * The options that choose ground.
 * @throws GrabberError USAGE when there is more than one
 */
export function chosenRegionOption(options: SelectionOptions): RegionOption | undefined {
  const given = (Object.keys(kRegionOptions) as RegionOption[]).filter(
    (option) => options[option] !== undefined,
  );
  if (given.length < 2) return given[0];
  const names = given.map((option) => kRegionOptions[option]).join(' and ');
  throw usage(`choose squares: ${names}; allowed: one of them`);
}

/**
 * @return undefined when no ground was chosen
 * @throws GrabberError USAGE or POLYGON_FILE
 */
export async function chosenRegion(
  options: SelectionOptions,
  gridInfo: GridInfo,
  signal: AbortSignal,
): Promise<Region | undefined> {
  const option = chosenRegionOption(options);
  if (option === undefined) return undefined;
  if (option === 'squares') {
    return regionOfSquares(listSquares(options.squares ?? [], gridInfo), gridInfo.square_m ?? 1000);
  }
  const region = await shapeRegion(option, options, gridInfo, signal);
  // Catches degrees, swapped axes and the wrong country before any request is sent.
  if (gridInfo.extent_m === undefined || overlap(region.bounds, gridInfo.extent_m)) return region;
  const bounds = region.bounds.map(Math.round).join(',');
  const allowed = `${gridInfo.extent_m.join(',')} (west,south,east,north in metres)`;
  throw usage(
    `choose squares: ${kRegionOptions[option]} lies outside the source, at ${bounds}; ` +
      `allowed: ${allowed}`,
  );
}

function listSquares(names: readonly string[], { square_m, extent_m }: GridInfo): Square[] {
  return square_m === null ? names.map(plainSquare) : squaresByName(names, { square_m, extent_m });
}

async function shapeRegion(
  option: Exclude<RegionOption, 'squares'>,
  options: SelectionOptions,
  gridInfo: GridInfo,
  signal: AbortSignal,
): Promise<Region> {
  const { bbox, bboxDeg, circle, circleDeg, polygon, area, areasFolder } = options;
  if (bbox !== undefined) return regionOfBox(bbox);
  if (circle !== undefined) return regionOfCircle(circle);
  if (gridInfo.crs === null) {
    throw usage(
      `choose squares: ${kRegionOptions[option]} without a CRS; allowed: with --source, ` +
        'or with --crs EPSG:<number>',
    );
  }
  if (bboxDeg !== undefined) return regionOfBoxDeg(bboxDeg, gridInfo.crs);
  if (circleDeg !== undefined) return regionOfCircleDeg(circleDeg, gridInfo.crs);
  if (polygon !== undefined) {
    return regionOfPolygons(await readPolygonFile(polygon, signal), gridInfo.crs);
  }
  if (areasFolder === undefined) {
    throw usage('choose area: no folder of areas; allowed: --config with a folder areas');
  }
  return regionOfPolygons(
    [findArea(area ?? '', await loadAreas(areasFolder, signal)).polygon],
    gridInfo.crs,
  );
}

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

const kMaxPoints = 1_000_000;

const ringSchema = z
  .array(z.tuple([z.number().min(-180).max(180), z.number().min(-90).max(90)]).rest(z.unknown()))
  .min(4);
const polygonSchema = z.array(ringSchema).min(1);

/**
 * All polygons of a vector file, in degrees.
 * @throws GrabberError POLYGON_FILE, also for features that are no polygons
 */
export async function readPolygonFile(file: string, signal: AbortSignal): Promise<Polygon[]> {
  const features = await readVectorFile(
    file,
    { crs: 'EPSG:4326', code: 'POLYGON_FILE', what: 'read polygon' },
    signal,
  );
  const polygons = features.flatMap((feature, index) => toPolygons(feature, file, index));
  const points = polygons.flat().reduce((sum, ring) => sum + ring.length, 0);
  if (polygons.length === 0) throw refused(file, 'it holds no features', 'at least one polygon');
  if (points > kMaxPoints) throw refused(file, `${points} points`, `at most ${kMaxPoints}`);
  return polygons;
}

/** @return the coordinates of each polygon; undefined for any other geometry */
function listParts({ geometry }: VectorFeature): unknown[] | undefined {
  if (geometry?.type === 'Polygon') return [geometry.coordinates];
  if (geometry?.type !== 'MultiPolygon' || !Array.isArray(geometry.coordinates)) return undefined;
  return geometry.coordinates as unknown[];
}

function toPolygons(feature: VectorFeature, file: string, index: number): Polygon[] {
  const raw = listParts(feature);
  if (raw === undefined) {
    throw refused(
      file,
      `feature ${index + 1} is ${feature.geometry?.type ?? 'without a geometry'}`,
      'Polygon or MultiPolygon',
    );
  }
  return raw.map((one) => {
    const parsed = polygonSchema.safeParse(one);
    if (!parsed.success) {
      throw refused(
        file,
        `feature ${index + 1} has rings that are none`,
        'rings of at least 4 points in degrees',
      );
    }
    return parsed.data.map((ring) => ring.map(([x, y]): Point => [x, y]));
  });
}

function refused(file: string, found: string, allowed: string): GrabberError {
  return new GrabberError('POLYGON_FILE', `read polygon ${file}: ${found}; allowed: ${allowed}`);
}

/** Becomes a file name in the store. */
const kPlainName = /^[\p{L}\p{N}][\p{L}\p{N} ._()+-]{0,118}(?<! )$/u;

/**
 * Squares of a grid by name, or by the names of two corner squares: `462_101:465_103` is all
 * twelve.
 */
export function squaresByName(names: readonly string[], grid: Grid): Square[] {
  const found = new Map<string, Square>();
  for (const name of names) {
    for (const square of oneOrRange(name, grid)) {
      found.set(square.name, square);
      if (found.size > kMaxSquares) {
        throw usage(
          `read --squares: ${name} makes more than ${kMaxSquares} squares; allowed: at ` +
            `most ${kMaxSquares}`,
        );
      }
    }
  }
  return [...found.values()];
}

function* oneOrRange(text: string, grid: Grid): Generator<Square> {
  const ends = text.split(':');
  if (ends.length > 2) throw usage(`read --squares: "${text}"; allowed: E_N or a range E_N:E_N`);
  const [from, to] = ends.map((name) => parseSquare(name, grid).corner);
  if (from === undefined) return;
  const last = to ?? from;
  if (last.east_m < from.east_m || last.north_m < from.north_m) {
    throw usage(
      `read --squares: "${text}"; allowed: a range from its south-west square to its ` +
        'north-east square',
    );
  }
  for (let north = from.north_m; north <= last.north_m; north += grid.square_m) {
    for (let east = from.east_m; east <= last.east_m; east += grid.square_m) {
      yield squareAt(east, north);
    }
  }
}

/** @return undefined for a name that the store could not give a file */
export function plainSquareOrNone(name: string): Square | undefined {
  return kPlainName.test(name) ? { name, corner: undefined } : undefined;
}

/** A square of which only the name matters. */
export function plainSquare(name: string): Square {
  if (kPlainName.test(name)) return { name, corner: undefined };
  throw usage(
    `read square name: "${name}"; allowed: letters, digits, spaces, and ".", "_", "-", ` +
      '"+", "(" and ")", at most 120, the first a letter or digit',
  );
}

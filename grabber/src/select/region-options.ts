import { overlap } from '../geo/bounds.js';
import type { BoundsM } from '../model/square.js';
import type { Region } from '../model/store.js';
import type { Square } from '../sources/square.js';
import { findArea, loadAreas } from './areas.js';
import { readPolygonFile } from './polygon-file.js';
import { regionOfBox, regionOfBoxDeg, regionOfCircle, regionOfCircleDeg, regionOfPolygons, regionOfSquares } from './region.js';
import type { SelectionOptions } from './selection.js';
import { plainSquare, squaresByName } from './square-names.js';
import { usage } from './usage.js';

/** What is known of the squares that are chosen from. */
export type Ground = {
  readonly crs: string | null;
  /** null: files have names only. */
  readonly square_m: number | null;
  readonly extent_m: BoundsM | undefined;
};

const kWays = {
  squares: '--squares',
  bbox: '--bbox',
  bboxDeg: '--bbox-deg',
  circle: '--circle',
  circleDeg: '--circle-deg',
  polygon: '--polygon',
  area: '--area',
} as const;
type Way = keyof typeof kWays;
export const kWayNames = Object.values(kWays).join(', ');

/** The options that choose ground. @throws GrabberError USAGE when there is more than one */
export function chosenWay(options: SelectionOptions): Way | undefined {
  const given = (Object.keys(kWays) as Way[]).filter((way) => options[way] !== undefined);
  if (given.length < 2) return given[0];
  throw usage(`choose squares: ${given.map((way) => kWays[way]).join(' and ')}; allowed: one of them`);
}

/** @return undefined when no ground was chosen @throws GrabberError USAGE or POLYGON_FILE */
export async function chosenRegion(options: SelectionOptions, ground: Ground, signal: AbortSignal): Promise<Region | undefined> {
  const way = chosenWay(options);
  if (way === undefined) return undefined;
  if (way === 'squares') return regionOfSquares(squaresOf(options.squares ?? [], ground), ground.square_m ?? 1000);
  const region = await shapeRegion(way, options, ground, signal);
  // Catches degrees, swapped axes and the wrong country before any request is sent.
  if (ground.extent_m === undefined || overlap(region.bounds, ground.extent_m)) return region;
  const asked = region.bounds.map(Math.round).join(',');
  const allowed = `${ground.extent_m.join(',')} (west,south,east,north in metres)`;
  throw usage(`choose squares: ${kWays[way]} lies outside the source, at ${asked}; allowed: ${allowed}`);
}

function squaresOf(names: readonly string[], { square_m, extent_m }: Ground): Square[] {
  return square_m === null ? names.map(plainSquare) : squaresByName(names, { square_m, extent_m });
}

async function shapeRegion(way: Exclude<Way, 'squares'>, options: SelectionOptions, ground: Ground, signal: AbortSignal): Promise<Region> {
  const { bbox, bboxDeg, circle, circleDeg, polygon, area, areasFolder } = options;
  if (bbox !== undefined) return regionOfBox(bbox);
  if (circle !== undefined) return regionOfCircle(circle);
  if (ground.crs === null) throw usage(`choose squares: ${kWays[way]} without a CRS; allowed: with --source, or with --crs EPSG:<number>`);
  if (bboxDeg !== undefined) return regionOfBoxDeg(bboxDeg, ground.crs);
  if (circleDeg !== undefined) return regionOfCircleDeg(circleDeg, ground.crs);
  if (polygon !== undefined) return regionOfPolygons(await readPolygonFile(polygon, signal), ground.crs);
  if (areasFolder === undefined) throw usage('choose area: no folder of areas; allowed: --config with a folder areas');
  return regionOfPolygons([findArea(area ?? '', await loadAreas(areasFolder, signal)).polygon], ground.crs);
}

import { overlap } from '../geo/bounds.js';
import type { BoundsM } from '../model/square.js';
import type { Region } from '../model/store.js';
import type { Square } from '../sources/square.js';
import { findArea, loadAreas } from './areas.js';
import { readPolygonFile } from './polygon-file.js';
import {
  regionOfBox,
  regionOfBoxDeg,
  regionOfCircle,
  regionOfCircleDeg,
  regionOfPolygons,
  regionOfSquares,
} from './region.js';
import type { SelectionOptions } from './selection.js';
import { plainSquare, squaresByName } from './square-names.js';
import { usage } from './usage.js';

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

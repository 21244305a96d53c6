import type { Vec3 } from './vec3.js';
import { isFields, toList, toNumber, toText } from './json.js';

/** Analyses that the server makes for clients (docs/formats/http.md: Jobs). */

export type Analysis = {
  readonly kind: string;
  readonly title: string;
  /** Whether it is measured on the surface that is chosen: of others there is one alone. */
  readonly hasSurface: boolean;
  /** Whether it is of the sun, so of some days. */
  readonly hasDays: boolean;
  /** Whether it is of what somebody sees from a place. */
  readonly hasObserver: boolean;
};

/** @param json what the server offers */
export const readAnalyses = (json: unknown): readonly Analysis[] =>
  toList(json)
    .filter(isFields)
    .map((one) => ({
      kind: toText(one['kind']),
      title: toText(one['title']),
      hasSurface: one['surface'] === true,
      hasDays: one['days'] === true,
      hasObserver: one['observers'] === true,
    }));

export type Job = Readonly<ReturnType<typeof parseJob>>;
export const readJob = (json: unknown): Job => parseJob(json);

/** What is asked for, as the form has it. */
export type Wish = {
  readonly analysis: Analysis;
  /** West, south, east, north, CRS units. */
  readonly extent: readonly number[];
  readonly resolutionM: number;
  readonly surface: 'top' | 'ground';
  /** Days as YYYY-MM-DD; equal: one day. */
  readonly from: string;
  readonly to: string;
  /** Hours that the clocks of the result are ahead of UTC; undefined: nobody knows. */
  readonly clockOffsetH: number | undefined;
  /** Easting, northing, and metres above the surface. */
  readonly observer: Vec3 | undefined;
};

/** Height of a person's eyes above the ground. */
export const kEyesM = 1.6;

function parseJob(json: unknown) {
  const all = isFields(json) ? json : {};
  const states = ['waiting', 'running', 'done', 'failed'] as const;
  const state = states.find((one) => one === all['state']);
  const id = toText(all['id']);
  if (state === undefined || !/^[0-9a-f]{32}$/.test(id)) {
    throw new Error('read the job: it has no name or no state');
  }
  return {
    id,
    state,
    progress: Math.min(1, Math.max(0, toNumber(all['progress']))),
    before: toNumber(all['before']),
    message: toText(all['message']),
    hasHoles: all['holes'] === true,
  };
}

/** How the places of a world are written: in its CRS, or in voxels, whose z is to the south. */
export type Places = { readonly isPlaced: boolean; readonly unitsPerVoxel: number };

export function toBody(
  wish: Wish,
  { isPlaced, unitsPerVoxel: u }: Places,
): Record<string, unknown> {
  const [west, south, east, north] = wish.extent as [number, number, number, number];
  const area = isPlaced ? [west, south, east, north] : [west / u, -north / u, east / u, -south / u];
  const { kind, hasSurface, hasDays, hasObserver } = wish.analysis;
  const body: Record<string, unknown> = { kind, area, resolution_m: wish.resolutionM };
  if (hasSurface) body['surface'] = wish.surface;
  if (hasDays) Object.assign(body, toDateFields(wish));
  if (hasObserver && wish.observer) {
    const [e, n, above] = wish.observer;
    body['observers'] = [isPlaced ? [e, n, above] : [e / u, -n / u, above]];
    body['target_m'] = kEyesM;
  }
  return body;
}

/** A period is in steps of half an hour: its directions are gathered anyway. */
const kStepMin = 30;

const toDateFields = ({ from, to }: Wish): Record<string, unknown> =>
  from === to ? { date: from } : { from, to, step_min: kStepMin };

/** A name for the raster that tells it from those of other kinds and days. */
export function makeFileName({ analysis, from, to }: Wish): string {
  const days = from === to ? [from] : [from, to];
  return `${['terravox', analysis.kind, ...(analysis.hasDays ? days : [])].join('-')}.tif`;
}

/** Columns and rows of a raster, about. */
export function countCells(
  extent: readonly number[],
  resolutionM: number,
  metresPerUnit: number,
): [number, number] {
  const [west, south, east, north] = extent as [number, number, number, number];
  const side = (length: number): number =>
    Math.max(1, Math.ceil((length * metresPerUnit) / resolutionM));
  return [side(east - west), side(north - south)];
}

/** A round edge of cells that is not finer than a voxel, with at most so many cells. */
export function resolutionFor(
  extent: readonly number[],
  voxelM: number,
  metresPerUnit: number,
  maxCells: number,
): number {
  for (let edge = voxelM; ; edge *= 2) {
    const [columns, rows] = countCells(extent, edge, metresPerUnit);
    if (columns * rows <= maxCells || edge > 1e5) return edge;
  }
}

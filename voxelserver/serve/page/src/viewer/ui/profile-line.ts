/** Heights along a line of points: where rays go down, and what their hits amount to. */
import type { Block, Vec3 } from '../../vec3.js';
import type { CastRay, Pick } from '../stage.js';
import { flatDistance } from './measures.js';

export type ProfileSample = {
  /** Level-0 voxels, at the top of what is there, or at the bottom of the world. */
  readonly point: Vec3;
  /** Along the line, horizontally, metres. */
  readonly distanceM: number;
  /** undefined: nothing is there, or it has not been read. */
  readonly heightM: number | undefined;
  /** Edge of the voxel, metres. */
  readonly voxelM: number;
};

const kMaxSamples = 512;
const kMinSamples = 2;

/** Places along a line, evenly, at least as dense as voxels where 512 suffice. */
export function placesAlong(
  points: readonly Vec3[],
): readonly { x: number; z: number; t: number }[] {
  const steps = points.slice(1).map((to, i) => flatDistance(points[i]!, to));
  const length = steps.reduce((all, step) => all + step, 0);
  if (points.length < 2 || length === 0) return [];
  const count = Math.min(kMaxSamples, Math.max(kMinSamples, Math.ceil(length) + 1));
  let segment = 0;
  let before = 0;
  return Array.from({ length: count }, (_, i) => {
    const t = (length * i) / (count - 1);
    while (segment + 1 < steps.length && t > before + steps[segment]!) {
      before += steps[segment]!;
      ++segment;
    }
    const [from, to] = [points[segment]!, points[segment + 1]!];
    const share = steps[segment]! > 0 ? Math.min(1, (t - before) / steps[segment]!) : 0;
    return { x: from[0] + share * (to[0] - from[0]), z: from[2] + share * (to[2] - from[2]), t };
  });
}

/** Straight down from above the world. */
export function raysDown(places: readonly { x: number; z: number }[], world: Block): CastRay[] {
  const [low, high] = [world.min[1] - 1, world.max[1] + 1];
  return places.map(({ x, z }) => ({
    origin: [x, high, z],
    direction: [0, -1, 0],
    maxT: high - low,
  }));
}

export function makeSamples(
  places: readonly { x: number; z: number; t: number }[],
  hits: readonly (Pick | undefined)[],
  world: Block & { readonly voxelM: number },
): readonly ProfileSample[] {
  return places.map(({ x, z, t }, i) => {
    const hit = hits[i];
    const y = hit?.point[1] ?? world.min[1];
    return {
      point: [x, y, z],
      distanceM: t * world.voxelM,
      heightM: hit === undefined ? undefined : y * world.voxelM,
      voxelM: 2 ** (hit?.level ?? 0) * world.voxelM,
    };
  });
}

/**
 * The finer of two readings of the same line at each place: columns become coarser when the camera
 * flies away.
 */
export function finest(
  before: readonly ProfileSample[],
  now: readonly ProfileSample[],
): readonly ProfileSample[] {
  if (before.length !== now.length) return now;
  return now.map((sample, i) => {
    const old = before[i]!;
    if (old.heightM === undefined) return sample;
    return sample.heightM === undefined || old.voxelM < sample.voxelM ? old : sample;
  });
}

/** @return undefined when nothing is known along the line */
export const toFacts = (s: readonly ProfileSample[]): ProfileFacts | undefined => computeFacts(s);
export type ProfileFacts = NonNullable<ReturnType<typeof computeFacts>>;

function computeFacts(samples: readonly ProfileSample[]) {
  const known = samples.filter((s) => s.heightM !== undefined);
  if (known.length === 0) return undefined;
  const heights = known.map((s) => s.heightM!);
  const steps = heights.slice(1).map((h, i) => h - heights[i]!);
  return {
    lengthM: samples.at(-1)!.distanceM,
    lowestM: Math.min(...heights),
    highestM: Math.max(...heights),
    ascentM: steps.reduce((all, step) => all + Math.max(0, step), 0),
    descentM: steps.reduce((all, step) => all + Math.max(0, -step), 0),
    coarsestVoxelM: Math.max(...known.map((s) => s.voxelM)),
  };
}

/** Heights that are not known stay empty. @param unitsPerVoxel of the CRS */
export function toCsv(
  samples: readonly ProfileSample[],
  { unitsPerVoxel }: { readonly unitsPerVoxel: number },
): string {
  const rows = samples.map(({ point, distanceM, heightM, voxelM }) =>
    [
      (point[0] * unitsPerVoxel).toFixed(3),
      (-point[2] * unitsPerVoxel).toFixed(3),
      distanceM.toFixed(3),
      heightM === undefined ? '' : heightM.toFixed(3),
      heightM === undefined ? '' : String(Number(voxelM.toPrecision(6))),
    ].join(','),
  );
  return ['easting,northing,distance_m,height_m,level_m', ...rows, ''].join('\r\n');
}

/** Round values that cover a range: at most `count` steps of 1, 2 or 5 times a power of ten. */
export function chooseTicks(from: number, to: number, count: number): readonly number[] {
  const rough = (to - from) / count;
  if (!(rough > 0) || !Number.isFinite(rough)) return [from];
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((by) => by * power >= rough * (1 - 1e-9))!;
  const [first, last] = [Math.ceil(from / step - 1e-9), Math.floor(to / step + 1e-9)];
  // From whole numbers, so that no error adds up; 1e-12 apart is the same text.
  return Array.from({ length: last - first + 1 }, (_, i) =>
    Number(((first + i) * step).toPrecision(12)),
  );
}

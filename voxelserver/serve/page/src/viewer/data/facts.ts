import { isFields, type Fields } from '../../json.js';
import type { Block } from '../../vec3.js';
import { readWorld, type World } from '../../replies.js';
import { kBoxSize, kMaxLevel } from './box-arrays.js';
import { DataError, oneLine } from '../../http/errors.js';

/**
 * Facts about a world: the JSON of `GET /v2/world` (docs/formats/http.md), which archives hold too.
 * Checked as in common/voxel/world_json.cpp and common/voxel/archive/archive_world.cpp.
 */

export type Facts = {
  readonly world: World;
  /** Number of damaged places in the data that an archive was made from; 0 for servers. */
  readonly damage: number;
};

/** Of the text of facts, bytes. */
export const kMaxFactsBytes = 4 * 1024 * 1024;
/** Boxes of a column: more do not fit into memory, and no known world has them. */
export const kMaxColumnBoxes = 4096;

const kWorldVersion = 2;
const kFarthest = 2 ** 30;
const kMaxVoxelM = 1000;
const kMaxOnEdge = 16_384;
const kMaxCoarsestBoxes = 4_194_304;
const kMaxBoxesFromOrigin = 2 ** 20;
const kTexts = ['title', 'crs', 'crs_wkt', 'licence', 'attribution'] as const;

/**
 * @param text JSON in UTF-8
 * @param name of the archive or server, for messages
 * @throws DataError `damaged` for text that is not the facts of a world of version 2, `too-large`
 * for worlds with columns of more than 4096 boxes
 */
export function readFacts(text: Uint8Array, name: string): World {
  const fail = (what: string, cause?: unknown): DataError =>
    new DataError('damaged', `read the world of ${name}: ${what}`, { cause });
  let json: unknown;
  let world: World;
  try {
    json = JSON.parse(new TextDecoder('utf-8', { fatal: true }).decode(text));
    world = readWorld(json);
  } catch (error) {
    throw fail(oneLine(error instanceof Error ? error.message : String(error)), error);
  }
  const problem = isFields(json) ? findProblem(json, world) : 'not a JSON object';
  if (problem !== undefined) throw fail(problem);
  const high = columnHeight({ world }, 0);
  if (high > kMaxColumnBoxes) {
    throw new DataError(
      'too-large',
      `read the world of ${name}: ${high} boxes high; the viewer can show ${kMaxColumnBoxes}`,
    );
  }
  return world;
}

// What readWorld() leaves open, as the map of the voxel server does not depend on it.
function findProblem(json: Fields, world: World): string | undefined {
  if (json['version'] !== kWorldVersion) return `another version; allowed: ${kWorldVersion}`;
  const box: readonly unknown[] = Array.isArray(json['box']) ? json['box'] : [];
  if (box.length !== kBoxSize.length || kBoxSize.some((edge, axis) => box[axis] !== edge)) {
    return 'boxes of another size than 64 x 256 x 64';
  }
  const missing = kTexts.find((name) => typeof json[name] !== 'string');
  if (missing !== undefined) return `${missing} is not a text`;
  for (const name of ['framed', 'typical_heights', 'centre']) {
    if (name in json && !isFields(json[name])) return `${name} is not an object`;
  }
  for (const { min, max } of [world, world.framed]) {
    if (!isSound(min, max)) return 'bounds beyond 2^30 voxels, not whole, or upside down';
  }
  if (world.voxelM > kMaxVoxelM) {
    return `voxel_m = ${world.voxelM}; allowed: above 0, up to ${kMaxVoxelM}`;
  }
  if (!Number.isInteger(world.levels) || world.levels > kMaxLevel + 1) {
    return `levels = ${world.levels}; allowed: 1 to ${kMaxLevel + 1}`;
  }
  return problemOfSize(world);
}

function isSound(min: readonly number[], max: readonly number[]): boolean {
  return min.every((low, axis) => {
    const high = max[axis]!;
    const isWhole = Number.isInteger(low) && Number.isInteger(high);
    return isWhole && low >= -kFarthest && high <= kFarthest && low <= high;
  });
}

// Limits the boxes of the coarsest level, which is the largest cost of a picture of air.
function problemOfSize(world: World): string | undefined {
  if (isEmpty(world)) return undefined;
  const { min, max } = boxRange(world, world.levels - 1);
  const edges = max.map((end, axis) => end - min[axis]!);
  const all = edges.reduce((product, edge) => product * edge, 1);
  if (Math.max(...edges) <= kMaxOnEdge && all <= kMaxCoarsestBoxes) return undefined;
  return (
    `levels = ${world.levels} for bounds of ${edges.join(' x ')} boxes of the coarsest level; ` +
    `allowed: up to ${kMaxOnEdge} on an edge, ${kMaxCoarsestBoxes} in all`
  );
}

/**
 * What archives promise beyond readFacts(): bounds within 2^20 boxes of the origin, and as many
 * levels as it takes until one box is as wide as the bounds.
 * @throws DataError `damaged`
 */
export function checkArchiveBounds(world: World, name: string): void {
  if (isEmpty(world)) return;
  const fail = (what: string): DataError =>
    new DataError('damaged', `open the box archive ${name}: ${what}`);
  const { min, max } = boxRange(world, 0);
  const low = Math.min(...min);
  const high = Math.max(...max);
  if (low < -kMaxBoxesFromOrigin || high > kMaxBoxesFromOrigin) {
    throw fail('its bounds reach beyond 2^20 boxes from the origin');
  }
  const needed = levelsFor(world);
  if (world.levels < needed) {
    throw fail(`levels = ${world.levels}; bounds of this width need at least ${needed}`);
  }
}

// The coarsest level is the first that is at most one box across; 20 are enough.
function levelsFor(world: World): number {
  const widest = Math.max(world.max[0] - world.min[0], world.max[2] - world.min[2]);
  let levels = 1;
  while (levels < kMaxLevel && kBoxSize[0] * 2 ** (levels - 1) < widest) levels += 1;
  return levels;
}

/** Whether the world has no voxels at all. */
export function isEmpty(world: World): boolean {
  return world.min.some((low, axis) => low >= world.max[axis]!);
}

/** Boxes of a level that cover the bounds, as [bx, by, bz]. @param world not isEmpty() */
export function boxRange(world: World, level: number): Block {
  const size = kBoxSize.map((edge) => edge * 2 ** level);
  const low = (axis: 0 | 1 | 2): number => Math.floor(world.min[axis] / size[axis]!);
  const high = (axis: 0 | 1 | 2): number => Math.floor((world.max[axis] - 1) / size[axis]!) + 1;
  return { min: [low(0), low(1), low(2)], max: [high(0), high(1), high(2)] };
}

export function hasLevel({ world }: Facts, level: number): boolean {
  return Number.isInteger(level) && level >= 0 && level < world.levels;
}

/** Boxes of a column of an existing level, from the bottom to the top of the bounds. */
export function columnHeight({ world }: { readonly world: World }, level: number): number {
  if (isEmpty(world)) return 0;
  const { min, max } = boxRange(world, level);
  return max[1] - min[1];
}

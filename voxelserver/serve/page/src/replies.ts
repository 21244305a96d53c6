import {
  isFields,
  JsonReader,
  toList,
  toNumber,
  toNumbers,
  toText,
  type Fields,
  type Numbers,
} from './json.js';
import { readAnalyses } from './jobs.js';
import type { Block, Vec3 } from './vec3.js';

/**
 * Replies of the server, checked and typed. Readers accept any JSON and throw an Error that names
 * the field.
 */

const kCache = ['hits', 'misses', 'evictions', 'bytes', 'entries', 'limitBytes'] as const;
const kMaking = ['running', 'waiting', 'aheadWaiting', 'made', 'madeAhead', 'failed'] as const;
const kMemory = ['rssBytes', 'limitBytes'] as const;
const kJobs = ['maxCells', 'maxMinutes'] as const;
const kPrepare = ['done', 'total', 'failed'] as const;

export type CacheStats = Numbers<(typeof kCache)[number]>;
const kFar = 2 ** 31;

const read = new JsonReader((what) => {
  throw new Error(`read the world: ${what}`);
});

function parseFields(value: unknown, what: string): Fields {
  if (!isFields(value)) throw new Error(`read ${what}: not a JSON object`);
  return value;
}

// More numbers are ignored, fewer are named.
const parseVec3 = (value: unknown, what: string): Vec3 => {
  const [x, y, z] = toList(value);
  return read.vec3([x, y, z], what, kFar);
};

/** A place of a map: where it is on Earth, and how the map is turned there. */
export type MapPlace = Readonly<ReturnType<typeof readPlace>>;

function readPlace(centre: Fields) {
  const turn = centre['convergence_deg'];
  return {
    latDeg: read.number(centre['lat_deg'], 'centre.lat_deg', -90, 90),
    lonDeg: read.number(centre['lon_deg'], 'centre.lon_deg', -360, 360),
    /** The azimuth of the map's north, clockwise from true north; not in what older ones wrote. */
    convergenceDeg: read.number(turn ?? 0, 'centre.convergence_deg', -360, 360),
  };
}

/** @return the block itself where nothing of it lies at these heights */
function atHeights(block: Block, heights: Fields | undefined): Block {
  if (heights === undefined) return block;
  const [west, bottom, north] = block.min;
  const [east, top, south] = block.max;
  const low = Math.max(bottom, read.number(heights['min'], 'typical_heights.min', -kFar, kFar));
  const high = Math.min(top, read.number(heights['max'], 'typical_heights.max', -kFar, kFar));
  return low < high ? { min: [west, low, north], max: [east, high, south] } : block;
}

export type World = Readonly<ReturnType<typeof parseWorld>>;
/** @throws Error that names the field */
export const readWorld = (json: unknown): World => parseWorld(json);

function parseWorld(json: unknown) {
  const all = parseFields(json, 'the world');
  const bounds = parseFields(all['bounds'], 'the bounds of the world');
  const framed = isFields(all['framed']) ? all['framed'] : bounds;
  const heights = isFields(all['typical_heights']) ? all['typical_heights'] : undefined;
  const map = isFields(all['map']) ? all['map'] : undefined;
  const zooms = toList(map?.['zooms']);
  const centre = isFields(all['centre']) ? all['centre'] : undefined;
  return {
    title: toText(all['title']),
    software: toText(all['software']),
    /** Half-open, voxels of level 0; x east, y up, z south. */
    min: parseVec3(bounds['min'], 'bounds.min'),
    max: parseVec3(bounds['max'], 'bounds.max'),
    /**
     * What to show first: of worlds without end less than all, and of surveys without what flies
     * far above.
     */
    framed: atHeights(
      { min: parseVec3(framed['min'], 'framed.min'), max: parseVec3(framed['max'], 'framed.max') },
      heights,
    ),
    voxelM: read.number(all['voxel_m'], 'voxel_m', 1e-6, 1e6),
    levels: read.number(all['levels'], 'levels', 1, 32),
    crs: toText(all['crs']),
    crsWkt: toText(all['crs_wkt']),
    crsProj4: toText(all['crs_proj4']),
    unitsPerVoxel: read.number(all['crs_units_per_voxel'], 'crs_units_per_voxel', 1e-9, 1e9),
    centre: centre && readPlace(centre),
    licence: toText(all['licence']),
    attribution: toText(all['attribution']),
    materials: toList(all['materials']).map(toText),
    tilePx: map ? read.number(map['tile_px'], 'map.tile_px', 1, 4096) : 256,
    /** Of the top view; -1 when the server draws none. */
    finestZoom: map ? read.number(zooms[1], 'map.zooms', 0, 32) : -1,
  };
}

function sumOfRequests(value: unknown): number {
  if (!isFields(value)) return 0;
  let sum = 0;
  for (const byStatus of Object.values(value)) {
    if (isFields(byStatus)) for (const times of Object.values(byStatus)) sum += toNumber(times);
  }
  return sum;
}

/** A step of making boxes: the time of all its runs, and how many they are. */
export type Stage = Readonly<ReturnType<typeof readStage>>;

function readStage({ name, seconds, count }: Fields) {
  return { name: toText(name), seconds: toNumber(seconds), count: toNumber(count) };
}

function readJobLimits(value: unknown) {
  const limits = toNumbers(value, kJobs);
  return limits && { ...limits, analyses: readAnalyses((value as Fields)['analyses']) };
}

export type Stats = Readonly<ReturnType<typeof parseStats>>;
export const readStats = (json: unknown): Stats => parseStats(json);

function parseStats(json: unknown) {
  const all = parseFields(json, 'the statistics');
  const stages = toList(all['stages']).filter(isFields);
  const { replies } = all;
  return {
    version: toText(all['version']),
    uptimeS: toNumber(all['uptime_s']),
    stages: stages.map(readStage),
    /** All that were answered so far. */
    requests: sumOfRequests(all['requests']),
    replyBytes: isFields(replies) ? toNumber(replies['bytes']) : undefined,
    cache: toNumbers(all['cache'], kCache),
    disk: toNumbers(all['disk'], kCache),
    making: toNumbers(all['making'], kMaking),
    memory: toNumbers(all['memory'], kMemory),
    /** Analyses and their limits; undefined: the server makes none. */
    jobs: readJobLimits(all['jobs']),
    prepare: toNumbers(all['prepare'], kPrepare),
  };
}

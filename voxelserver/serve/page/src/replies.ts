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
import type { Block, Vec3 } from './vec3.js';

/**
 * Replies of the server, checked and typed. Readers accept any JSON and throw an Error that names
 * the field.
 */

/** A place of a map: where it is on Earth, and how the map is turned there. */
export type MapPlace = {
  readonly latDeg: number;
  readonly lonDeg: number;
  /** The azimuth of the map's north, clockwise from true north. */
  readonly convergenceDeg: number;
};

export type World = {
  readonly title: string;
  readonly software: string;
  /** Half-open, voxels of level 0; x east, y up, z south. */
  readonly min: Vec3;
  readonly max: Vec3;
  /**
   * What to show first, as min and max: of worlds without end less than all, and of surveys without
   * what flies far above.
   */
  readonly framed: Block;
  readonly voxelM: number;
  readonly levels: number;
  readonly crs: string;
  readonly crsWkt: string;
  readonly crsProj4: string;
  readonly unitsPerVoxel: number;
  readonly centre: MapPlace | undefined;
  readonly licence: string;
  readonly attribution: string;
  readonly materials: readonly string[];
  readonly tilePx: number;
  /** Finest zoom of the top view; -1 when the server draws none. */
  readonly finestZoom: number;
};

export type Stage = { readonly name: string; readonly seconds: number; readonly count: number };

const kCache = {
  hits: 'hits',
  misses: 'misses',
  evictions: 'evictions',
  bytes: 'bytes',
  entries: 'entries',
  limitBytes: 'limit_bytes',
} as const;
const kMaking = {
  running: 'running',
  waiting: 'waiting',
  aheadWaiting: 'ahead_waiting',
  made: 'made',
  madeAhead: 'made_ahead',
  failed: 'failed',
} as const;
const kMemory = { rssBytes: 'rss_bytes', limitBytes: 'limit_bytes' } as const;
const kJobs = { maxCells: 'max_cells', maxMinutes: 'max_minutes' } as const;
const kPrepare = { done: 'done', total: 'total', failed: 'failed' } as const;

export type CacheStats = Numbers<typeof kCache>;
export type Stats = {
  readonly version: string;
  readonly uptimeS: number;
  readonly stages: readonly Stage[];
  /** All requests answered so far. */
  readonly requests: number;
  readonly replyBytes: number | undefined;
  readonly cache: CacheStats | undefined;
  readonly disk: CacheStats | undefined;
  readonly making: Numbers<typeof kMaking> | undefined;
  readonly memory: Numbers<typeof kMemory> | undefined;
  /** Limits of analyses; undefined: the server makes none. */
  readonly jobs: Numbers<typeof kJobs> | undefined;
  readonly prepare: Numbers<typeof kPrepare> | undefined;
};

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

function readPlace(centre: Fields): MapPlace {
  return {
    latDeg: read.number(centre['lat_deg'], 'centre.lat_deg', -90, 90),
    lonDeg: read.number(centre['lon_deg'], 'centre.lon_deg', -360, 360),
    // Older programs did not write it.
    convergenceDeg: read.number(
      centre['convergence_deg'] ?? 0,
      'centre.convergence_deg',
      -360,
      360,
    ),
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

export function readWorld(json: unknown): World {
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
    min: parseVec3(bounds['min'], 'bounds.min'),
    max: parseVec3(bounds['max'], 'bounds.max'),
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

export function readStats(json: unknown): Stats {
  const all = parseFields(json, 'the statistics');
  const stages = toList(all['stages']).filter(isFields);
  const { replies } = all;
  return {
    version: toText(all['version']),
    uptimeS: toNumber(all['uptime_s']),
    stages: stages.map((s) => ({
      name: toText(s['name']),
      seconds: toNumber(s['seconds']),
      count: toNumber(s['count']),
    })),
    requests: sumOfRequests(all['requests']),
    replyBytes: isFields(replies) ? toNumber(replies['bytes']) : undefined,
    cache: toNumbers(all['cache'], kCache),
    disk: toNumbers(all['disk'], kCache),
    making: toNumbers(all['making'], kMaking),
    memory: toNumbers(all['memory'], kMemory),
    jobs: toNumbers(all['jobs'], kJobs),
    prepare: toNumbers(all['prepare'], kPrepare),
  };
}

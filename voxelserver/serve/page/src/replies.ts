/**
 * Replies of the server, checked and typed. Readers accept any JSON and throw an Error that names
 * the field.
 */

export type Vec3 = readonly [number, number, number];

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
  /** What to show first, as min and max: of worlds without end less than all, and of surveys without what flies far above. */
  readonly framed: { readonly min: Vec3; readonly max: Vec3 };
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
export type CacheStats = {
  readonly hits: number;
  readonly misses: number;
  readonly evictions: number;
  readonly bytes: number;
  readonly entries: number;
  readonly limitBytes: number;
};
export type Stats = {
  readonly version: string;
  readonly uptimeS: number;
  readonly stages: readonly Stage[];
  /** All requests answered so far. */
  readonly requests: number;
  readonly replyBytes: number | undefined;
  readonly cache: CacheStats | undefined;
  readonly disk: CacheStats | undefined;
  readonly making:
    | {
        readonly running: number;
        readonly waiting: number;
        readonly aheadWaiting: number;
        readonly made: number;
        readonly madeAhead: number;
        readonly failed: number;
      }
    | undefined;
  readonly memory: { readonly rssBytes: number; readonly limitBytes: number } | undefined;
  /** Limits of analyses; undefined: the server makes none. */
  readonly jobs: { readonly maxCells: number; readonly maxMinutes: number } | undefined;
  readonly prepare:
    { readonly done: number; readonly total: number; readonly failed: number } | undefined;
};

type Fields = Readonly<Record<string, unknown>>;

export const isFields = (value: unknown): value is Fields =>
  typeof value === 'object' && value !== null && !Array.isArray(value);

function fields(value: unknown, what: string): Fields {
  if (!isFields(value)) throw new Error(`read ${what}: not a JSON object`);
  return value;
}

export const parseText = (value: unknown): string => (typeof value === 'string' ? value : '');
const count = (value: unknown): number =>
  typeof value === 'number' && Number.isFinite(value) ? value : 0;
const texts = (value: unknown): string[] => (Array.isArray(value) ? value.map(parseText) : []);

function number(value: unknown, what: string, min: number, max: number): number {
  if (typeof value === 'number' && value >= min && value <= max) return value;
  throw new Error(`read the world: ${what} = ${String(value)}; allowed: ${min} to ${max}`);
}

function vec3(value: unknown, what: string): Vec3 {
  const [x, y, z] = Array.isArray(value) ? (value as unknown[]) : [];
  const far = 2 ** 31;
  return [number(x, what, -far, far), number(y, what, -far, far), number(z, what, -far, far)];
}

function readPlace(centre: Readonly<Record<string, unknown>>): MapPlace {
  return {
    latDeg: number(centre['lat_deg'], 'centre.lat_deg', -90, 90),
    lonDeg: number(centre['lon_deg'], 'centre.lon_deg', -360, 360),
    // Older programs did not write it.
    convergenceDeg: number(centre['convergence_deg'] ?? 0, 'centre.convergence_deg', -360, 360),
  };
}

/** @return the block itself where nothing of it lies at these heights */
function atHeights(block: World['framed'], heights: Fields | undefined): World['framed'] {
  if (heights === undefined) return block;
  const far = 2 ** 31;
  const [west, bottom, north] = block.min;
  const [east, top, south] = block.max;
  const low = Math.max(bottom, number(heights['min'], 'typical_heights.min', -far, far));
  const high = Math.min(top, number(heights['max'], 'typical_heights.max', -far, far));
  return low < high ? { min: [west, low, north], max: [east, high, south] } : block;
}

export function readWorld(json: unknown): World {
  const all = fields(json, 'the world');
  const bounds = fields(all['bounds'], 'the bounds of the world');
  const framed = isFields(all['framed']) ? all['framed'] : bounds;
  const heights = isFields(all['typical_heights']) ? all['typical_heights'] : undefined;
  const map = isFields(all['map']) ? all['map'] : undefined;
  const zooms = map && Array.isArray(map['zooms']) ? (map['zooms'] as unknown[]) : [];
  const centre = isFields(all['centre']) ? all['centre'] : undefined;
  return {
    title: parseText(all['title']),
    software: parseText(all['software']),
    min: vec3(bounds['min'], 'bounds.min'),
    max: vec3(bounds['max'], 'bounds.max'),
    framed: atHeights(
      { min: vec3(framed['min'], 'framed.min'), max: vec3(framed['max'], 'framed.max') },
      heights,
    ),
    voxelM: number(all['voxel_m'], 'voxel_m', 1e-6, 1e6),
    levels: number(all['levels'], 'levels', 1, 32),
    crs: parseText(all['crs']),
    crsWkt: parseText(all['crs_wkt']),
    crsProj4: parseText(all['crs_proj4']),
    unitsPerVoxel: number(all['crs_units_per_voxel'], 'crs_units_per_voxel', 1e-9, 1e9),
    centre: centre && readPlace(centre),
    licence: parseText(all['licence']),
    attribution: parseText(all['attribution']),
    materials: texts(all['materials']),
    tilePx: map ? number(map['tile_px'], 'map.tile_px', 1, 4096) : 256,
    finestZoom: map ? number(zooms[1], 'map.zooms', 0, 32) : -1,
  };
}

function cacheStats(value: unknown): CacheStats | undefined {
  if (!isFields(value)) return undefined;
  return {
    hits: count(value['hits']),
    misses: count(value['misses']),
    evictions: count(value['evictions']),
    bytes: count(value['bytes']),
    entries: count(value['entries']),
    limitBytes: count(value['limit_bytes']),
  };
}

function sumOfRequests(value: unknown): number {
  if (!isFields(value)) return 0;
  let sum = 0;
  for (const byStatus of Object.values(value)) {
    if (isFields(byStatus)) for (const times of Object.values(byStatus)) sum += count(times);
  }
  return sum;
}

export function readStats(json: unknown): Stats {
  const all = fields(json, 'the statistics');
  const stages = Array.isArray(all['stages']) ? (all['stages'] as unknown[]).filter(isFields) : [];
  const { jobs, making, memory, prepare, replies } = all;
  return {
    version: parseText(all['version']),
    uptimeS: count(all['uptime_s']),
    stages: stages.map((s) => ({
      name: parseText(s['name']),
      seconds: count(s['seconds']),
      count: count(s['count']),
    })),
    requests: sumOfRequests(all['requests']),
    replyBytes: isFields(replies) ? count(replies['bytes']) : undefined,
    cache: cacheStats(all['cache']),
    disk: cacheStats(all['disk']),
    making: isFields(making)
      ? {
          running: count(making['running']),
          waiting: count(making['waiting']),
          aheadWaiting: count(making['ahead_waiting']),
          made: count(making['made']),
          madeAhead: count(making['made_ahead']),
          failed: count(making['failed']),
        }
      : undefined,
    memory: isFields(memory)
      ? { rssBytes: count(memory['rss_bytes']), limitBytes: count(memory['limit_bytes']) }
      : undefined,
    jobs: isFields(jobs)
      ? { maxCells: count(jobs['max_cells']), maxMinutes: count(jobs['max_minutes']) }
      : undefined,
    prepare: isFields(prepare)
      ? {
          done: count(prepare['done']),
          total: count(prepare['total']),
          failed: count(prepare['failed']),
        }
      : undefined,
  };
}

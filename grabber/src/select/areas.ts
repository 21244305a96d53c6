import { z } from 'zod';
import { loadConfigFolder, type ConfigKind } from '../config/toml-file.js';
import { measureBounds, ringOfBox } from '../geo/bounds.js';
import { circlePolygonDeg, type Polygon } from '../geo/polygon.js';
import type { Point } from '../geo/crs.js';
import { usage } from '../util/errors.js';

const kAllowed = {
  id: 'lower-case letters, digits and "-", at most 40, the same as the file name',
  title: 'text of 1 to 200 characters',
  aliases: 'a list of other names',
  circle: 'a table with lon, lat (degrees) and radius_m (100 to 100000)',
  polygon: 'a list of at least three [longitude, latitude]',
  bbox: '[west, south, east, north] in degrees with west < east and south < north',
} as const;

const lon = z.number().min(-180).max(180);
const lat = z.number().min(-85).max(85);

const areaSchema = z
  .strictObject({
    id: z.string().regex(/^[a-z0-9][a-z0-9-]{0,39}$/),
    title: z.string().min(1).max(200),
    aliases: z.array(z.string().min(1).max(100)).default([]),
    circle: z.strictObject({ lon, lat, radius_m: z.number().min(100).max(100_000) }).optional(),
    polygon: z
      .array(z.tuple([lon, lat]))
      .min(3)
      .max(10_000)
      .optional(),
    bbox: z
      .tuple([lon, lat, lon, lat])
      .refine(([west, south, east, north]) => west < east && south < north)
      .optional(),
  })
  .refine(
    ({ circle, polygon, bbox }) =>
      [circle, polygon, bbox].filter((shape) => shape !== undefined).length === 1,
    {
      message: 'not exactly one of circle, polygon and bbox',
      path: ['circle'],
    },
  );

type AreaFile = z.infer<typeof areaSchema>;
const kKind: ConfigKind<AreaFile> = { what: 'area', schema: areaSchema, allowed: kAllowed };

/** A named range of ground of the configuration, with all its names. */
export type NamedArea = {
  readonly name: string;
  readonly title: string;
  readonly aliases: readonly string[];
  /** Degrees of WGS 84. */
  readonly polygon: Polygon;
};

const kNearest = 3;

/** Areas of `config/areas`, sorted by name. */
export async function loadAreas(
  folder: string,
  signal: AbortSignal,
): Promise<readonly NamedArea[]> {
  const files = await loadConfigFolder(folder, kKind, signal);
  return [...files.values()].map((file) => ({
    name: file.id,
    title: file.title,
    aliases: file.aliases,
    polygon: toPolygon(file),
  }));
}

function toPolygon(file: AreaFile): Polygon {
  if (file.circle !== undefined) {
    return circlePolygonDeg([file.circle.lon, file.circle.lat], file.circle.radius_m);
  }
  if (file.bbox !== undefined) return [ringOfBox(file.bbox)];
  const points: Point[] = file.polygon ?? [];
  return [[...points, ...points.slice(0, 1)]];
}

/**
 * Capitals, accents, blanks and hyphens do not matter.
 * @throws GrabberError USAGE with the nearest names
 */
export function findArea(name: string, areas: readonly NamedArea[]): NamedArea {
  const wanted = folded(name);
  const found = areas.find((area) => listNames(area).some((other) => folded(other) === wanted));
  if (found !== undefined) return found;
  const near = nearest(wanted, areas);
  const hint =
    near.length === 0
      ? `${areas.length} areas that "areas" lists`
      : `did you mean ${near.join(', ')}? ("areas" lists all ${areas.length})`;
  throw usage(`choose area: "${name}"; allowed: ${hint}`);
}

function listNames(area: NamedArea): string[] {
  return [area.name, ...area.aliases];
}

/** Letters and digits only, without accents: "Škofja Loka" and "skofja-loka" are one name. */
export function folded(text: string): string {
  return text
    .normalize('NFKD')
    .replace(/\p{M}/gu, '')
    .toLowerCase()
    .replace(/ß/g, 'ss')
    .replace(/đ/g, 'd')
    .replace(/ł/g, 'l')
    .replace(/ø/g, 'o')
    .replace(/[^\p{L}\p{N}]+/gu, '');
}

function nearest(wanted: string, areas: readonly NamedArea[]): string[] {
  return areas
    .map((area) => ({
      name: area.name,
      distance: Math.min(...listNames(area).map((other) => editDistance(wanted, folded(other)))),
    }))
    .filter(({ name, distance }) => distance <= Math.max(1, Math.floor(name.length / 3)))
    .sort((a, b) => a.distance - b.distance || (a.name < b.name ? -1 : 1))
    .slice(0, kNearest)
    .map(({ name }) => name);
}

/**
 * Letters to add, leave out or change. Ref: Wagner & Fischer, "The String-to-String Correction
 * Problem", 1974.
 */
export function editDistance(a: string, b: string): number {
  let row = Array.from({ length: b.length + 1 }, (_unused, column) => column);
  for (let i = 1; i <= a.length; ++i) {
    const next = [i];
    for (let j = 1; j <= b.length; ++j) {
      const change = (row[j - 1] ?? 0) + (a[i - 1] === b[j - 1] ? 0 : 1);
      next.push(Math.min(change, (row[j] ?? 0) + 1, (next[j - 1] ?? 0) + 1));
    }
    row = next;
  }
  return row[b.length] ?? 0;
}

/** Middle and size of an area's box, for lists. */
export function measureExtent(area: NamedArea): {
  readonly lon: number;
  readonly lat: number;
  readonly width_m: number;
  readonly height_m: number;
} {
  const [west, south, east, north] = measureBounds(area.polygon.flat());
  const lat = (south + north) / 2;
  const perDegree_m = 111_195;
  return {
    lon: (west + east) / 2,
    lat,
    width_m: (east - west) * perDegree_m * Math.cos((lat * Math.PI) / 180),
    height_m: (north - south) * perDegree_m,
  };
}

import { z } from 'zod';
import { measureBounds } from '../../geo/bounds.js';
import type { Point } from '../../geo/crs.js';
import type { BoundsM } from '../../model/square.js';
import type { WfsAccess } from '../access-schema.js';
import { patternReader } from '../naming.js';
import type { Square } from '../square.js';
import { catalogueError } from './listing.js';

const geometrySchema = z.looseObject({ type: z.string(), coordinates: z.unknown() });
const featureSchema = z.looseObject({
  id: z.union([z.string(), z.number()]).optional(),
  geometry: geometrySchema.nullish(),
  properties: z.record(z.string(), z.unknown()).nullable(),
});
export const collectionSchema = z.looseObject({
  features: z.array(featureSchema),
  numberMatched: z.union([z.number(), z.string()]).optional(),
  crs: z.unknown().optional(),
});
export type WfsFeature = z.infer<typeof featureSchema>;
export type WfsCollection = z.infer<typeof collectionSchema>;

/** What a feature says of its square; `url` null where addresses follow a rule. */
export type ReadFeature = {
  readonly square: Square;
  readonly block: string | null;
  readonly url: string | null;
  readonly rank: string;
  readonly published: string | null;
};

/**
 * @param size edge of a square
 * @throws GrabberError CATALOGUE
 */
export function readFeature(
  feature: WfsFeature,
  access: WfsAccess,
  size: number,
  what: string,
): ReadFeature {
  const text = (field: string | undefined): string | undefined => parseText(feature, field);
  const name = text(access.name_field);
  if (name === undefined) {
    throw catalogueError(
      what,
      `feature ${feature.id ?? '?'} has no field ${access.name_field}`,
      'its name',
    );
  }
  const square = patternReader(access.name_pattern ?? '', access.name_corner, size)(name);
  if (square === undefined) {
    throw catalogueError(
      what,
      `the name ${name} does not give a square`,
      `names with ${access.name_pattern ?? ''}, multiples of ${size} m`,
    );
  }
  const url = text(access.url_field) ?? null;
  if (access.url_field !== undefined && url === null) {
    throw catalogueError(
      what,
      `square ${square.name} has no field ${access.url_field}`,
      'its address',
    );
  }
  const block = text(access.block_field);
  return {
    square,
    url,
    block:
      block === undefined
        ? null
        : (new RegExp(access.block_pattern ?? '^(?<block>.+)$').exec(block)?.groups?.['block'] ??
          null),
    rank: `${text(access.edition_field) ?? ''} ${url ?? ''} ${feature.id ?? ''}`,
    published: text(access.published_field)?.slice(0, 10) ?? null,
  };
}

/** Whether a square is listed before its file is published: its address is then null or empty. */
export function isUnpublished(feature: WfsFeature, access: WfsAccess): boolean {
  const { url_field } = access;
  if (
    url_field === undefined ||
    feature.properties === null ||
    !(url_field in feature.properties)
  ) {
    return false;
  }
  const value = feature.properties[url_field];
  return value === null || value === '';
}

function parseText(feature: WfsFeature, field: string | undefined): string | undefined {
  const value = field === undefined ? undefined : feature.properties?.[field];
  if (typeof value === 'string' && value !== '') return value;
  return typeof value === 'number' && Number.isFinite(value) ? String(value) : undefined;
}

/**
 * In the order of the reply.
 * @return undefined for a feature without a place
 */
export function readFootprint(feature: WfsFeature): BoundsM | undefined {
  const points: Point[] = [];
  collectPoints(feature.geometry?.coordinates, points);
  return points.length === 0 ? undefined : measureBounds(points);
}

function collectPoints(coordinates: unknown, points: Point[]): void {
  if (!Array.isArray(coordinates)) return;
  const [x, y] = coordinates as unknown[];
  if (typeof x === 'number' && typeof y === 'number') points.push([x, y]);
  else for (const part of coordinates as unknown[]) collectPoints(part, points);
}

import { z } from 'zod';
import type { HttpClient } from '../../fetch/http-client.js';
import { measureBounds, overlap, ringOfBox } from '../../geo/bounds.js';
import { findProjection, type Point } from '../../geo/crs.js';
import type { BoundsM, CatalogueSquare, Catalogue, Region } from '../../model/store.js';
import type { WfsAccess } from '../access-schema.js';
import { listHosts, type Source } from '../source.js';
import type { Square } from '../square.js';
import { makeAddresses } from '../addresses.js';
import {
  listBoxes,
  Entries,
  catalogueError,
  isInRegion,
  Listing,
  type CatalogueSettings,
} from './listing.js';
import { checkHost, getJson, type CatalogueClient } from './json-request.js';
import { gridSquare } from './template-catalogue.js';
import { patternReader } from '../naming.js';

/**
 * Features of a WFS 2.0.0 that answers GeoJSON. Ref: OGC 09-025r2, "Web Feature Service 2.0
 * Interface Standard".
 */
export function wfsCatalogue(
  source: Source,
  access: WfsAccess,
  http: HttpClient,
  settings: CatalogueSettings,
): Catalogue {
  const size = source.square_m ?? 1000;
  const addresses = makeAddresses(source, settings.variables);
  const layerCrs = access.crs ?? source.crs;
  const client: CatalogueClient = {
    what: `list ${source.id}`,
    http,
    hosts: listHosts(source),
    settings,
  };

  async function* find(region: Region, signal: AbortSignal): AsyncGenerator<CatalogueSquare> {
    const listing = new Listing(client.what, settings.maxSquares);
    const entries = new Entries(settings);
    for (const box of listBoxes(region, source)) {
      for await (const feature of featuresIn(
        client,
        { ...access, crs: layerCrs },
        inLayerCrs(box, source, layerCrs),
        signal,
      )) {
        if (isUnpublished(feature, access)) continue;
        const read = entries.read(() => {
          const found = readFeature(feature, access, size, client.what);
          if (found.url !== null) checkHost(client, found.url);
          return found;
        });
        if (read === undefined) continue;
        const block = addresses.block ?? read.block;
        const urls = read.url === null ? addresses.of(read.square, block) : [read.url];
        const square = { ...gridSquare(read.square, size, block, urls), published: read.published };
        if (isInRegion(square, region)) listing.add(square, read.rank);
      }
    }
    entries.end();
    yield* listing.sorted();
  }

  return { find, locate: addresses.locate };
}

type Layer = WfsAccess & { readonly crs: string };

function inLayerCrs(box: BoundsM, source: Source, crs: string): BoundsM {
  if (crs === source.crs) return box;
  const from = findProjection(source.crs);
  const to = findProjection(crs);
  return measureBounds(ringOfBox(box, 20).map((point) => to.fromDegrees(from.toDegrees(point))));
}

/**
 * All features of a box, page by page.
 * @throws GrabberError CATALOGUE when the service sent fewer than it announced
 */
async function* featuresIn(
  client: CatalogueClient,
  access: Layer,
  box: BoundsM,
  signal: AbortSignal,
): AsyncGenerator<WfsFeature> {
  const { limits } = client.settings;
  const seen = new Set<string>();
  let start = 0;
  for (let page = 0; ; ++page) {
    if (page >= limits.pages) {
      throw catalogueError(client.what, `more than ${limits.pages} pages`, 'less ground');
    }
    const reply = await getJson(client, requestUrl(access, box, start), collectionSchema, signal);
    checkPlace(client, access, reply, box);
    const matched = matchedBy(reply);
    for (const feature of reply.features) {
      const id = feature.id === undefined ? JSON.stringify(feature.properties) : String(feature.id);
      if (seen.has(id)) continue;
      seen.add(id);
      yield feature;
    }
    start += reply.features.length;
    if (start > limits.items) {
      throw catalogueError(client.what, `more than ${limits.items} features`, 'less ground');
    }
    const done =
      matched === undefined ? reply.features.length < access.page_size : start >= matched;
    if (!done && reply.features.length > 0) continue;
    // Services without a fixed order may repeat features on one page and lose others.
    if (matched !== undefined && seen.size < matched) {
      throw catalogueError(client.what, `got ${seen.size} of ${matched} features`, 'all of them');
    }
    return;
  }
}

function matchedBy(reply: WfsCollection): number | undefined {
  const matched = Number(reply.numberMatched ?? NaN);
  return Number.isSafeInteger(matched) && matched >= 0 ? matched : undefined;
}

function requestUrl(access: Layer, box: BoundsM, start: number): string {
  const [west, south, east, north] = box;
  // "EPSG:n" means east first with the servers in use, whatever the EPSG register says; "urn:"
  // would follow the register.
  const { crs } = access;
  const corners = access.axes === 'en' ? [west, south, east, north] : [south, west, north, east];
  const url = new URL(access.url);
  const parameters: Record<string, string> = {
    SERVICE: 'WFS',
    VERSION: '2.0.0',
    REQUEST: 'GetFeature',
    TYPENAMES: access.type,
    OUTPUTFORMAT: 'application/json',
    SRSNAME: crs,
    BBOX: `${corners.join(',')},${crs}`,
    SORTBY: access.name_field,
    COUNT: String(access.page_size),
    STARTINDEX: String(start),
  };
  for (const [name, value] of Object.entries(parameters)) url.searchParams.set(name, value);
  return url.href;
}

/**
 * A reply for another place means swapped axes or another CRS; accepted, it would look like "no
 * squares here".
 */
function checkPlace(
  client: CatalogueClient,
  access: WfsAccess,
  reply: WfsCollection,
  [west, south, east, north]: BoundsM,
): void {
  const footprints = reply.features.map(readFootprint).filter((found) => found !== undefined);
  if (footprints.length === 0) return;
  const requested: BoundsM =
    access.axes === 'en' ? [west, south, east, north] : [south, west, north, east];
  const reach: BoundsM = [requested[0] - 1, requested[1] - 1, requested[2] + 1, requested[3] + 1];
  if (footprints.some((found) => overlap(found, reach))) return;
  throw catalogueError(
    client.what,
    `the first of ${footprints.length} features lies at ${(footprints[0] ?? []).join(',')}`,
    `within ${requested.join(',')}; crs or axes may be wrong`,
  );
}

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

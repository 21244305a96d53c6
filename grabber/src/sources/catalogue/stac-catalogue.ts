import { z } from 'zod';
import type { HttpClient } from '../../fetch/http-client.js';
import { boundsToDegrees, measureBounds, ringOfBox } from '../../geo/bounds.js';
import { findProjection, type Point, type Projection } from '../../geo/crs.js';
import type { BoundsM, CatalogueSquare, Catalogue, Region } from '../../model/store.js';
import type { StacAccess, AssetChoice } from '../access-schema.js';
import { listHosts, type Source } from '../source.js';
import { chooseVariables } from '../addresses.js';
import {
  listBoxes,
  Entries,
  catalogueError,
  isInRegion,
  Listing,
  type CatalogueSettings,
} from './listing.js';
import { checkHost, getJson, type CatalogueClient, describeIssue } from './json-request.js';
import { boundsOfSquare, patternReader } from '../naming.js';
import { squareAt, type Square } from '../square.js';

const linkSchema = z.looseObject({
  rel: z.string(),
  href: z.string(),
  method: z.string().optional(),
});
const pageSchema = z.looseObject({
  features: z.array(z.unknown()),
  links: z.array(linkSchema).default([]),
});
const signedSchema = z.looseObject({ href: z.string() });

const kDegreeDigits = 7;
/** In a row; some APIs end with one. */
const kMaxEmptyPages = 3;

/** Items of a STAC API. Ref: "STAC API - Features", "OGC API - Features - Part 1". */
export function stacCatalogue(
  source: Source,
  access: StacAccess,
  http: HttpClient,
  settings: CatalogueSettings,
): Catalogue {
  chooseVariables(source, settings.variables);
  const client: CatalogueClient = {
    what: `list ${source.id}`,
    http,
    hosts: listHosts(source),
    settings,
  };
  const { sign } = access;

  async function* find(region: Region, signal: AbortSignal): AsyncGenerator<CatalogueSquare> {
    const listing = new Listing(client.what, settings.maxSquares);
    const entries = new Entries(settings);
    let items = 0;
    for (const box of listBoxes(region, source)) {
      for await (const { item, base } of itemsIn(client, source, access, box, signal)) {
        items += 1;
        if (items > settings.limits.items) {
          throw catalogueError(
            client.what,
            `more than ${settings.limits.items} items`,
            'less ground',
          );
        }
        const read = entries.read(() => {
          const found = readItem(parseItem(item, client.what), source, access, base);
          for (const href of found.hrefs) checkHost(client, href);
          return found;
        });
        if (read === undefined) continue;
        const { square, rank } = read;
        // A signed address is valid for about an hour, so it is requested just before its download.
        if (isInRegion(square, region)) {
          listing.add(sign === undefined ? square : { ...square, urls: [] }, rank);
        }
      }
    }
    entries.end();
    yield* listing.sorted();
  }

  if (sign === undefined) return { find };
  return {
    find,
    addressesExpire: true,
    async locate(square, _near, _exists, signal) {
      const url = `${access.items}/${encodeURIComponent(square.name)}`;
      const item = await getJson(client, url, itemSchema, signal);
      const [href] = readItem(item, source, access, url).hrefs;
      if (href === undefined) return undefined;
      return { ...square, urls: [await signedUrl(client, sign, href, signal)] };
    },
  };
}

/** @return the address that is valid for a while, as the signing service gives it */
async function signedUrl(
  client: CatalogueClient,
  sign: string,
  href: string,
  signal: AbortSignal,
): Promise<string> {
  checkHost(client, href);
  const url = sign.replace('{href}', encodeURIComponent(href));
  const signed = await getJson(client, url, signedSchema, signal);
  checkHost(client, signed.href);
  return signed.href;
}

type RawItem = { readonly item: unknown; readonly base: string };

async function* itemsIn(
  client: CatalogueClient,
  source: Source,
  access: StacAccess,
  box: BoundsM,
  signal: AbortSignal,
): AsyncGenerator<RawItem> {
  const { limits } = client.settings;
  const degrees = boundsToDegrees(box, findProjection(source.crs)).map((value) =>
    value.toFixed(kDegreeDigits),
  );
  const first = new URL(access.items);
  first.searchParams.set('bbox', degrees.join(','));
  first.searchParams.set('limit', String(access.page_size));
  const seen = new Set<string>();
  let empty = 0;
  for (let url: string | undefined = first.href; url !== undefined;) {
    if (seen.has(url)) {
      throw catalogueError(
        client.what,
        `the next page of ${url} is one that was read before`,
        'pages that end',
      );
    }
    if (seen.size >= limits.pages) {
      throw catalogueError(client.what, `more than ${limits.pages} pages`, 'less ground');
    }
    seen.add(url);
    const base: string = url;
    const page: z.infer<typeof pageSchema> = await getJson(client, base, pageSchema, signal);
    for (const item of page.features) yield { item, base };
    url = findNext(client, page.links, base);
    empty = page.features.length > 0 ? 0 : empty + 1;
    if (url !== undefined && empty > kMaxEmptyPages) {
      throw catalogueError(
        client.what,
        `${empty} pages without items, and another is promised`,
        `at most ${kMaxEmptyPages}`,
      );
    }
  }
}

function findNext(
  client: CatalogueClient,
  links: readonly z.infer<typeof linkSchema>[],
  base: string,
): string | undefined {
  const next = links.find((link) => link.rel === 'next');
  if (next === undefined) return undefined;
  const method = next.method ?? 'GET';
  if (method.toUpperCase() !== 'GET') {
    throw catalogueError(client.what, `the next page needs a request with ${method}`, 'GET');
  }
  if (!URL.canParse(next.href, base)) {
    throw catalogueError(client.what, `the next page is at ${next.href}`, 'a web address');
  }
  return new URL(next.href, base).href;
}

const assetSchema = z.looseObject({
  href: z.string().min(1).max(4000),
  type: z.string().optional(),
  'file:size': z.number().int().nonnegative().optional(),
  'file:checksum': z.string().optional(),
  'checksum:multihash': z.string().optional(),
});

/**
 * STAC 0.9 to 1.1, what is needed of it. Ref: "STAC Item Specification", File Info and Projection
 * extensions.
 */
export const itemSchema = z.looseObject({
  id: z.string().min(1).max(300),
  bbox: z.array(z.number()).optional(),
  properties: z.looseObject({ datetime: z.string().nullish(), end_datetime: z.string().nullish() }),
  assets: z.record(z.string(), assetSchema),
});
export type StacItem = z.infer<typeof itemSchema>;

/** @throws GrabberError CATALOGUE, which names the item as far as it has a name */
export function parseItem(raw: unknown, what: string): StacItem {
  const result = itemSchema.safeParse(raw);
  if (result.success) return result.data;
  const { id } = z
    .looseObject({ id: z.string().max(300).catch('without an id') })
    .catch({ id: 'without an id' })
    .parse(raw);
  const found = describeIssue(result.error, 'it');
  throw catalogueError(`${what}: item ${id}`, found, 'a STAC item', result.error);
}

type Asset = z.infer<typeof assetSchema>;

/**
 * Half of what a footprint may differ from its square: footprints follow the data, and were
 * projected.
 */
const kFootprintSlack = 0.05;
const kPlainName = /^[A-Za-z0-9][A-Za-z0-9._-]{0,119}$/;

export type ReadItem = {
  readonly square: CatalogueSquare;
  readonly rank: string;
  readonly hrefs: readonly string[];
};

/**
 * @param base address of the reply, for links relative to it
 * @throws GrabberError CATALOGUE
 */
export function readItem(
  item: StacItem,
  source: Source,
  access: StacAccess,
  base: string,
): ReadItem {
  const what = `list ${source.id}: item ${item.id}`;
  const [asset, choice] = chooseAsset(item, access.assets, what);
  const place = toPlace(item, source, access, what);
  const published = item.properties.datetime ?? item.properties.end_datetime ?? null;
  const href = absolute(asset.href, base, what);
  return {
    hrefs: [href],
    // Items without a date are older than any; the id decides between equals, so that the order of
    // replies does not.
    rank: `${published ?? ''} ${item.id}`,
    square: {
      ...place,
      block: null,
      urls: [href],
      bytes: asset['file:size'] ?? null,
      sha256: parseSha256(asset['file:checksum'] ?? asset['checksum:multihash']),
      member: choice.member ?? null,
      published: published === null ? null : published.slice(0, 10),
    },
  };
}

function chooseAsset(
  item: StacItem,
  choices: readonly AssetChoice[],
  what: string,
): [Asset, AssetChoice] {
  const all = Object.entries(item.assets).sort(([a], [b]) => (a < b ? -1 : 1));
  for (const choice of choices) {
    const found = all.find(
      ([key, asset]) =>
        fits(choice.key, key) &&
        fits(choice.href, asset.href) &&
        fits(choice.media_type, asset.type ?? ''),
    );
    if (found !== undefined) return [found[1], choice];
  }
  throw catalogueError(
    what,
    `assets ${all.map(([key]) => key).join(', ') || 'none'}`,
    'one that [[access.assets]] describes',
  );
}

function fits(pattern: string | undefined, text: string): boolean {
  return pattern === undefined || new RegExp(pattern, 'i').test(text);
}

function absolute(href: string, base: string, what: string): string {
  if (URL.canParse(href, base)) return new URL(href, base).href;
  throw catalogueError(what, `address ${href}`, 'a web address');
}

function toPlace(
  item: StacItem,
  source: Source,
  access: StacAccess,
  what: string,
): { name: string; bounds: BoundsM | null } {
  const projection = findProjection(source.crs);
  if (source.square_m === undefined) {
    // The name finds the item again and becomes a file's, so it is taken as it is or not at all.
    if (!kPlainName.test(item.id)) {
      throw catalogueError(
        what,
        'its id is no file name',
        'letters, digits, ".", "_" and "-", at most 120',
      );
    }
    return { name: item.id, bounds: readFootprint(item, projection) };
  }
  const square =
    access.name_pattern === undefined
      ? snapped(item, projection, source.square_m, what)
      : patternReader(access.name_pattern, access.name_corner, source.square_m)(item.id);
  if (square === undefined) {
    const allowed = `names with ${access.name_pattern ?? ''}, multiples of ${source.square_m} m`;
    throw catalogueError(what, 'its name does not give a square', allowed);
  }
  return { name: square.name, bounds: boundsOfSquare(square, source.square_m) };
}

function readFootprint(item: StacItem, projection: Projection): BoundsM | null {
  const flat =
    item.bbox?.length === 6 ? [0, 1, 3, 4].map((index) => item.bbox?.[index] ?? NaN) : item.bbox;
  if (flat?.length !== 4) return null;
  const [west = NaN, south = NaN, east = NaN, north = NaN] = flat;
  return measureBounds(
    ringOfBox([west, south, east, north], 4).map((point: Point) => projection.fromDegrees(point)),
  );
}

/** The square of the grid that holds the footprint. */
function snapped(item: StacItem, projection: Projection, size: number, what: string): Square {
  const footprint = readFootprint(item, projection);
  if (footprint === null) {
    throw catalogueError(what, 'it has no bbox', 'west, south, east, north in degrees');
  }
  const [west, south, east, north] = footprint;
  const corner: Point = [
    Math.floor((west + east) / 2 / size) * size,
    Math.floor((south + north) / 2 / size) * size,
  ];
  const slack = size * kFootprintSlack;
  const inside =
    west >= corner[0] - slack &&
    south >= corner[1] - slack &&
    east <= corner[0] + size + slack &&
    north <= corner[1] + size + slack;
  if (!inside) {
    throw catalogueError(
      what,
      `its footprint is ${footprint.map(Math.round).join(',')}`,
      `one square of ${size} m`,
    );
  }
  return squareAt(corner[0], corner[1]);
}

/**
 * A multihash names its function and length first: 12 = SHA-256, 20 = 32 bytes. Others are none of
 * ours.
 */
function parseSha256(multihash: string | undefined): string | null {
  const match = /^1220([0-9a-f]{64})$/i.exec(multihash ?? '');
  return match?.[1]?.toLowerCase() ?? null;
}

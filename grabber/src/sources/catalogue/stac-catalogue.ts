import { z } from 'zod';
import type { HttpClient } from '../../fetch/http-client.js';
import { boundsToDegrees } from '../../geo/bounds.js';
import { findProjection } from '../../geo/crs.js';
import type { BoundsM, CatalogueSquare } from '../../model/square.js';
import type { Catalogue, Region } from '../../model/store.js';
import type { StacAccess } from '../access-schema.js';
import { listHosts } from '../hosts.js';
import type { Source } from '../source.js';
import { chooseVariables } from '../variables.js';
import { listBoxes } from './boxes.js';
import { Entries } from './entries.js';
import { checkHost, getJson, type CatalogueClient } from './json-request.js';
import { catalogueError, isInRegion, Listing } from './listing.js';
import type { CatalogueSettings } from './options.js';
import { itemSchema, parseItem, readItem } from './stac-item.js';

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

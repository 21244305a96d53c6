import type { HttpClient } from '../../fetch/http-client.js';
import { measureBounds, overlap, ringOfBox } from '../../geo/bounds.js';
import { findProjection } from '../../geo/crs.js';
import type { BoundsM, CatalogueSquare } from '../../model/square.js';
import type { Catalogue, Region } from '../../model/store.js';
import type { WfsAccess } from '../access-schema.js';
import { listHosts } from '../hosts.js';
import type { Source } from '../source.js';
import { parseSquare } from '../square.js';
import { findBlockVariable, chooseVariables } from '../variables.js';
import { listBoxes } from './boxes.js';
import { Entries } from './entries.js';
import { checkHost, getJson, type CatalogueClient } from './json-request.js';
import { catalogueError, isInRegion, Listing } from './listing.js';
import type { CatalogueSettings } from './options.js';
import { makeAddresses } from './probe.js';
import { gridSquare } from './template-catalogue.js';
import {
  collectionSchema,
  readFootprint,
  isUnpublished,
  readFeature,
  type WfsCollection,
  type WfsFeature,
} from './wfs-feature.js';

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
  const chosen = chooseVariables(source, settings.variables);
  const blockVariable = findBlockVariable(source);
  const fixed = blockVariable === undefined ? null : (chosen.given[blockVariable] ?? null);
  const addresses = makeAddresses(source, chosen, blockVariable);
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
        const block = fixed ?? read.block;
        const urls = read.url === null ? addresses.of(read.square, block) : [read.url];
        const square = { ...gridSquare(read.square, size, block, urls), published: read.published };
        if (isInRegion(square, region)) listing.add(square, read.rank);
      }
    }
    entries.end();
    yield* listing.sorted();
  }

  if (chosen.probed === undefined) return { find };
  return {
    find,
    locate: (square, near, exists, signal) =>
      addresses.locate(
        square,
        parseSquare(square.name, { square_m: size, extent_m: source.extent_m }),
        near,
        exists,
        signal,
      ),
  };
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

import { z } from 'zod';
import { GrabberError, describeError } from '../util/errors.js';
import { compareText } from '../util/text.js';
import { runAll, type AssetCache } from './download.js';
import { probeImage, type Gather, type GatherContext, type Piece } from './piece.js';
import { boundsIn } from './target.js';
import type { OrthoSource, StacAccess } from './schema.js';

const kMaxPage_bytes = 64 << 20;
const kMaxPages = 100;
const kPageItems = 100;
/** About 10 cm: the same square of ground has the same box, as far as catalogues compute alike. */
const kBoxDigits = 6;

const itemSchema = z.object({
  id: z.string(),
  bbox: z.array(z.number()).min(4),
  properties: z.object({ datetime: z.string().nullish(), start_datetime: z.string().nullish() }),
  assets: z.record(z.string(), z.object({ href: z.string() })),
});
const pageSchema = z.object({
  features: z.array(itemSchema),
  links: z
    .array(
      z.object({ rel: z.string(), href: z.string().optional(), method: z.string().optional() }),
    )
    .default([]),
});
type Item = z.infer<typeof itemSchema>;
type Asset = { readonly url: string; readonly date: string; readonly place: string };

/**
 * Whole files of a catalogue, cut later; the newest of each place (or of the requested time).
 */
export function stacGather(source: OrthoSource, access: StacAccess, cache: AssetCache): Gather {
  return async (target, context, signal) => {
    const { bounds } = await boundsIn(target, 'EPSG:4326', context.gdal, signal);
    const items = await findItems(access, bounds, context, signal);
    const assets = newestOfEachPlace(
      items.flatMap((item) => findAssets(item, access, context.time)),
    );
    if (assets.length === 0) return undefined;
    const pieces = await runAll(
      assets.map((asset) => async (signal: AbortSignal): Promise<Piece | undefined> => {
        const path = await cache.get(asset.url, context.download, signal);
        if (path === undefined) return undefined;
        const probe = await probeImage(path, asset.url, context.gdal, signal);
        return { path, kind: probe.kind, channels: probe.channels, crs: null };
      }),
      context.concurrency,
      signal,
    );
    const found = pieces.filter((piece) => piece !== undefined);
    if (found.length < pieces.length) {
      throw new GrabberError(
        'MAP_SERVICE',
        `gather pictures of ${source.id}: ${pieces.length - found.length} of ` +
          `${pieces.length} that its catalogue names are not there; allowed: all of them`,
      );
    }
    return {
      pieces: found,
      url: assets.at(-1)?.url ?? access.url,
      grid: undefined,
      resolution_m: source.resolution_m,
      date: assets.at(-1)?.date.slice(0, 10),
      warnings: [],
    };
  };
}

async function findItems(
  access: StacAccess,
  bounds: readonly number[],
  context: GatherContext,
  signal: AbortSignal,
): Promise<Item[]> {
  const first = new URL(access.url);
  first.searchParams.set('bbox', bounds.map((degrees) => degrees.toFixed(7)).join(','));
  first.searchParams.set('limit', String(kPageItems));
  const items: Item[] = [];
  let next: string | undefined = first.href;
  for (let page = 0; next !== undefined; ++page) {
    if (page === kMaxPages) {
      throw new GrabberError(
        'MAP_SERVICE',
        `list pictures at ${access.url}: more than ${kMaxPages} pages; allowed: at most that`,
      );
    }
    const text = await context.download.text(next, kMaxPage_bytes, signal);
    if (text === undefined) {
      throw new GrabberError(
        'MAP_SERVICE',
        `list pictures at ${next}: not there; allowed: a STAC list of items`,
      );
    }
    const parsed = parsePage(text, next);
    items.push(...parsed.features);
    const link = parsed.links.find((one) => one.rel === 'next');
    if (
      link !== undefined &&
      (link.href === undefined || (link.method ?? 'GET').toUpperCase() !== 'GET')
    ) {
      throw new GrabberError(
        'MAP_SERVICE',
        `list pictures at ${next}: the next page is no plain address; allowed: a link to GET`,
      );
    }
    next = link?.href === undefined ? undefined : new URL(link.href, next).href;
  }
  return items;
}

function parsePage(text: string, url: string): z.infer<typeof pageSchema> {
  try {
    return pageSchema.parse(JSON.parse(text));
  } catch (error) {
    throw new GrabberError(
      'MAP_SERVICE',
      `list pictures at ${url}: ${describeError(error).slice(0, 200)}; allowed: a STAC ` +
        'list of items',
      { cause: error },
    );
  }
}

function findAssets(item: Item, access: StacAccess, time: string | undefined): Asset[] {
  const date = item.properties.datetime ?? item.properties.start_datetime ?? '';
  if (time !== undefined && !date.startsWith(time)) return [];
  const pattern = new RegExp(access.asset);
  const place = item.bbox.map((degrees) => degrees.toFixed(kBoxDigits)).join(',');
  return Object.values(item.assets)
    .filter((asset) => pattern.test(asset.href))
    .map((asset) => ({ url: new URL(asset.href, access.url).href, date, place }));
}

/** Oldest first, since a later piece is laid over an earlier one. */
function newestOfEachPlace(assets: Asset[]): Asset[] {
  const sorted = [...assets].sort(
    (a, b) => compareText(a.date, b.date) || compareText(a.url, b.url),
  );
  const newest = new Map(sorted.map((asset) => [asset.place, asset]));
  return [...newest.values()].sort((a, b) => compareText(a.date, b.date));
}

import { toBox, overlap, parseBox, ringInDegrees } from './ground.js';
import { toUrl, sendJson, type PortalContext, type PortalHandler } from './portal.js';
import type { PortalSquare } from './squares.js';

const kItems = '/stac/v1/collections/squares/items';
const kLimit = 100;

/**
 * A STAC API like that of swisstopo: GET items?bbox=&limit=, paged by links with rel "next".
 * The squares are synthetic.
 */
export const stacHandler: PortalHandler = (request, response, context) => {
  const { pathname, searchParams } = toUrl(request);
  if (pathname !== kItems) return false;
  const bbox = parseBox(searchParams.get('bbox'));
  const limit = Math.min(kLimit, Number(searchParams.get('limit') ?? kLimit)) || kLimit;
  const from = Number(searchParams.get('cursor') ?? 0);
  const features = context.squares.map((square) => makeItem(square, context));
  const fitting =
    bbox === undefined ? features : features.filter((item) => overlap(item.bbox, bbox));
  const links: object[] = [{ rel: 'self', href: `${context.base}${kItems}` }];
  if (from + limit < fitting.length) {
    const query = new URLSearchParams(searchParams);
    query.set('cursor', String(from + limit));
    links.push({
      rel: 'next',
      method: 'GET',
      type: 'application/geo+json',
      href: `${context.base}${kItems}?${query.toString()}`,
    });
  }
  sendJson(
    response,
    { type: 'FeatureCollection', features: fitting.slice(from, from + limit), links },
    'application/geo+json',
  );
  return true;
};

function makeItem(square: PortalSquare, context: PortalContext) {
  const { east_km, north_km, bytes, path } = square;
  const ring = ringInDegrees(
    [east_km * 1000, north_km * 1000, east_km * 1000 + 1000, north_km * 1000 + 1000],
    context.crs,
  );
  const name = path.split('/').at(-1) ?? path;
  const type = name.endsWith('.zip') ? 'application/x.las+zip' : 'application/vnd.laszip+copc';
  return {
    type: 'Feature',
    stac_version: '0.9.0',
    id: `squares_2024_${east_km}-${north_km}`,
    collection: 'squares',
    bbox: toBox(ring),
    geometry: { type: 'Polygon', coordinates: [ring] },
    properties: {
      datetime: '2024-05-01T00:00:00Z',
      created: '2024-06-01T00:00:00Z',
      updated: '2024-06-01T00:00:00Z',
    },
    links: [{ rel: 'self', href: `${context.base}${kItems}/squares_2024_${east_km}-${north_km}` }],
    assets: {
      [name]: {
        type,
        href: `${context.base}/${path}`,
        'proj:epsg': Number(context.crs.replace('EPSG:', '')),
        'file:size': bytes,
      },
    },
  };
}

import assert from 'node:assert/strict';
import { test, type TestContext } from 'node:test';
import { regionOfBox } from '../../../../grabber/src/select/region.js';
import type { Source } from '../../../../grabber/src/sources/source.js';
import {
  makeCatalogue,
  found,
  foundNames,
  refused,
  sourceWith,
} from '../../support/catalogue-fixture.js';
import { serve, type HttpFixture } from '../../support/http-fixture.js';
import { kNever } from '../../support/store-fixture.js';

const kRegion = regionOfBox([462_000, 101_000, 464_000, 103_000]);

type Feature = {
  id: string;
  geometry: unknown;
  properties: Record<string, unknown>;
  [field: string]: unknown;
};

/**
 * A feature as GeoServer sends it.
 * @param swap north first
 */
function feature(
  east: number,
  north: number,
  properties: Record<string, unknown>,
  swap = false,
): Feature {
  const [w, s] = [east * 1000, north * 1000];
  const ring = [
    [w, s],
    [w + 1000, s],
    [w + 1000, s + 1000],
    [w, s + 1000],
    [w, s],
  ];
  return {
    type: 'Feature',
    id: `layer.${east}.${north}.${JSON.stringify(properties)}`,
    geometry: { type: 'MultiPolygon', coordinates: [[swap ? ring.map(([x, y]) => [y, x]) : ring]] },
    geometry_name: 'geom',
    properties,
  };
}

/** A feature as data.geopf.fr sends it; dates and paths are synthetic. */
function ignFeature(
  base: string,
  east: number,
  north: number,
  edition: string,
  url?: string | null,
): Feature {
  const corner = [east, north + 1].map((km) => String(km).padStart(4, '0')).join('_');
  const name = `LHD_FXX_${corner}_PTS_LAMB93_IGN69.copc.laz`;
  return feature(east, north, {
    url_mnt: null,
    url_npl: url === undefined ? `${base}/NUALHD_1-0__LAZ_LAMB93_${edition}/${name}` : url,
    date_edition: edition,
    date_fin_acquisition: '2021-06-30Z',
    code_mission: '21LHD5QK2',
  });
}

function ignSource(base: string, more = ''): Source {
  return sourceWith(`
[access]
kind = "wfs"
url = "${base}/wfs"
type = "IGNF_LIDAR-HD_METADONNEE:metadata"
page_size = 2
url_field = "url_npl"
name_field = "url_npl"
name_pattern = 'LHD_FXX_(?<E>\\d{4})_(?<N>\\d{4})_PTS'
name_corner = "nw"
edition_field = "date_edition"
published_field = "date_fin_acquisition"
${more}
`);
}

type Reply = { features: Feature[]; [field: string]: unknown };

/** A WFS with these features, as GeoServer pages through them. */
async function service(
  t: TestContext,
  features: (base: string) => Feature[],
  change: (reply: Reply) => unknown = (reply) => reply,
): Promise<HttpFixture> {
  const server = await serve(t, (request, response) => {
    const requested = new URL(request.url ?? '', server.base).searchParams;
    const start = Number(requested.get('STARTINDEX'));
    const all = features(server.base);
    const page = all.slice(start, start + Number(requested.get('COUNT')));
    const reply = {
      type: 'FeatureCollection',
      features: page,
      totalFeatures: all.length,
      numberMatched: all.length,
      numberReturned: page.length,
      crs: { type: 'name', properties: { name: 'urn:ogc:def:crs:EPSG::3794' } },
    };
    response.writeHead(200, { 'content-type': 'application/json;charset=UTF-8' });
    response.end(JSON.stringify(change(reply)));
  });
  return server;
}

test('features become squares: all pages, north-west names, the newest edition', async (t) => {
  const server = await service(t, (base) => [
    ignFeature(base, 463, 101, '2025-06-13Z'),
    ignFeature(base, 462, 102, '2025-06-13Z'),
    ignFeature(base, 463, 101, '2026-01-01Z'),
    ignFeature(base, 464, 101, '2025-06-13Z'),
    ignFeature(base, 462, 101, '2025-06-13Z', null),
  ]);
  const squares = await found(makeCatalogue(t, ignSource(server.base)), kRegion);
  assert.deepEqual(
    squares.map(({ name }) => name),
    ['463_101', '462_102'],
    'what is not published is not there',
  );
  assert.deepEqual(squares[0], {
    name: '463_101',
    block: null,
    bounds: [463_000, 101_000, 464_000, 102_000],
    urls: [
      `${server.base}/NUALHD_1-0__LAZ_LAMB93_2026-01-01Z/` +
        'LHD_FXX_0463_0102_PTS_LAMB93_IGN69.copc.laz',
    ],
    bytes: null,
    sha256: null,
    member: null,
    published: '2021-06-30',
  });
  assert.equal(server.seen.length, 3);
  const requested = Object.fromEntries(
    new URL(server.seen[1]?.path ?? '', server.base).searchParams,
  );
  assert.deepEqual(requested, {
    SERVICE: 'WFS',
    VERSION: '2.0.0',
    REQUEST: 'GetFeature',
    TYPENAMES: 'IGNF_LIDAR-HD_METADONNEE:metadata',
    OUTPUTFORMAT: 'application/json',
    SRSNAME: 'EPSG:3794',
    BBOX: '462000,101000,464000,103000,EPSG:3794',
    SORTBY: 'url_npl',
    COUNT: '2',
    STARTINDEX: '2',
  });
});

test('requests to a service that takes north first have that order', async (t) => {
  const server = await service(t, (base) => [
    { ...ignFeature(base, 462, 101, '2025'), geometry: feature(462, 101, {}, true).geometry },
  ]);
  const squares = await found(makeCatalogue(t, ignSource(server.base, 'axes = "ne"')), kRegion);
  assert.equal(squares[0]?.name, '462_101');
  assert.equal(
    new URL(server.seen[0]?.path ?? '', server.base).searchParams.get('BBOX'),
    '101000,462000,103000,464000,EPSG:3794',
  );
});

test('a layer in another CRS is requested in it', async (t) => {
  const server = await service(t, () => []);
  assert.deepEqual(
    await found(makeCatalogue(t, ignSource(server.base, 'crs = "EPSG:3857"')), kRegion),
    [],
  );
  const requested = new URL(server.seen[0]?.path ?? '', server.base).searchParams;
  assert.equal(requested.get('SRSNAME'), 'EPSG:3857');
  assert.match(
    requested.get('BBOX') ?? '',
    /^1615\d{3}\.\d+,5788\d{3}\.\d+,1618\d{3}\.\d+,5790\d{3}\.\d+,EPSG:3857$/,
  );
});

function indexSource(base: string): Source {
  return sourceWith(`
[access]
kind = "wfs"
url = "${base}/wfs"
type = "fmp_clss:tileindex_clss_zdruzeno"
name_field = "ti_name"
name_pattern = '^(?<E>\\d+)_(?<N>\\d+)$'
block_field = "path_pas"
block_pattern = '(?:^|/)(?<block>[0-9]{2}(?:-[a-z]+)+)/'
urls = ["${base}/clss/raw/{region}/zls/gkot/GKOT_{E}_{N}.laz"]
[access.variables.region]
about = "region"
pattern = "[0-9]{2}(-[a-z]+)+"
allowed = "04-jesenice"
values = ["04-jesenice", "05-ljubljana"]
`);
}

test('an index of names gives addresses: block from its path, the user, or probing', async (t) => {
  const server = await service(t, () => [
    feature(462, 101, {
      ti_name: '462_101',
      path_pas: 'clss/raw/05-ljubljana/zls/pas/PAS_462_101.tif',
    }),
    feature(463, 101, { ti_name: '463_101' }),
  ]);
  const catalogue = makeCatalogue(t, indexSource(server.base));
  const [withBlock, withoutBlock] = await found(catalogue, kRegion);
  assert.deepEqual(
    [withBlock?.block, withBlock?.urls],
    ['05-ljubljana', [`${server.base}/clss/raw/05-ljubljana/zls/gkot/GKOT_462_101.laz`]],
  );
  assert.ok(withoutBlock);
  assert.deepEqual([withoutBlock.block, withoutBlock.urls], [null, []]);
  const located = await catalogue.locate?.(
    withoutBlock,
    ['05-ljubljana'],
    (url) => Promise.resolve(url.includes('04-')),
    kNever,
  );
  assert.deepEqual(
    [located?.block, located?.urls],
    ['04-jesenice', [`${server.base}/clss/raw/04-jesenice/zls/gkot/GKOT_463_101.laz`]],
  );

  const given = makeCatalogue(t, indexSource(server.base), {
    variables: { region: '04-jesenice' },
  });
  const squares = await found(given, kRegion);
  assert.ok(
    squares.every(
      ({ block, urls }) => block === '04-jesenice' && urls[0]?.includes('/04-jesenice/'),
    ),
  );
  assert.equal(given.locate, undefined);
});

test('a reply that cannot be trusted is an error, never fewer squares', async (t) => {
  const one = (base: string): Feature => ignFeature(base, 462, 101, '2025');
  const exception =
    '<?xml version="1.0"?><ows:ExceptionReport><ows:Exception exceptionCode="Invalid">\n' +
    '<ows:ExceptionText>Feature type unknown</ows:ExceptionText></ows:Exception>' +
    '</ows:ExceptionReport>';
  const here = one('http://127.0.0.1');
  const three = (base: string): Feature[] =>
    [1, 2, 3].map((north) => ignFeature(base, 462, 100 + north, '2025'));
  const placed = (geometry: unknown) => (base: string) => [{ ...one(base), geometry }];
  type Case = [
    name: string,
    features: (base: string) => Feature[],
    message: RegExp,
    change?: (reply: Reply) => unknown,
  ];
  const cases: Case[] = [
    [
      'fewer than announced',
      (base) => [one(base)],
      /got 1 of 5 features/,
      (reply) => ({ features: [here].slice(0, reply.features.length), numberMatched: 5 }),
    ],
    [
      'the same page again and again',
      three,
      /got 1 of 3 features/,
      (reply) => ({ ...reply, features: [here, here] }),
    ],
    [
      'swapped axes',
      placed(feature(462, 101, {}, true).geometry),
      /lies at 101000,462000.*crs or axes may be wrong/,
    ],
    ['degrees', placed({ type: 'Point', coordinates: [14.5, 46] }), /crs or axes may be wrong/],
    ['no address field', () => [feature(462, 101, { other: 1 })], /no field url_npl/],
    [
      'a name of another form',
      () => [feature(462, 101, { url_npl: 'http://127.0.0.1/a.laz' })],
      /does not give a square/,
    ],
    ['an address elsewhere', () => [one('https://evil.example.org')], /leads to https:\/\/evil/],
  ];
  for (const [name, features, message, change] of cases) {
    await t.test(name, async (t) => {
      const server = await service(t, features, change);
      await refused(makeCatalogue(t, ignSource(server.base)), kRegion, message);
    });
  }
  const pages: [name: string, body: string, message: RegExp][] = [
    ['an exception report', exception, /the exception "Feature type unknown"; allowed: JSON/],
    ['a page', '<!DOCTYPE html><title>Log in</title>', /a page titled "Log in"/],
    ['half a reply', '{"features": [', /no JSON/],
    ['another thing', '[]', /the reply has|expected object/],
  ];
  for (const [name, body, message] of pages) {
    await t.test(name, async (t) => {
      const server = await serve(t, (_request, response) => response.end(body));
      await refused(makeCatalogue(t, ignSource(server.base)), kRegion, message);
    });
  }
});

test('a service that counts nothing is read until a page is not full', async (t) => {
  const server = await service(
    t,
    (base) => [1, 2, 3].map((north) => ignFeature(base, 462, 100 + north, '2025')),
    ({ features }) => ({ features, numberMatched: 'unknown' }),
  );
  assert.deepEqual(await foundNames(makeCatalogue(t, ignSource(server.base)), kRegion), [
    '462_101',
    '462_102',
  ]);
  assert.equal(server.seen.length, 2);
});

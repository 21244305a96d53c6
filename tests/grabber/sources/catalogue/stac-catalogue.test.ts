import assert from 'node:assert/strict';
import type { ServerResponse } from 'node:http';
import { test, type TestContext } from 'node:test';
import { findProjection } from '../../../../grabber/src/geo/crs.js';
import { boundsToDegrees } from '../../../../grabber/src/geo/bounds.js';
import type { BoundsM, CatalogueSquare } from '../../../../grabber/src/model/store.js';
import { regionOfBox, regionOfSquares } from '../../../../grabber/src/select/region.js';
import type { Source } from '../../../../grabber/src/sources/source.js';
import { squareAt } from '../../../../grabber/src/sources/square.js';
import {
  makeCatalogue,
  found,
  foundNames,
  refused,
  sourceWith,
} from '../../support/catalogue-fixture.js';
import { fakeClock, kNever } from '../../support/store-fixture.js';
import { kNoListener, serve, type HttpFixture } from '../../support/http-fixture.js';

const kSha = 'e8be2c5f50b61b0a2ce72d65b3a6d2af095d7feac0083fc33f2961d063db1ec1';
const kRegion = regionOfBox([462_000, 101_000, 464_000, 103_000]);

type Item = { id: string; [field: string]: unknown };

/**
 * An item as data.geo.admin.ch sends it: assets under their file names, checksums as multihashes.
 * Places are moved to the grid of the tests, and dates, sizes and sums are synthetic.
 */
function item(
  base: string,
  year: number,
  east: number,
  north: number,
  suffix: string,
  more: object = {},
): Item {
  const id = `swisssurface3d_${year}_${east}-${north}`;
  const file = `${id}_2056_5728.${suffix}`;
  const box: BoundsM = [east * 1000, north * 1000, east * 1000 + 1000, north * 1000 + 1000];
  return {
    type: 'Feature',
    stac_version: '1.0.0',
    id,
    collection: 'ch.swisstopo.swisssurface3d',
    bbox: boundsToDegrees(box, findProjection('EPSG:3794')),
    geometry: null,
    properties: {
      datetime: `${year}-01-01T00:00:00Z`,
      created: '2021-02-23T23:35:43Z',
      updated: '2025-01-17T10:12:18Z',
    },
    links: [{ rel: 'self', href: `${base}/items/${id}` }],
    assets: {
      [file]: {
        type: suffix === 'las.zip' ? 'application/vnd.laszip' : 'application/vnd.laszip+copc',
        href: `${base}/files/${id}/${file}`,
        'proj:epsg': 2056,
        'file:checksum': `1220${kSha.toUpperCase()}`,
        ...more,
      },
      metadata: { type: 'text/xml', href: `${base}/files/${id}/metadata.xml` },
    },
  };
}

function stacSource(base: string): Source {
  return sourceWith(`
[access]
kind = "stac"
items = "${base}/items"
page_size = 2
name_pattern = '_(?<E>\\d+)-(?<N>\\d+)'
[[access.assets]]
href = '\\.copc\\.laz$'
[[access.assets]]
href = '\\.las\\.zip$'
member = "*"
`);
}

function elsewhere(one: Item): Item {
  return { ...one, assets: { 'a.las.zip': { href: 'https://evil.example.org/a.las.zip' } } };
}

/** A source whose items have no place in their names. */
function nameless(base: string): Source {
  const source = stacSource(base);
  return { ...source, access: { ...source.access, name_pattern: undefined } } as Source;
}

function sendJson(response: ServerResponse, value: unknown): void {
  response.writeHead(200, { 'content-type': 'application/geo+json' });
  response.end(JSON.stringify(value));
}

/** A STAC API with these items, two a page, whose next links carry a cursor. */
async function portal(t: TestContext, items: (base: string) => Item[]): Promise<HttpFixture> {
  const server = await serve(t, (request, response) => {
    const url = new URL(request.url ?? '', server.base);
    const all = items(server.base);
    const start = Number(url.searchParams.get('cursor') ?? 0);
    const size = Number(url.searchParams.get('limit'));
    const next = new URL(url);
    next.searchParams.set('cursor', String(start + size));
    const links = [{ rel: 'self', href: url.href, method: 'GET' }];
    if (start + size < all.length) links.push({ rel: 'next', href: next.href, method: 'GET' });
    const features = all.slice(start, start + size);
    sendJson(response, { type: 'FeatureCollection', features, links });
  });
  return server;
}

function listed(t: TestContext, { base }: HttpFixture): Promise<CatalogueSquare[]> {
  return found(makeCatalogue(t, stacSource(base)), kRegion);
}

test('items become squares: all pages, the newest of each, COPC rather than ZIP', async (t) => {
  const server = await portal(t, (base) => [
    item(base, 2024, 463, 101, 'copc.laz', { 'file:size': 123_456_789 }),
    item(base, 2019, 463, 101, 'las.zip'),
    item(base, 2019, 462, 101, 'las.zip'),
    item(base, 2019, 462, 102, 'las.zip'),
    item(base, 2019, 470, 102, 'las.zip'),
  ]);
  const squares = await listed(t, server);
  assert.equal(squares.map(({ name }) => name).join(), '462_101,463_101,462_102');
  assert.deepEqual(squares[1], {
    name: '463_101',
    block: null,
    bounds: [463_000, 101_000, 464_000, 102_000],
    urls: [
      `${server.base}/files/swisssurface3d_2024_463-101/` +
        'swisssurface3d_2024_463-101_2056_5728.copc.laz',
    ],
    bytes: 123_456_789,
    sha256: kSha,
    member: null,
    published: '2024-01-01',
  });
  assert.equal(squares[0]?.member, '*');
  assert.equal(server.seen.length, 3);
  const requested = new URL(server.seen[0]?.path ?? '', server.base).searchParams;
  assert.equal(requested.get('limit'), '2');
  const [west = 0, south = 0, east = 0, north = 0] = (requested.get('bbox') ?? '')
    .split(',')
    .map(Number);
  const [lon, lat] = findProjection('EPSG:3794').toDegrees([463_000, 102_000]);
  assert.ok(west < lon && lon < east && south < lat && lat < north && east - west < 0.05);
});

test('which item of a square counts does not depend on the order of the reply', async (t) => {
  const items = (base: string): Item[] =>
    [2017, 2024, 2019].map((year) => item(base, year, 462, 101, 'las.zip'));
  for (const turned of [items, (base: string) => items(base).reverse()]) {
    const server = await portal(t, turned);
    const [square] = await listed(t, server);
    assert.equal(square?.published, '2024-01-01');
  }
});

test('squares far apart are requested one by one', async (t) => {
  const server = await portal(t, (base) => [
    item(base, 2019, 462, 101, 'las.zip'),
    item(base, 2019, 600, 180, 'las.zip'),
  ]);
  const region = regionOfSquares([squareAt(462_000, 101_000), squareAt(600_000, 180_000)], 1000);
  const catalogue = makeCatalogue(t, stacSource(server.base));
  assert.deepEqual(await foundNames(catalogue, region), ['462_101', '600_180']);
  assert.equal(server.seen.length, 2);
});

test('items without a place in their name are put on the grid by their footprint', async (t) => {
  const server = await portal(t, (base) => [item(base, 2019, 462, 101, 'las.zip')]);
  const [square] = await found(makeCatalogue(t, nameless(server.base)), kRegion);
  assert.equal(square?.name, '462_101');
  const wide = await portal(t, (base) => [
    { ...item(base, 2019, 462, 101, 'las.zip'), bbox: [14.4, 46, 14.6, 46.1] },
  ]);
  await refused(
    makeCatalogue(t, nameless(wide.base)),
    kRegion,
    /footprint is .*allowed: one square/,
  );
});

test('a reply that cannot be trusted is an error, never fewer squares', async (t) => {
  const good = (base: string): Item => item(base, 2019, 462, 101, 'las.zip');
  const next = (link: object) => () => ({ features: [], links: [{ rel: 'next', ...link }] });
  const cases: [name: string, reply: (base: string) => unknown, message: RegExp][] = [
    ['no features', () => ({ type: 'FeatureCollection' }), /features/],
    [
      'no assets of ours',
      (base) => ({ features: [{ ...good(base), assets: { readme: { href: 'x.txt' } } }] }),
      /assets readme; allowed: one that \[\[access\.assets\]\]/,
    ],
    [
      'a file at another host',
      (base) => ({ features: [elsewhere(good(base))] }),
      /leads to https:\/\/evil\.example\.org.*allowed: the hosts 127\.0\.0\.1/,
    ],
    ['a page elsewhere', next({ href: 'http://evil.example.org/' }), /to http:\/\/evil\.example/],
    ['a page that is a file', next({ href: 'file:///etc/passwd' }), /leads to file:/],
    ['a page that is this one', next({ href: '' }), /one that was read before/],
    ['a page by POST', (base) => next({ href: base, method: 'POST' })(), /with POST; allowed: GET/],
  ];
  for (const [name, reply, message] of cases) {
    await t.test(name, async (t) => {
      const server = await serve(t, (_request, response) => sendJson(response, reply(server.base)));
      await refused(makeCatalogue(t, stacSource(server.base)), kRegion, message);
    });
  }
});

test('the limits of pages, items and bytes end a listing', async (t) => {
  const server = await serve(t, (_request, response, index) =>
    sendJson(response, {
      features: [item(server.base, 2019, 462, 101, 'las.zip')],
      links: [{ rel: 'next', href: `${server.base}/items?page=${index}` }],
    }),
  );
  await refused(
    makeCatalogue(t, stacSource(server.base), { limits: { pages: 7 } }),
    kRegion,
    /more than 7 pages/,
  );
  assert.equal(server.seen.length, 7);
  const long = await serve(t, (_request, response) =>
    response.end(`{"features": [], "x": "${'y'.repeat(5000)}"}`),
  );
  const short = makeCatalogue(t, stacSource(long.base), { limits: { reply_bytes: 1000 } });
  await refused(short, kRegion, /more than 1000 bytes/);
  const empty = await serve(t, (_request, response, index) =>
    sendJson(response, {
      features: [],
      links: [{ rel: 'next', href: `${empty.base}/items?page=${index}` }],
    }),
  );
  await refused(makeCatalogue(t, stacSource(empty.base)), kRegion, /4 pages without items/);
  assert.equal(empty.seen.length, 4);
  const many = await portal(t, (base) =>
    [1, 2, 3, 4, 5].map((north) => item(base, 2019, 462, 100 + north, 'las.zip')),
  );
  await refused(
    makeCatalogue(t, stacSource(many.base), { limits: { items: 3 } }),
    kRegion,
    /more than 3 items/,
  );
});

test('a request to a busy portal is retried, a broken portal is an error', async (t) => {
  const busy = await serve(t, (_request, response, index) => {
    if (index < 2) response.writeHead(index === 0 ? 503 : 429, { 'retry-after': '1' }).end();
    else sendJson(response, { features: [item(busy.base, 2019, 462, 101, 'las.zip')] });
  });
  assert.equal((await listed(t, busy)).length, 1);
  for (const [status, requests] of [
    [500, 3],
    [404, 1],
  ] as const) {
    const broken = await serve(t, (_request, response) => void response.writeHead(status).end());
    await refused(
      makeCatalogue(t, stacSource(broken.base)),
      kRegion,
      new RegExp(`HTTP ${status}; allowed: 200`),
    );
    assert.equal(broken.seen.length, requests);
  }
  await refused(makeCatalogue(t, stacSource(kNoListener)), kRegion, /ECONNREFUSED/);
});

test('too long a Retry-After of a portal is an error, and retries are shown', async (t) => {
  const server = await serve(
    t,
    (_request, response, index) =>
      void response.writeHead(503, { 'retry-after': index === 0 ? '30' : '3600' }).end(),
  );
  const clock = fakeClock();
  const countLeftOut: string[] = [];
  const catalogue = makeCatalogue(t, stacSource(server.base), {
    clock,
    onRetry: ({ retry, wait_ms, error }) => countLeftOut.push(`${retry} ${wait_ms} ${error.code}`),
  });
  await assert.rejects(found(catalogue, kRegion), {
    code: 'RETRY_AFTER_TOO_LONG',
    message: /HTTP 503.*3600 s; allowed: at most 60 s/,
  });
  assert.deepEqual(countLeftOut, ['1 30000 CATALOGUE']);
  assert.deepEqual(clock.slept_ms, [30_000]);
});

test('a signed address is requested when its turn has come', async (t) => {
  const server = await serve(t, (request, response) => {
    const url = new URL(request.url ?? '', server.base);
    const one = {
      ...item(server.base, 2019, 462, 101, 'copc.laz'),
      id: 'USGS_LPC_OR_X_2018_w2133',
    };
    if (url.pathname.startsWith('/items/')) assert.equal(url.pathname, `/items/${one.id}`);
    if (url.pathname === '/sign') {
      return sendJson(response, { href: `${url.searchParams.get('href')}?sig=abc` });
    }
    sendJson(response, url.pathname === '/items' ? { features: [one] } : one);
  });
  const source = sourceWith(
    `
[access]
kind = "stac"
items = "${server.base}/items"
sign = "${server.base}/sign?href={href}"
[[access.assets]]
href = '\\.copc\\.laz$'
`,
    'crs_in_files = true',
  );
  const catalogue = makeCatalogue(t, source);
  const [square] = await found(catalogue, kRegion);
  assert.ok(square);
  assert.equal(square.name, 'USGS_LPC_OR_X_2018_w2133');
  assert.deepEqual(square.urls, []);
  const nowhere = (): Promise<boolean> => Promise.resolve(false);
  const located = await catalogue.locate?.(square, [], nowhere, kNever);
  assert.match(located?.urls[0] ?? '', /_5728\.copc\.laz\?sig=abc$/);
});

test('an item whose id is no file name is refused where files are named by it', async (t) => {
  const server = await serve(t, (_request, response) =>
    sendJson(response, {
      features: [{ ...item(server.base, 2019, 462, 101, 'las.zip'), id: '../x' }],
    }),
  );
  await refused(
    makeCatalogue(t, { ...nameless(server.base), square_m: undefined } as Source),
    kRegion,
    /item \.\.\/x: its id is no file name/,
  );
});

test('a stop is passed on', async (t) => {
  const stop = new AbortController();
  const server = await serve(t, () => stop.abort(new Error('stopped')));
  await assert.rejects(found(makeCatalogue(t, stacSource(server.base)), kRegion, stop.signal), {
    message: 'stopped',
  });
});

test('an unreadable item is reported and left out, and the rest is listed', async (t) => {
  const good = (base: string, north: number): Item => item(base, 2019, 462, north, 'las.zip');
  const bad: [name: string, change: (one: Item) => unknown, message: RegExp][] = [
    ['no assets of ours', (one) => ({ ...one, assets: {} }), /item swiss\S+: assets none/],
    ['another name', (one) => ({ ...one, id: 'other' }), /item other: its name does not give/],
    ['no properties', (one) => ({ ...one, properties: 1 }), /item swiss\S+: properties has/],
    ['no id', (one) => ({ ...one, id: 7 }), /item without an id: id has/],
    ['no object', () => null, /item without an id: it has/],
    ['a file elsewhere', elsewhere, /evil\.example\.org/],
  ];
  for (const [name, change, message] of bad) {
    await t.test(name, async (t) => {
      const server = await portal(t, (base) => [
        good(base, 101),
        change(good(base, 102)) as Item,
        good(base, 102),
      ]);
      const reported: string[] = [];
      const onLeftOut = (error: Error): void => void reported.push(error.message);
      const catalogue = makeCatalogue(t, stacSource(server.base), { onLeftOut });
      assert.deepEqual(await foundNames(catalogue, kRegion), ['462_101', '462_102']);
      assert.equal(reported.length, 1);
      assert.match(reported[0] ?? '', message);
    });
  }
});

test('a catalogue without one readable item is an error', async (t) => {
  for (const count of [1, 102]) {
    const server = await portal(t, (base) =>
      Array.from({ length: count }, (_unused, index) => ({
        ...item(base, 2019, 462, 101, 'las.zip'),
        id: `other${index}`,
      })),
    );
    let reported = 0;
    const onLeftOut = (): void => {
      reported += 1;
    };
    const catalogue = makeCatalogue(t, stacSource(server.base), { onLeftOut });
    await refused(catalogue, kRegion, /item other0: its name does not give a square/);
    assert.equal(reported, Math.min(count, 100));
  }
});

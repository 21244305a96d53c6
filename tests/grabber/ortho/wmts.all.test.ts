import assert from 'node:assert/strict';
import { test, type TestContext } from 'node:test';
import { parseCapabilities, chooseMatrix, tilesIn } from '../../../grabber/src/ortho/wmts.js';
import { wmtsHandler, type WmtsOptions } from '../portal/wmts.js';
import { serve, type HttpFixture } from '../support/http-fixture.js';
import {
  bench,
  kCrs,
  orthoSource,
  readOrthophoto,
  wrongPixels,
} from '../support/ortho-workshop.js';

// The corner lies off the square's grid by whole pixels, so that tiles and square share pixels but
// no edges.
const kServer: WmtsOptions = {
  layer: 'dof',
  crs: kCrs,
  left_m: 461_913.5,
  top_m: 101_207,
  tile_px: 64,
  resolutions_m: [2, 1, 0.5],
  tiles: 12,
  rest: true,
};

async function tileServer(t: TestContext, options: WmtsOptions): Promise<HttpFixture> {
  const handler = wmtsHandler(options);
  return serve(t, (request, response) => void handler(request, response));
}

function wmtsSource(
  base: string,
  more: Record<string, unknown> = {},
): ReturnType<typeof orthoSource> {
  return orthoSource({
    kind: 'wmts',
    url: `${base}/wmts?SERVICE=WMTS&REQUEST=GetCapabilities`,
    layer: 'dof',
    matrix_set: 'set',
    format: 'image/png',
    ...more,
  });
}

test('joined tiles equal the truth in each pixel, by address and by parameters', async (t) => {
  for (const [rest, northingFirst] of [
    [true, false],
    [false, false],
    [true, true],
  ] as const) {
    await t.test(
      `${rest ? 'address' : 'parameters'}, ${northingFirst ? 'northing' : 'easting'} first`,
      async (t) => {
        const server = await tileServer(t, { ...kServer, rest, northingFirst });
        const at = await bench(t, wmtsSource(server.base, { axis: northingFirst ? 'ne' : 'en' }));
        assert.equal((await at.make()).state, 'made');
        const picture = await readOrthophoto(at);
        assert.deepEqual(wrongPixels(picture), { count: 0, first: '' });
      },
    );
  }
});

test('matrices that stand in the configuration need no capabilities', async (t) => {
  const server = await tileServer(t, kServer);
  const size = { tile_px: 64, columns: 12, rows: 12 };
  const matrices = [{ id: 'm2', resolution_m: 0.5, left_m: 461_913.5, top_m: 101_207, ...size }];
  const url = `${server.base}/wmts/{matrix_set}/{style}/{matrix}/{row}/{column}.png`;
  const at = await bench(t, wmtsSource(server.base, { url, matrices }));
  await at.make();
  const picture = await readOrthophoto(at);
  assert.deepEqual(wrongPixels(picture), { count: 0, first: '' });
  assert.ok(server.seen.every(({ path }) => !path.includes('GetCapabilities')));
});

test('tiles that are not square are joined all the same', async (t) => {
  for (const tile_height_px of [48, 96]) {
    const server = await tileServer(t, { ...kServer, tile_height_px, tiles: 16 });
    const at = await bench(t, wmtsSource(server.base));
    assert.equal((await at.make()).state, 'made');
    const picture = await readOrthophoto(at);
    assert.deepEqual(
      wrongPixels(picture),
      { count: 0, first: '' },
      `${tile_height_px} pixels high`,
    );
  }
});

test('a missing tile is masked, with a warning, and a grey tile stays grey', async (t) => {
  const server = await tileServer(t, {
    ...kServer,
    missing: new Set(['m2/5/4']),
    grey: new Set(['m2/6/4']),
  });
  const at = await bench(t, wmtsSource(server.base));
  const made = await at.make();
  assert.ok(made.state === 'made');
  assert.match(made.warnings.join(), /1 of \d+ tiles of here are missing/);
  const picture = await readOrthophoto(at);
  assert.deepEqual(picture.info.bands[0]?.mask?.flags, ['PER_DATASET']);
  const west = 461_913.5 + 4 * 32;
  const column = (easting: number): boolean => easting > west && easting < west + 32;
  const north = 101_207 - 5 * 32;
  const skip = (easting: number, northing: number): boolean =>
    column(easting) && northing < north && northing > north - 64;
  assert.deepEqual(wrongPixels(picture, skip), { count: 0, first: '' });
  const at_px = (easting: number, northing: number): number[] =>
    picture.at((easting - 461_980) / 0.5, (101_120 - northing) / 0.5);
  assert.deepEqual(at_px(west + 10, north - 40), [128, 128, 128]);
  assert.deepEqual(at_px(west + 10, north - 10), [0, 0, 0]);
});

test('no tile at all is a square that the source does not have', async (t) => {
  const server = await tileServer(t, { ...kServer, left_m: 0 });
  const at = await bench(t, wmtsSource(server.base));
  assert.equal((await at.make()).state, 'missing');
  assert.equal(at.row().state, 'missing');
});

const kMatrix = {
  id: 'm',
  resolution_m: 1,
  left_m: 0,
  top_m: 1000,
  tile_px: 100,
  columns: 10,
  rows: 10,
};

test('the coarsest matrix that is fine enough is taken', () => {
  const matrices = [2, 1, 0.5].map((resolution_m, index) => ({
    ...kMatrix,
    id: `m${index}`,
    resolution_m,
  }));
  for (const [wanted, id] of [
    [4, 'm0'],
    [2, 'm0'],
    [1.9, 'm1'],
    [0.995, 'm1'],
    [0.5, 'm2'],
    [0.1, 'm2'],
  ] as const) {
    assert.equal(chooseMatrix(matrices, wanted)?.id, id, String(wanted));
  }
});

test('tiles stay within their matrix', () => {
  assert.deepEqual(tilesIn(kMatrix, [150, 650, 250, 750]), {
    column: 1,
    row: 2,
    columns: 2,
    rows: 2,
  });
  assert.deepEqual(tilesIn(kMatrix, [-500, 900, 50, 5000]), {
    column: 0,
    row: 0,
    columns: 1,
    rows: 2,
  });
  assert.equal(tilesIn(kMatrix, [2000, 0, 3000, 100]), undefined);
  assert.equal(tilesIn(kMatrix, [-300, 0, -200, 100]), undefined);
});

test('capabilities that are not those of the layer are refused with what there is', async (t) => {
  const server = await tileServer(t, kServer);
  const xml = await (await fetch(`${server.base}/wmts?REQUEST=GetCapabilities`)).text();
  const wanted = { layer: 'dof', matrixSet: 'set', format: 'image/png', axis: 'en' } as const;
  assert.equal(parseCapabilities(xml, 'http://x', wanted).matrices.length, 3);
  const cases: {
    xml: string;
    change: Partial<typeof wanted> | { layer: string } | { matrixSet: string };
    message: RegExp;
  }[] = [
    { xml, change: { layer: 'none' }, message: /no layer "none"; allowed: dof/ },
    { xml, change: { matrixSet: 'none' }, message: /no matrix set "none"; allowed: set/ },
    {
      xml: xml.replace('EPSG::3794', 'EPSG::4326'),
      change: {},
      message: /allowed: an EPSG system in metres/,
    },
    { xml: '<html><body>Sorry</body></html>', change: {}, message: /no capabilities of WMTS 1.0/ },
    { xml: `<!DOCTYPE a [<!ENTITY b "c">]>${xml}`, change: {}, message: /document type/ },
    { xml: xml.slice(0, 300), change: {}, message: /tile service http:\/\/x/ },
  ];
  for (const { xml, change, message } of cases) {
    assert.throws(() => parseCapabilities(xml, 'http://x', { ...wanted, ...change }), message);
  }
});

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { getMapUrl } from '../../../grabber/src/ortho/wms.js';
import { wmsHandler, type WmsOptions } from '../portal/wms.js';
import { sendFile, serve } from '../support/http-fixture.js';
import {
  bench,
  kCrs,
  orthoSource,
  readOrthophoto,
  wrongPixels,
} from '../support/ortho-workshop.js';
import { storedFiles } from '../support/store-fixture.js';

const kServer: WmsOptions = { layer: 'dof', crs: [kCrs], mostPixels: 100 };

function wmsSource(
  base: string,
  more: Record<string, unknown> = {},
  top: Record<string, unknown> = {},
): ReturnType<typeof orthoSource> {
  return orthoSource(
    { kind: 'wms', url: `${base}/wms`, layer: 'dof', max_pixels: 100, ...more },
    top,
  );
}

test('a square from several pictures equals the truth in either version', async (t) => {
  for (const [version, northing_first] of [
    ['1.1.1', []],
    ['1.3.0', [kCrs]],
  ] as const) {
    await t.test(version, async (t) => {
      const handler = wmsHandler({ ...kServer, northingFirst: northing_first });
      const server = await serve(t, (request, response) => void handler(request, response));
      const at = await bench(t, wmsSource(server.base, { version, northing_first }));
      assert.equal((await at.make()).state, 'made');
      const row = at.row();
      assert.deepEqual(await storedFiles(at.store.root), [row.file?.path]);
      const picture = await readOrthophoto(at);
      assert.deepEqual(picture.bounds, [461_980, 100_980, 462_120, 101_120]);
      assert.deepEqual([picture.width, picture.height], [280, 280]);
      assert.deepEqual(wrongPixels(picture), { count: 0, first: '' });
      assert.equal(server.seen.length, 9);
      assert.match(picture.info.coordinateSystem.wkt, /3794\]\]$/);
      assert.deepEqual([row.state, row.licence], ['verified', 'CC BY 4.0']);
      const image = { width_px: 280, height_px: 280, resolution_m: 0.5, margin_m: 20 };
      assert.deepEqual(row.image, image);
    });
  }
});

test('JPEG in a tiled GeoTIFF with overviews is near the truth', async (t) => {
  const handler = wmsHandler({ ...kServer, mostPixels: 2000 });
  const server = await serve(t, (request, response) => void handler(request, response));
  const at = await bench(
    t,
    wmsSource(server.base, { max_pixels: 2000 }),
    [462_000, 101_000, 462_300, 101_300],
  );
  await at.make({ cut: { lossless: false, nearInfrared: false } });
  const picture = await readOrthophoto(at);
  assert.equal(picture.info.metadata['IMAGE_STRUCTURE']?.['COMPRESSION'], 'YCbCr JPEG');
  assert.deepEqual(picture.info.bands[0]?.block, [256, 256]);
  assert.deepEqual(
    picture.info.bands[0]?.overviews?.map((one) => one.size),
    [
      [340, 340],
      [170, 170],
    ],
  );
  // Neighbours differ by one in red and green: only the blue band and steps at 256 are hard for
  // JPEG.
  let off = 0;
  for (let x = 100; x < 120; ++x) {
    off = Math.max(
      off,
      Math.abs((picture.at(x, 50)[0] ?? 0) - ((Math.floor(461_980 / 0.5) + x) & 255)),
    );
  }
  assert.ok(off <= 12, `red is off by ${off}`);
});

test('a refusal with status 200 is reported in its words, and nothing is made', async (t) => {
  const handler = wmsHandler({ ...kServer, refuse: 'Layer is   resting' });
  const server = await serve(t, (request, response) => void handler(request, response));
  const at = await bench(t, wmsSource(server.base));
  await assert.rejects(at.make(), /the server says "Wrong: Layer is resting"/);
  assert.deepEqual(await storedFiles(at.store.root), []);
});

test('what is sent instead of a picture is refused before GDAL sees it', async (t) => {
  const vrt =
    '<VRTDataset rasterXSize="100" rasterYSize="100"><VRTRasterBand dataType="Byte" band="1">' +
    '<SimpleSource><SourceFilename>/etc/passwd</SourceFilename></SimpleSource>' +
    '</VRTRasterBand></VRTDataset>';
  const cases: [name: string, body: Buffer, message: RegExp][] = [
    ['a VRT', Buffer.from(vrt), /starts with "<VRTDataset/],
    ['nothing', Buffer.alloc(0), /starts with nothing \(0 bytes\)/],
    ['a PNG cut short', Buffer.from('89504e470d0a1a0a0000', 'hex'), /cut short or damaged/],
    ['a JPEG of nothing', Buffer.from('ffd8ffe000104a46', 'hex'), /cut short or damaged/],
    ['a TIFF of nothing', Buffer.from('49492a0008000000ffff', 'hex'), /gdalinfo ended/],
  ];
  for (const [name, body, message] of cases) {
    await t.test(name, async (t) => {
      const server = await serve(t, (_request, response) =>
        sendFile(response, body, { 'content-type': 'image/png' }),
      );
      const at = await bench(t, wmsSource(server.base));
      await assert.rejects(at.make(), message);
      assert.deepEqual(await storedFiles(at.store.root), []);
    });
  }
});

test('a picture of another size is refused', async (t) => {
  const handler = wmsHandler({ ...kServer, mostPixels: 500 });
  const server = await serve(t, (request, response) => {
    request.url = (request.url ?? '').replace(/WIDTH=\d+/, 'WIDTH=50');
    handler(request, response);
  });
  const at = await bench(t, wmsSource(server.base));
  await assert.rejects(at.make(), /50 x \d+ pixels; allowed: \d+ x \d+, as requested/);
});

test('a square in a foreign CRS gets a picture in its own CRS', async (t) => {
  // 3794 and 3912 differ by a datum; the square is requested in 3794 and turned into UTM 33.
  const handler = wmsHandler({ ...kServer, mostPixels: 2000 });
  const server = await serve(t, (request, response) => void handler(request, response));
  const at = await bench(
    t,
    wmsSource(server.base, { max_pixels: 2000 }),
    [462_000, 5_100_000, 462_100, 5_100_100],
    'EPSG:32633',
  );
  const made = await at.make({ resolution_m: 1 });
  assert.equal(made.state, 'made');
  const picture = await readOrthophoto(at);
  assert.deepEqual(picture.bounds, [461_980, 5_099_980, 462_120, 5_100_120]);
  assert.match(picture.info.coordinateSystem.wkt, /32633\]\]$/);
});

test('addresses carry time, style and order of axes', () => {
  const { access } = wmsSource('http://x', { northing_first: ['EPSG:4326'] });
  assert.equal(access.kind, 'wms');
  if (access.kind !== 'wms') return;
  const url = new URL(
    getMapUrl(access, 'EPSG:4326', [14, 46, 14.5, 46.25], { width_px: 10, height_px: 5 }, '2021'),
  );
  assert.equal(url.searchParams.get('BBOX'), '46,14,46.25,14.5');
  assert.equal(url.searchParams.get('CRS'), 'EPSG:4326');
  assert.equal(url.searchParams.get('TIME'), '2021');
  const old = new URL(
    getMapUrl(
      { ...access, version: '1.1.1' },
      'EPSG:4326',
      [14, 46, 14.5, 46.25],
      { width_px: 10, height_px: 5 },
      undefined,
    ),
  );
  assert.equal(old.searchParams.get('BBOX'), '14,46,14.5,46.25');
  assert.equal(old.searchParams.get('SRS'), 'EPSG:4326');
  assert.equal(old.searchParams.has('TIME'), false);
});

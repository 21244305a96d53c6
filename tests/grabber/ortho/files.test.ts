import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { readFile, truncate, writeFile } from 'node:fs/promises';
import { statSync } from 'node:fs';
import { join } from 'node:path';
import { test, type TestContext } from 'node:test';
import { promisify } from 'node:util';
import { DiskSpace, kReserve_bytes } from '../../../grabber/src/fetch/disk-space.js';
import { HostRateLimiter } from '../../../grabber/src/fetch/host-queues.js';
import { downloader, type Downloader } from '../../../grabber/src/ortho/download.js';
import { openGdal } from '../../../grabber/src/ortho/gdal.js';
import { localGather } from '../../../grabber/src/ortho/local.js';
import { probeImage } from '../../../grabber/src/ortho/piece.js';
import { squareUrl } from '../../../grabber/src/ortho/template.js';
import { drawPattern, encodePng } from '../portal/pattern.js';
import { fakeClock, kNever, storedFiles, temporaryFolder } from '../support/store-fixture.js';
import { sendFile, sendStatus, serve } from '../support/http-fixture.js';
import {
  bench,
  kCrs,
  orthoSource,
  readOrthophoto,
  wrongPixels,
  type Bench,
} from '../support/ortho-workshop.js';
import { clientFor } from '../support/catalogue-fixture.js';

const run = promisify(execFile);

/** A picture of the pattern with a world file. */
async function writePng(
  path: string,
  bounds: readonly [number, number, number, number],
  step = 0.5,
): Promise<void> {
  const [width, height] = [(bounds[2] - bounds[0]) / step, (bounds[3] - bounds[1]) / step];
  await writeFile(path, encodePng(drawPattern(bounds, width, height), width, height));
  await writeFile(
    path.replace(/png$/, 'pgw'),
    [step, 0, 0, -step, bounds[0] + step / 2, bounds[3] - step / 2].join('\n'),
  );
}

async function geoTiff(
  folder: string,
  name: string,
  bounds: readonly [number, number, number, number],
  crs = kCrs,
): Promise<string> {
  const png = join(folder, `${name}.png`);
  await writePng(png, bounds);
  const tif = join(folder, `${name}.tif`);
  await run('gdal_translate', ['-q', '-a_srs', crs, png, tif]);
  return tif;
}

async function local(t: TestContext, from: string): Promise<Bench> {
  return bench(
    t,
    orthoSource({ kind: 'wms', url: 'http://x/', layer: 'x' }),
    undefined,
    undefined,
    localGather(from, null),
  );
}

test('pictures of a folder are joined and cut: PNG with a world file, and GeoTIFF', async (t) => {
  const folder = await temporaryFolder(t);
  await writePng(join(folder, 'west.png'), [461_900, 100_900, 462_050, 101_200]);
  const other = await temporaryFolder(t);
  await run('cp', [
    await geoTiff(other, 'east', [462_050, 100_900, 462_200, 101_200]),
    join(folder, 'EAST.TIF'),
  ]);
  const at = await local(t, folder);
  assert.equal((await at.make()).state, 'made');
  assert.deepEqual(wrongPixels(await readOrthophoto(at)), { count: 0, first: '' });
});

test('a folder whose pictures lie elsewhere has none for the square', async (t) => {
  const folder = await temporaryFolder(t);
  await writePng(join(folder, 'far.png'), [461_000, 100_000, 461_010, 100_010]);
  const at = await local(t, folder);
  assert.equal((await at.make()).state, 'missing');
});

test('part of a square is covered: the rest is under the mask', async (t) => {
  const folder = await temporaryFolder(t);
  await writePng(join(folder, 'part.png'), [462_000, 101_000, 462_060, 101_060]);
  const at = await local(t, folder);
  await at.make();
  const picture = await readOrthophoto(at);
  assert.deepEqual(picture.info.bands[0]?.mask?.flags, ['PER_DATASET']);
  const skip = (e: number, n: number): boolean =>
    e < 462_000 || e > 462_060 || n < 101_000 || n > 101_060;
  assert.deepEqual(wrongPixels(picture, skip), { count: 0, first: '' });
});

test('a picture of one value is kept, and called empty', async (t) => {
  const folder = await temporaryFolder(t);
  await writePng(join(folder, 'a.png'), [461_900, 100_900, 462_200, 101_200]);
  await writeFile(join(folder, 'a.png'), encodePng(Buffer.alloc(600 * 600 * 3, 255), 600, 600));
  const at = await local(t, folder);
  const made = await at.make();
  assert.match(
    made.state === 'made' ? made.warnings.join() : '',
    /empty: every pixel has the value 255 255 255/,
  );
});

test('pictures without a place, rotated ones and other files are refused by name', async (t) => {
  const folder = await temporaryFolder(t);
  const path = join(folder, 'a.png');
  const at = await local(t, path);
  await writePng(path, [461_900, 100_900, 462_200, 101_200]);
  await writeFile(path.replace('png', 'pgw'), '0.5\n0.1\n0.1\n-0.5\n461900\n101200\n');
  await assert.rejects(at.make(), /a\.png: it is rotated, or not georeferenced/);
  const vrt = join(folder, 'b.tif');
  await writeFile(vrt, '<VRTDataset rasterXSize="1" rasterYSize="1"/>');
  await assert.rejects((await local(t, vrt)).make(), /b\.tif: it starts with "<VRTDataset/);
  await assert.rejects((await local(t, join(folder, 'none'))).make(), /read --from .*none/);
  assert.deepEqual(await storedFiles(at.store.root), []);
});

test('a catalogue gives the newest file of each place, and each is fetched once', async (t) => {
  const folder = await temporaryFolder(t);
  const files: Record<string, string> = {
    'west_2019.tif': await geoTiff(folder, 'old', [461_900, 100_900, 461_950, 101_200]),
    'west_2023.tif': await geoTiff(folder, 'west', [461_900, 100_900, 462_050, 101_200]),
    'east_2023.tif': await geoTiff(folder, 'east', [462_050, 100_900, 462_200, 101_200]),
  };
  const item = (place: number, year: number, name: string): unknown => ({
    id: name,
    bbox: [place, 46, place + 1, 47],
    properties: { datetime: `${year}-06-01T00:00:00Z` },
    assets: { big: { href: `/files/${name}.tif` }, small: { href: `/files/${name}_small.tif` } },
  });
  const server = await serve(t, (request, response) => {
    const url = new URL(request.url ?? '', 'http://x');
    const name = url.pathname.slice('/files/'.length);
    if (url.pathname !== '/items') {
      return void readFile(files[name] ?? '').then(
        (body) => sendFile(response, body),
        () => sendStatus(response, 404),
      );
    }
    const second = url.searchParams.has('page');
    const links = second ? [] : [{ rel: 'next', href: `/items?page=2` }];
    const features = second
      ? [item(2, 2023, 'east_2023')]
      : [item(1, 2023, 'west_2023'), item(1, 2019, 'west_2019')];
    sendFile(response, Buffer.from(JSON.stringify({ type: 'FeatureCollection', features, links })));
  });
  const source = orthoSource({
    kind: 'stac',
    url: `${server.base}/items`,
    asset: '_20\\d\\d\\.tif$',
  });
  const at = await bench(t, source);
  assert.equal((await at.make()).state, 'made');
  assert.deepEqual(wrongPixels(await readOrthophoto(at)), { count: 0, first: '' });
  await at.make();
  const fetched = server.seen
    .map(({ path }) => path)
    .filter((path) => path.startsWith('/files/'))
    .sort();
  assert.deepEqual(fetched, ['/files/east_2023.tif', '/files/west_2023.tif']);
  const box =
    new URL(server.seen[0]?.path ?? '', 'http://x').searchParams
      .get('bbox')
      ?.split(',')
      .map(Number) ?? [];
  assert.ok(
    (box[0] ?? 0) > 14.4 && (box[2] ?? 0) < 14.6 && (box[1] ?? 0) > 46 && (box[3] ?? 0) < 46.1,
    box.join(),
  );
  assert.match(
    (await readOrthophoto(at)).info.metadata['']?.['TIFFTAG_DATETIME'] ?? '',
    /^2023:06:01/,
  );
  assert.equal((await at.make({ time: '1999' })).state, 'missing');
});

test('a malformed reply of a catalogue is an error, never a missing picture', async (t) => {
  for (const body of [
    '{}',
    'oops',
    '{"features":[],"links":[{"rel":"next","href":"/items","method":"POST"}]}',
  ]) {
    const server = await serve(t, (_request, response) => sendFile(response, Buffer.from(body)));
    const at = await bench(
      t,
      orthoSource({ kind: 'stac', url: `${server.base}/items`, asset: 'tif$' }),
    );
    await assert.rejects(at.make(), /list pictures at /);
  }
});

test('a picture is placed by its square, with its neighbours for the margin', async (t) => {
  const server = await serve(t, (request, response) => {
    const match = /^\/(\d+)_(\d+)\.png$/.exec(request.url ?? '');
    if (match === null) return sendStatus(response, 404);
    const [x, y] = [Number(match[1]), Number(match[2])];
    sendFile(response, encodePng(drawPattern([x, y, x + 100, y + 100], 200, 200), 200, 200));
  });
  const at = await bench(
    t,
    orthoSource({ kind: 'template', url: `${server.base}/{x}_{y:06}.png`, square_m: 100 }),
  );
  await at.make();
  assert.deepEqual(wrongPixels(await readOrthophoto(at)), { count: 0, first: '' });
  assert.equal(server.seen.length, 9);
});

test('placeholders of addresses', () => {
  assert.equal(
    squareUrl('{E}_{N}/{x:07}/{y}/{name}', [462_000, 101_000], 1000),
    '462_101/0462000/101000/462_101',
  );
  assert.throws(() => squareUrl('{block}', [0, 0], 1000), /\{block\}; allowed: \{E\}/);
});

test('a picture larger than any memory is checked by its first bytes', async (t) => {
  const folder = await temporaryFolder(t);
  const gdal = await openGdal(folder, kNever);
  const tif = await geoTiff(folder, 'long', [462_000, 101_000, 462_010, 101_020]);
  for (const path of [tif, join(folder, 'long.png')]) {
    await truncate(path, 3 * 2 ** 30);
    const { width_px, height_px, channels } = await probeImage(path, path, gdal, kNever);
    assert.deepEqual([width_px, height_px, channels], [20, 40, 'rgb'], path);
  }
});

function makeDownloader(t: TestContext, disk: DiskSpace): Downloader {
  const http = clientFor(t);
  return downloader({
    http,
    policy: { retries: 0, base_ms: 1, cap_ms: 1, max_wait_ms: 60_000 },
    clock: fakeClock(),
    limiter: new HostRateLimiter(fakeClock(), 1000),
    disk,
    missingStatus: [],
    onRetry: () => undefined,
  });
}

test('a picture that would fill the disk is refused before it is fetched', async (t) => {
  const server = await serve(t, (_request, response) => sendFile(response, Buffer.alloc(2000)));
  const folder = await temporaryFolder(t);
  const fetchInto = (free_bytes: number): Promise<boolean> =>
    makeDownloader(t, new DiskSpace(folder, () => free_bytes)).toFile(
      `${server.base}/a.tif`,
      join(folder, 'a.tif'),
      10_000,
      kNever,
    );
  await assert.rejects(fetchInto(kReserve_bytes + 1999), {
    code: 'DISK_FULL',
    message: /it needs 2000 bytes/,
  });
  assert.deepEqual([await storedFiles(folder), server.seen.length], [[], 1]);
  assert.equal(await fetchInto(kReserve_bytes + 2000), true);
});

test('a picture of unknown length stops when it would fill the disk', async (t) => {
  const server = await serve(t, (_request, response) => {
    response.writeHead(200);
    const more = (): void => {
      if (!response.destroyed && response.write(Buffer.alloc(1 << 20))) setImmediate(more);
      else response.once('drain', more);
    };
    more();
  });
  const folder = await temporaryFolder(t);
  const free_bytes = 60 << 20;
  const disk = new DiskSpace(
    folder,
    (): number =>
      kReserve_bytes +
      free_bytes -
      (statSync(join(folder, 'a.tif'), { throwIfNoEntry: false })?.size ?? 0),
  );
  await assert.rejects(
    makeDownloader(t, disk).toFile(`${server.base}/a.tif`, join(folder, 'a.tif'), 2 ** 40, kNever),
    { code: 'DISK_FULL' },
  );
  assert.ok(statSync(join(folder, 'a.tif')).size <= free_bytes);
});

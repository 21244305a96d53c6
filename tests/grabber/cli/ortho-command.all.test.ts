import assert from 'node:assert/strict';
import { mkdir, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test, type TestContext } from 'node:test';
import { openStore } from '../../../grabber/src/store/open-store.js';
import { wmsHandler } from '../portal/wms.js';
import { cli, words, type CliResult, sourceHere, templateAccess, script } from '../support/cli.js';
import { sendFile, sendStatus, serve, type HttpFixture } from '../support/http-fixture.js';
import { makeKeys, makeLas, makeLaz } from '../support/las-fixture.js';
import { readPicture, wrongPixels } from '../support/ortho-workshop.js';
import {
  bringIn,
  catalogueSquare,
  kTerms,
  kVerified,
  keyOfSquare,
} from '../support/record-fixture.js';
import { kNever, storedFiles, temporaryFolder } from '../support/store-fixture.js';

const kKey = keyOfSquare('462_101');

/** A store with one square of 100 m, whose file is checked unless it awaits conversion. */
async function storeWith(t: TestContext, bytes: Buffer, extension = 'laz'): Promise<string> {
  const store = openStore(await temporaryFolder(t), {}, kNever);
  const bounds = [462_000, 101_000, 462_100, 101_100] as const;
  store.squares.learn('si-lss', 'si-lss', 'EPSG:3794', kTerms, [
    catalogueSquare(462, 101, { bounds }),
  ]);
  await bringIn(store, kKey, bytes, extension);
  if (extension !== 'zlas') store.squares.verified(kKey, { ...kVerified, points: null });
  store.close();
  return store.root;
}

async function configWith(t: TestContext, base: string, more = ''): Promise<string> {
  const config = await temporaryFolder(t);
  await mkdir(join(config, 'sources', 'ortho'), { recursive: true });
  const head =
    'id = "here"\ntitle = "Here"\nlicence = "CC BY 4.0"\nattribution = "Us"\ncrs = ' +
    '"EPSG:3794"\nresolution_m = 0.5\nallow_private_addresses = true\n';
  await writeFile(
    join(config, 'sources', 'ortho', 'here.toml'),
    `${head}${more}[access]\nkind = "wms"\nurl = "${base}/wms"\nlayer = "dof"\nmax_pixels = 100\n`,
  );
  return config;
}

/** A map server of the synthetic picture, and the configuration that names it. */
async function mapServer(
  t: TestContext,
  mostPixels = 100,
): Promise<{ server: HttpFixture; config: string }> {
  const handler = wmsHandler({ layer: 'dof', crs: ['EPSG:3794'], mostPixels });
  const server = await serve(t, (request, response) => void handler(request, response));
  return { server, config: await configWith(t, server.base) };
}

const command = (config: string, args: readonly string[]): Promise<CliResult> =>
  cli(['--config', config, ...args]);

test('ortho makes the picture of each square once', async (t) => {
  const { server, config } = await mapServer(t);
  const root = await storeWith(t, makeLaz());
  const args = words`ortho --store ${root} --source here --lossless --margin-m 10`;
  const dry = await command(config, [...args, '--dry-run']);
  assert.equal(dry.out, '462_101\n0 made, 0 already there, 0 missing, 0 failed\n');
  assert.equal(server.seen.length, 0);
  const first = await command(config, args);
  assert.equal(first.err, '');
  assert.match(
    first.out,
    /made 462_101 .* 240 x 240 pixels {2}ortho\/here\/si-lss\/462_101\.tif\n1 made, 0 already/,
  );
  assert.deepEqual(
    wrongPixels(await readPicture(join(root, 'ortho/here/si-lss/462_101.tif'), root)),
    { count: 0, first: '' },
  );
  const requests = server.seen.length;
  assert.match((await command(config, args)).out, /0 made, 1 already there/);
  assert.equal(server.seen.length, requests);
  const other = [...args, ...words`--resolution-m 1`];
  assert.match((await command(config, other)).out, /120 x 120 pixels/);
  const later = [...other, ...words`--time 2023`];
  assert.match((await command(config, later)).out, /1 made, 0 already there/);
  assert.match((await command(config, later)).out, /0 made, 1 already there/);
  const json = await command(config, [...args, '--again', '--json']);
  assert.equal((JSON.parse(json.out.split('\n')[0] ?? '') as { state: string }).state, 'made');
});

test('squares that were taken from a folder get pictures of where their points are', async (t) => {
  const { config } = await mapServer(t);
  const folder = await temporaryFolder(t);
  const vlrs = [makeKeys([3072, 3794])];
  await writeFile(
    join(folder, 'a.laz'),
    makeLaz({ min: [462_000.2, 101_000.7, 0], max: [462_099.5, 101_099.5, 9], vlrs }),
  );
  await writeFile(join(folder, 'b.laz'), makeLaz());
  await writeFile(
    join(folder, 'c.laz'),
    makeLaz({ min: [14, 46, 0], max: [14.001, 46.001, 9], vlrs: [makeKeys([2048, 4326])] }),
  );
  const root = join(await temporaryFolder(t), 'store');
  assert.equal((await command(config, words`fetch --from ${folder} --store ${root}`)).code, 0);

  const args = ['ortho', '--store', root, '--margin-m', '10'];
  const made = await command(config, [...args, '--source', 'here', '--lossless']);
  assert.match(made.out, /made a .* 240 x 240 pixels {2}ortho\/here\/local\/a\.tif\n/);
  assert.match(made.err, /error: b ORTHO: .*its place or CRS is not known; allowed: .*--crs/);
  assert.match(made.err, /error: c CRS: use CRS EPSG:4326: not projected/);
  const picture = join(root, 'ortho/here/local/a.tif');
  assert.deepEqual(wrongPixels(await readPicture(picture, root)), { count: 0, first: '' });

  const terms = ['--licence', 'CC0', '--attribution', 'Me'];
  const copied = await command(config, [...args, '--squares', 'a', '--from', picture, ...terms]);
  assert.equal(copied.code, 0, copied.err);
  const store = openStore(root, { readOnly: true }, kNever);
  t.after(() => {
    store.close();
  });
  const { licence, attribution, crs } =
    store.orthophotos.get({ source: 'local', grid: 'local', name: 'a' }) ?? {};
  assert.deepEqual([licence, attribution, crs], ['CC0', 'Me', 'EPSG:3794']);
});

test('a picture stays in use while it is made again, also when that is cut off', async (t) => {
  const { config } = await mapServer(t, 4096);
  const root = await storeWith(t, makeLaz());
  const args = ['ortho', '--store', root, '--source', 'here'];
  assert.equal((await command(config, args)).code, 0);
  const store = openStore(root, {}, kNever);
  const key = { source: 'here', grid: 'si-lss', name: '462_101' };
  store.orthophotos.want([key], true);
  store.orthophotos.begin(key, 'http://x/');
  store.close();
  assert.match((await command(config, ['status', '--store', root])).out, /\nhere +verified +1 /);
  assert.match((await command(config, ['verify', '--store', root])).out, /^2 files checked, 0 bad/);
  assert.match(
    (await command(config, ['resume', '--store', root])).err,
    /1 orthophotos of here are unfinished/,
  );
  assert.match((await command(config, args)).out, /1 made, 0 already there/);
  assert.equal((await command(config, ['resume', '--store', root])).code, 0);
});

test('fetch brings squares and their orthophotos in one go', async (t) => {
  const pictures = wmsHandler({ layer: 'dof', crs: ['EPSG:3794'], mostPixels: 4096 });
  const laz = makeLaz({ min: [462_000, 101_000, 0], max: [463_000, 102_000, 1] });
  const server = await serve(t, (request, response) => {
    if (request.url === '/TM_462_101.laz') sendFile(response, laz);
    else if (request.url?.startsWith('/TM_') === true) sendStatus(response, 404);
    else void pictures(request, response);
  });
  const config = await configWith(t, server.base);
  await writeFile(
    join(config, 'sources', 'here.toml'),
    sourceHere(templateAccess(server.base), 404),
  );
  const root = join(await temporaryFolder(t), 'store');
  const args = ['fetch', '--source', 'here', '--squares', '462_101,463_101', '--store', root];

  const wrong = await command(config, [...args, '--ortho', 'nowhere']);
  assert.deepEqual([wrong.code, server.seen.length], [2, 0], wrong.err);
  const both = await command(config, [...args, '--ortho', 'here']);
  assert.equal(both.code, 3, both.err);
  assert.match(both.out, /made 462_101 .* 2080 x 2080 pixels/);
  assert.deepEqual(await storedFiles(root), [
    'lidar/here/462_101.laz',
    'ortho/here/here/462_101.tif',
  ]);
});

test('a failing server leaves the existing picture, and the exit code shows it', async (t) => {
  const options = { layer: 'dof', crs: ['EPSG:3794'], mostPixels: 100 };
  let refuse = false;
  const server = await serve(
    t,
    (request, response) =>
      void wmsHandler(refuse ? { ...options, refuse: 'closed' } : options)(request, response),
  );
  const config = await configWith(t, server.base);
  const root = await storeWith(t, makeLaz());
  const args = ['ortho', '--store', root, '--source', 'here'];
  await command(config, args);
  refuse = true;
  const failed = await command(config, [...args, '--again']);
  assert.equal(failed.code, 1);
  assert.match(failed.err, /error: 462_101 MAP_SERVICE: .*closed/);
  assert.ok((await storedFiles(root)).includes('ortho/here/si-lss/462_101.tif'));
});

test('wrong options are refused with what is allowed', async (t) => {
  const config = await configWith(t, 'http://127.0.0.1:9');
  const root = await storeWith(t, makeLaz());
  const cases: [line: string, message: RegExp][] = [
    ['', /neither --source nor --from is given; allowed: .*here/],
    ['--source none', /"none"; allowed: here/],
    ['--source here --from /x', /allowed: one of them/],
    ['--source here --licence CC0', /--licence with --source, which/],
    ['--source here --grid fr', /choose squares of .*: none/],
    ['--source here --squares 1_1', /none; allowed: squares that are fetched/],
    ['--source here --margin-m 5000', /a number from 0 to 1000, metres/],
    ['--source here --time now', /a year or a date/],
  ];
  for (const [line, message] of cases) {
    const ended = await cli(`--config ${config} ortho --store ${root} ${line}`.trim().split(' '));
    assert.equal(ended.code, 2, line);
    assert.match(ended.err, message);
  }
});

test('convert compresses LAS to LAZ, and reports what failed', async (t) => {
  const config = await temporaryFolder(t);
  await writeFile(join(config, 'small.laz'), makeLaz());
  const tool = await script(
    config,
    'laz',
    "const fs = require('fs'), [c, a, b] = process.argv.slice(2); if (c === 'compress') " +
      "fs.copyFileSync(require('path').join(__dirname, 'small.laz'), b);",
  );
  await writeFile(
    join(config, 'converters.toml'),
    `id = "converters"\n[laz]\nprogram = "${tool}"\n`,
  );
  const root = await storeWith(t, makeLas(), 'las');
  const done = await command(config, ['convert', '--store', root]);
  assert.deepEqual([done.code, done.err], [0, '']);
  assert.match(
    done.out,
    /462_101\.las to lidar.*462_101\.laz .*\n1 converted, 0 indexed, 0 failed/,
  );
  assert.match((await command(config, ['convert', '--store', root])).out, /^0 converted/);
  const zlas = await storeWith(t, Buffer.from('ZLAS'), 'zlas');
  const failed = await command(config, ['convert', '--store', zlas]);
  assert.equal(failed.code, 1);
  assert.match(failed.err, /error: si-lss\/462_101 NO_CONVERTER: convert .*462_101\.zlas/);
  const store = openStore(zlas, { readOnly: true }, kNever);
  t.after(() => store.close());
  const record = store.squares.get(kKey);
  assert.deepEqual(
    [record?.state, record?.lastError?.code],
    ['fetched', 'NO_CONVERTER'],
    'it is not to be fetched again',
  );
});

test('a secret that a map service sends back is in no message and no record', async (t) => {
  process.env['TERRAVOX_TEST_KEY'] = 'hush-hush-hush';
  t.after(() => delete process.env['TERRAVOX_TEST_KEY']);
  const server = await serve(t, (request, response) => {
    response.writeHead(200, { 'content-type': 'text/xml' });
    response.end(
      '<ServiceExceptionReport><ServiceException>Bad key ' +
        `${String(request.headers['x-key'])}</ServiceException></ServiceExceptionReport>`,
    );
  });
  const config = await configWith(
    t,
    server.base,
    'secret_headers = { x-key = "TERRAVOX_TEST_KEY" }\n',
  );
  const root = await storeWith(t, makeLaz());
  const failed = await command(config, words`ortho --store ${root} --source here --retries 0`);
  assert.match(failed.err, /Bad key \*\*\*/);
  const store = openStore(root, {}, kNever);
  t.after(() => store.close());
  assert.match(store.orthophotos.list({})[0]?.lastError?.message ?? '', /Bad key \*\*\*/);
  assert.ok(!`${failed.out}${failed.err}`.includes('hush'));
});

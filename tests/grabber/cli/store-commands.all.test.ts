import assert from 'node:assert/strict';
import { existsSync } from 'node:fs';
import { readFile, readdir, rm, symlink, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test, type TestContext } from 'node:test';
import type { CatalogueSquare, State, Store } from '../../../grabber/src/model/store.js';
import { kPlaces } from '../../../grabber/src/store/layout.js';
import { openStore, lockStore } from '../../../grabber/src/store/open-store.js';
import { cli, words } from '../support/cli.js';
import { makeLaz } from '../support/las-fixture.js';
import {
  bringIn,
  catalogueSquare,
  kTerms,
  kVerified,
  keyOfSquare,
  put,
  computeSha256,
} from '../support/record-fixture.js';
import { kNever, temporaryFolder } from '../support/store-fixture.js';

async function verified(store: Store, name: string, body: Buffer): Promise<string> {
  const path = await bringIn(store, keyOfSquare(name), body);
  store.squares.verified(keyOfSquare(name), kVerified);
  return path;
}

/**
 * Two verified squares, one failed, one wanted with an unfinished file, one known; and one
 * orthophoto.
 */
async function filledStore(
  t: TestContext,
): Promise<{ root: string; states: () => Record<string, State>; paths: string[] }> {
  const root = await temporaryFolder(t);
  const store = openStore(root, {}, kNever);
  const squares: CatalogueSquare[] = [462, 463, 464, 465, 466].map((e) =>
    catalogueSquare(e, 101, { published: e === 462 ? '2014' : '2015-05-01' }),
  );
  store.squares.learn('si-lss', 'si-lss', 'EPSG:3794', kTerms, squares);
  const paths = [
    await verified(store, '462_101', makeLaz()),
    await verified(store, '463_101', makeLaz({ dataBytes: 2000 })),
  ];
  store.squares.want([keyOfSquare('464_101'), keyOfSquare('465_101')]);
  store.squares.failed(keyOfSquare('464_101'), 'HTTP_STATUS', 'status 503');
  await put(root, kPlaces.unfinished('lidar', keyOfSquare('465_101')), 'begun');
  await put(root, `${kPlaces.unfinished('lidar', keyOfSquare('465_101'))}.json`, '{}');
  const ortho = keyOfSquare('462_101', 'si-dof', 'si-lss');
  store.orthophotos.learn('si-dof', 'si-lss', 'EPSG:3794', { ...kTerms, licence: null }, [
    catalogueSquare(462, 101),
  ]);
  store.orthophotos.begin(ortho, 'http://h/wms');
  const tiff = Buffer.from('49492a00080000000000000000000000', 'hex');
  const path = kPlaces.finished('ortho', ortho, 'tif');
  await put(root, path, tiff);
  const image = { width_px: 4, height_px: 4, resolution_m: 250, margin_m: 0 };
  store.orthophotos.converted(
    ortho,
    { path, bytes: tiff.length, sha256: computeSha256(tiff) },
    { points: null, image, crs: null, warnings: [] },
  );
  store.close();
  const states = (): Record<string, State> => {
    const read = openStore(root, { readOnly: true }, kNever);
    try {
      return Object.fromEntries(
        [...read.squares.list({}), ...read.orthophotos.list({})].map(({ key, state }) => [
          `${key.source}/${key.name}`,
          state,
        ]),
      );
    } finally {
      read.close();
    }
  };
  return { root, states, paths: [...paths, path] };
}

test('status shows counts, sizes, points, a map in letters, and the last errors', async (t) => {
  const { root } = await filledStore(t);
  const status = await cli(words`status --store ${root}`);
  assert.deepEqual([status.code, status.err], [0, '']);
  assert.match(
    status.out,
    new RegExp(
      String.raw`^squares +state +count +size +points\nsi-lss +failed +1 +- +-\nsi-lss +known` +
        String.raw` +1 +- +-\nsi-lss +verified +2 +\d\.\d kB +20\nsi-lss +wanted +1 +- +-\n`,
    ),
  );
  assert.match(
    status.out,
    /\northophotos +state +count +size +points\nsi-dof +converted +1 +16 B +-\n/,
  );
  assert.match(status.out, /\nsi-lss\nVVXw\.\n\. known {2}w wanted {2}V verified {2}X failed\n/);
  assert.match(
    status.out,
    /\nlast errors\n\S+Z {2}si-lss\/464_101 {2}failed {2}HTTP_STATUS: status 503\n$/,
  );
  const json = await cli(words`status --store ${root} --json`);
  const parsed = JSON.parse(json.out) as {
    squares: { tally: unknown[]; errors: { name: string }[] };
  };
  assert.equal(parsed.squares.tally.length, 4);
  assert.deepEqual(
    parsed.squares.errors.map(({ name }) => name),
    ['464_101'],
  );
  const empty = await cli(['status', '--store', join(root, 'none')]);
  assert.deepEqual([empty.code, empty.out], [1, '']);
  assert.match(empty.err, /no such file; allowed: a folder that the grabber fills/);
  assert.equal(existsSync(join(root, 'none')), false, 'reading makes no store');
  assert.equal((await cli(words`status`)).code, 2);
});

test('verify finds missing, cut, changed and invalid files, and wants them again', async (t) => {
  const { root, states, paths } = await filledStore(t);
  const good = await cli(words`verify --store ${root}`);
  assert.deepEqual([good.code, good.out], [0, '3 files checked, 0 bad\n']);
  const [first = '', second = '', third = ''] = paths;
  const body = await readFile(join(root, first));
  body.writeUInt8(body.readUInt8(600) ^ 1, 600);
  await writeFile(join(root, first), body);
  await rm(join(root, second));
  await writeFile(join(root, third), 'x');
  const bad = await cli(words`verify --store ${root}`);
  assert.equal(bad.code, 1);
  assert.match(
    bad.out,
    new RegExp(
      String.raw`^bad si-lss\/462_101 {2}lidar\/si-lss\/462_101\.laz: its SHA-256 is ` +
        String.raw`[0-9a-f]{64}; recorded: [0-9a-f]{64}\nbad si-lss\/463_101 .*: it is not ` +
        String.raw`there\nbad si-dof\/462_101 .*: it has 1 bytes; recorded: 16\n3 files ` +
        String.raw`checked, 3 bad; --repair`,
    ),
  );
  assert.equal(states()['si-lss/462_101'], 'verified', 'looking changes nothing');
  const one = JSON.parse((await cli(words`verify --store ${root} --source si-dof --json`)).out) as {
    checked: number;
    bad: unknown[];
  };
  assert.deepEqual([one.checked, one.bad.length], [1, 1]);
  const repaired = await cli(words`verify --store ${root} --repair`);
  assert.equal(repaired.code, 1);
  assert.match(repaired.out, /3 bad, wanted again\n$/);
  assert.deepEqual(states(), {
    'si-lss/462_101': 'wanted',
    'si-lss/463_101': 'wanted',
    'si-lss/464_101': 'failed',
    'si-lss/465_101': 'wanted',
    'si-lss/466_101': 'known',
    'si-dof/462_101': 'wanted',
  });
  assert.equal(existsSync(join(root, first)), false);
  assert.equal((await cli(words`verify --store ${root}`)).out, '0 files checked, 0 bad\n');
});

test('verify also reads files that await conversion or are fetched again', async (t) => {
  const root = await temporaryFolder(t);
  const store = openStore(root, {}, kNever);
  const squares = [462, 463, 464].map((e) => catalogueSquare(e, 101));
  store.squares.learn('si-lss', 'si-lss', null, kTerms, squares);
  const body = Buffer.from('ZLAS of which nobody knows more');
  const [zlas, begun] = [keyOfSquare('462_101'), keyOfSquare('463_101')];
  for (const key of [zlas, begun]) await bringIn(store, key, body, 'zlas');
  await rm(join(root, kPlaces.finished('lidar', begun, 'zlas')));
  await put(root, kPlaces.unfinished('lidar', begun), body);
  await verified(store, '464_101', makeLaz());
  store.squares.want([keyOfSquare('464_101')], true);
  store.close();
  assert.equal((await cli(words`verify --store ${root}`)).out, '3 files checked, 0 bad\n');
  assert.match((await cli(words`attribution --store ${root}`)).out, /1 LiDAR squares/);
  await put(root, kPlaces.finished('lidar', zlas, 'zlas'), Buffer.alloc(body.length));
  await put(root, kPlaces.unfinished('lidar', begun), 'cut');
  assert.match(
    (await cli(words`verify --store ${root}`)).out,
    new RegExp(
      String.raw`^bad si-lss\/462_101 .*SHA-256.*\nbad si-lss\/463_101 .*it is not there` +
        String.raw`\n3 files checked, 2 bad`,
    ),
  );
});

test('resume reports which orthophotos are unfinished, and how they are continued', async (t) => {
  const root = await temporaryFolder(t);
  const store = openStore(root, {}, kNever);
  store.orthophotos.learn('si-dof', 'si-lss', null, kTerms, [
    catalogueSquare(462, 101),
    catalogueSquare(463, 101),
    catalogueSquare(464, 101),
  ]);
  store.orthophotos.want([
    keyOfSquare('462_101', 'si-dof', 'si-lss'),
    keyOfSquare('463_101', 'si-dof', 'si-lss'),
  ]);
  store.squares.learn('de-by', 'de-by', null, kTerms, [catalogueSquare(690, 5336)]);
  store.close();
  const resumed = await cli(words`resume --store ${root}`);
  assert.equal(resumed.code, 3, resumed.err);
  assert.match(
    resumed.err,
    /^warning: 2 orthophotos of si-dof are unfinished \(grab ortho --source si-dof --grid si-lss; /,
  );
  assert.equal((await cli(words`resume --store ${root} --source de-by`)).code, 0);
});

test('verify reads a file whose hash is right, but which is no point cloud', async (t) => {
  const root = await temporaryFolder(t);
  const store = openStore(root, {}, kNever);
  store.squares.learn('si-lss', 'si-lss', null, kTerms, [catalogueSquare(462, 101)]);
  await verified(store, '462_101', Buffer.from('<html>'));
  store.close();
  assert.match((await cli(words`verify --store ${root}`)).out, /^bad .*starts with "<html>"/);
});

test('the attribution names source, years, licence with its address, and author', async (t) => {
  const { root } = await filledStore(t);
  const file = join(root, 'LICENCES.txt');
  const written = await cli(words`attribution --store ${root} --output ${file}`);
  assert.deepEqual(written, { code: 0, out: '', err: '' });
  const text = await readFile(file, 'utf8');
  assert.equal((await cli(words`attribution --store ${root}`)).out, text);
  assert.match(
    text,
    new RegExp(
      String.raw`^Slovenia, .* \(si-lss\)\n {2}data: +2 LiDAR squares\n {2}years: +2014 ` +
        String.raw`to 2015\n {2}licence: +CC BY 4\.0\n +https:\/\/creativecommons\.org\/` +
        String.raw`licenses\/by\/4\.0\/\n {2}attribution: ARSO\n\nsi-dof\n {2}data: +1 ` +
        String.raw`orthophotos\n {2}years: +not recorded\n {2}licence: +not recorded\n`,
    ),
  );
  const refused = await cli(['attribution', '--store', root, '--output', join(root, 'no', 'such')]);
  assert.equal(refused.code, 1);
  assert.match(refused.err, /write attribution .*ENOENT/);
});

test('gc removes what no record needs, keeps the rest, and never leaves the store', async (t) => {
  const { root, states, paths } = await filledStore(t);
  const outside = await temporaryFolder(t);
  await put(outside, 'precious.laz', 'x');
  await symlink(outside, join(root, 'lidar', 'linked'));
  await symlink(join(outside, 'precious.laz'), join(root, 'lidar', 'si-lss', 'link.laz'));
  const kept = [
    'ortho/stray.txt',
    'lidar/si-lss/462_101.lax',
    'lidar/si-lss/465_101.laz',
    'ortho/si-dof/si-lss/462_101.tif.aux.xml',
    'other/file.txt',
    'lidar/si-lss/.465_101.part',
    'lidar/si-lss/.465_101.part.json',
  ];
  for (const path of kept.slice(0, 5)) await put(root, path, 'k');
  const gone = [
    'lidar/si-lss/.462_101.part',
    'lidar/si-lss/.464_101.part.json',
    'lidar/si-lss/464_101.laz',
    'lidar/si-lss/466_101.lax',
    'lidar/old/1_1.laz',
    'ortho/si-dof/si-lss/463_101.tif',
  ];
  for (const path of gone) await put(root, path, 'g');
  const before = states();
  const dry = await cli(words`gc --store ${root} --dry-run`);
  assert.equal(dry.code, 0);
  assert.deepEqual(
    [...dry.out.matchAll(/^would remove (\S+) {2}1 B$/gm)].map((match) => match[1] ?? '').sort(),
    [...gone].sort(),
  );
  for (const path of gone) assert.ok(existsSync(join(root, path)), path);
  const real = await cli(words`gc --store ${root}`);
  assert.match(real.out, /\n6 files, 6 B removed\n$/);
  assert.match(
    real.err,
    new RegExp(
      String.raw`left alone lidar\/linked[^]*left alone lidar\/si-lss\/link\.laz[^]*left ` +
        String.raw`alone ortho\/stray\.txt`,
    ),
  );
  for (const path of gone) assert.ok(!existsSync(join(root, path)), path);
  for (const path of [...kept, ...paths, 'fishnet.gpkg']) {
    assert.ok(existsSync(join(root, path)), path);
  }
  assert.deepEqual(await readdir(outside), ['precious.laz']);
  assert.deepEqual(states(), before);
  assert.match((await cli(words`gc --store ${root}`)).out, /^0 files, 0 B removed\n$/);
});

test('gc --source drops all of one source, and nothing of another', async (t) => {
  const { root, states } = await filledStore(t);
  const dry = await cli(words`gc --store ${root} --source si-lss --dry-run`);
  assert.match(dry.out, /4 files, .* would go, 4 records of si-lss would be dropped\n$/);
  assert.equal(states()['si-lss/462_101'], 'verified');
  assert.match(
    (await cli(words`gc --store ${root} --source si-lss`)).out,
    /4 files, .* removed, 4 records of si-lss dropped\n$/,
  );
  const after = states();
  assert.ok(
    Object.entries(after).every(
      ([name, state]) => state === (name.startsWith('si-dof') ? 'converted' : 'known'),
    ),
    JSON.stringify(after),
  );
  assert.deepEqual(await readdir(join(root, 'lidar', 'si-lss')), []);
  assert.deepEqual(await readdir(join(root, 'ortho', 'si-dof', 'si-lss')), ['462_101.tif']);
  for (const bad of ['..', '../x', 'a/b', '']) {
    assert.equal((await cli(words`gc --store ${root} --source ${bad}`)).code, 2, bad);
  }
});

test('gc and repair refuse a store that is locked or whose folder leads elsewhere', async (t) => {
  const { root } = await filledStore(t);
  const unlock = lockStore(join(root, '.grabber.lock'), kNever);
  for (const args of [['gc'], ['verify', '--repair']]) {
    const refused = await cli([...args, '--store', root]);
    assert.equal(refused.code, 1);
    assert.match(refused.err, /holds .*one grabber at a time/);
  }
  assert.equal((await cli(words`status --store ${root}`)).code, 0);
  unlock();
  const outside = await temporaryFolder(t);
  await put(outside, 'x.laz', 'x');
  await rm(join(root, 'ortho'), { recursive: true });
  await symlink(outside, join(root, 'ortho'));
  const away = await cli(words`gc --store ${root}`);
  assert.match(away.err, /left alone ortho/);
  assert.deepEqual(await readdir(outside), ['x.laz']);
});

test('reading commands leave no file next to the database, and keep a log', async (t) => {
  const { root } = await filledStore(t);
  const names = async (): Promise<string[]> =>
    (await readdir(root)).filter((name) => name.startsWith('fishnet')).sort();
  const before = await readFile(join(root, 'fishnet.gpkg'));
  for (const command of [['status'], ['attribution'], ['fishnet', 'list'], ['verify']]) {
    await cli([...command, '--store', root]);
    assert.deepEqual(await names(), ['fishnet.gpkg'], command.join(' '));
  }
  assert.ok(before.equals(await readFile(join(root, 'fishnet.gpkg'))), 'the database is as it was');

  const writer = openStore(root, {}, kNever);
  writer.squares.want([keyOfSquare('466_101')]);
  assert.equal((await cli(words`status --store ${root}`)).code, 0);
  assert.deepEqual(await names(), ['fishnet.gpkg', 'fishnet.gpkg-shm', 'fishnet.gpkg-wal']);
  assert.equal(writer.squares.get(keyOfSquare('466_101'))?.state, 'wanted');
  writer.close();
  assert.deepEqual(await names(), ['fishnet.gpkg']);
});

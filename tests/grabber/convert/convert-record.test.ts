import assert from 'node:assert/strict';
import { readFile, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test, type TestContext } from 'node:test';
import {
  convertRecord,
  indexRecord,
  type ConvertTools,
  converterFor,
} from '../../../grabber/src/convert/convert-record.js';
import { parseConverters, lazTool } from '../../../grabber/src/convert/converters.js';
import { parsePointCount } from '../../../grabber/src/convert/zlas.js';
import type { StoreRecord, Store } from '../../../grabber/src/model/store.js';
import { openStore } from '../../../grabber/src/store/open-store.js';
import { makeLas, makeLaz } from '../support/las-fixture.js';
import {
  bringIn,
  catalogueSquare,
  kTerms,
  keyOfSquare,
  computeSha256,
} from '../support/record-fixture.js';
import { script } from '../support/cli.js';
import { kNever, storedFiles, temporaryFolder } from '../support/store-fixture.js';

const kKey = keyOfSquare('462_101');
const kOptions = { index: false, keepOriginal: false };
/** Compresses by copying the fixture it is given; the real tool has tests of its own. */
const kFakeTool = `
const fs = require('fs'), [command, from, to] = process.argv.slice(2);
const small = require('path').join(__dirname, 'small.laz');
if (command === 'compress') fs.copyFileSync(process.env.LAZ ?? small, to);
if (command === 'index') fs.writeFileSync(from.replace(/laz$/, 'lax'), 'LASX');
if (command === 'info') console.log(JSON.stringify({ copc: false }));`;

async function storeWith(
  t: TestContext,
  extension: string,
  bytes: Buffer,
): Promise<{ store: Store; record: () => StoreRecord }> {
  const store = openStore(await temporaryFolder(t), {}, kNever);
  store.squares.learn('si-lss', 'si-lss', 'EPSG:3794', kTerms, [catalogueSquare(462, 101)]);
  await bringIn(store, kKey, bytes, extension);
  const record = (): StoreRecord => store.squares.get(kKey) ?? assert.fail('no record');
  return { store, record };
}

async function tools(t: TestContext, converter?: string): Promise<ConvertTools> {
  const folder = await temporaryFolder(t);
  await writeFile(join(folder, 'small.laz'), makeLaz());
  const laz = lazTool(await script(folder, 'laz', kFakeTool), 20);
  const zlas =
    converter === undefined
      ? undefined
      : {
          command: [await script(folder, 'convert', converter), '{input}', '{output}'],
          time_limit_s: 2,
        };
  return {
    converters: { id: 'converters', ...(zlas === undefined ? {} : { zlas }) },
    laz,
    configFolder: '/etc/terravox',
  };
}

const kCopies = (laz: Buffer): string =>
  `require('fs').writeFileSync(process.argv[3], Buffer.from('${laz.toString('base64')}', ` +
  "'base64'))";
const kZlas = Buffer.from('ZLAS of which nobody knows more');

test('LAS becomes LAZ, and the original is remembered', async (t) => {
  const las = makeLas();
  const { store, record } = await storeWith(t, 'las', las);
  await convertRecord(record(), store, await tools(t), kOptions, kNever);
  assert.deepEqual(await storedFiles(store.root), ['lidar/si-lss/462_101.laz']);
  const row = record();
  assert.equal(row.state, 'converted');
  assert.equal(row.original?.bytes, las.length);
  assert.equal(row.file?.sha256, computeSha256(makeLaz()));
  assert.equal(row.points?.pointCount, 10);
});

test('a kept original lies where no program takes it for a square', async (t) => {
  const { store, record } = await storeWith(t, 'las', makeLas());
  await convertRecord(record(), store, await tools(t), { ...kOptions, keepOriginal: true }, kNever);
  assert.deepEqual(await storedFiles(store.root), [
    'lidar/si-lss/462_101.laz',
    'lidar/si-lss/original/462_101.las',
  ]);
});

test('a file whose bytes are no longer those that were fetched is not converted', async (t) => {
  const { store, record } = await storeWith(t, 'las', makeLas());
  const bytes = await readFile(join(store.root, 'lidar/si-lss/462_101.las'));
  bytes.writeUInt8(99, bytes.length - 1);
  await writeFile(join(store.root, 'lidar/si-lss/462_101.las'), bytes);
  await assert.rejects(
    convertRecord(record(), store, await tools(t), kOptions, kNever),
    /not those that were fetched/,
  );
});

test('zLAS is converted, and its point count checked where its header has one', async (t) => {
  const zlas = makeLas({ points: 10 });
  const { store, record } = await storeWith(t, 'zlas', zlas);
  await convertRecord(record(), store, await tools(t, kCopies(makeLaz())), kOptions, kNever);
  assert.deepEqual(await storedFiles(store.root), ['lidar/si-lss/462_101.laz']);
  assert.deepEqual(record().warnings, []);
  assert.equal(record().original?.bytes, zlas.length);
});

test('zLAS without a point count is accepted by its bounds, with a warning', async (t) => {
  const { store, record } = await storeWith(t, 'zlas', kZlas);
  await convertRecord(record(), store, await tools(t, kCopies(makeLaz())), kOptions, kNever);
  assert.match(
    record().warnings.join(),
    /does not state its number of points: the 10 converted ones/,
  );
});

test('a converter that makes LAS has its result compressed', async (t) => {
  const { store, record } = await storeWith(t, 'zlas', kZlas);
  await convertRecord(record(), store, await tools(t, kCopies(makeLas())), kOptions, kNever);
  assert.deepEqual(await readFile(join(store.root, 'lidar/si-lss/462_101.laz')), makeLaz());
});

test('a converter that does wrong changes nothing in the store', async (t) => {
  const laz = makeLaz();
  const fails = 'console.error("no licence"); process.exit(3)';
  const links = `require('fs').symlinkSync(process.argv[2], process.argv[3])`;
  const changes = `require('fs').appendFileSync(process.argv[2], 'x'); ${kCopies(laz)}`;
  const moved = kCopies(makeLaz({ min: [0, 0, 0], max: [10, 10, 10] }));
  const cases: [name: string, body: string, message: RegExp, zlas?: Buffer][] = [
    ['fails', fails, /exit code 3: no licence/],
    ['writes nothing', '', /wrote nothing to \{output\}/],
    ['writes no LAS', kCopies(Buffer.from('<html>')), /allowed: "LASF"/],
    ['writes half of it', kCopies(laz.subarray(0, laz.length - 8)), /needs/],
    ['loses points', kCopies(laz), /10 points; allowed: 11, as the zLAS/, makeLas({ points: 11 })],
    ['moves points', moved, /allowed: within 50 m of 462000/],
    ['leaves a link', links, /left a link or a folder/],
    ['changes its input', changes, /changed its input/],
  ];
  for (const [name, body, message, zlas] of cases) {
    await t.test(name, async (t) => {
      const { store, record } = await storeWith(t, 'zlas', zlas ?? kZlas);
      const before = record();
      await assert.rejects(
        convertRecord(before, store, await tools(t, body), kOptions, kNever),
        message,
      );
      assert.deepEqual(record(), before);
      assert.deepEqual(await storedFiles(store.root), ['lidar/si-lss/462_101.zlas']);
    });
  }
});

test('without a converter or the tool the message explains how to get one', async (t) => {
  const zlas = await storeWith(t, 'zlas', kZlas);
  await assert.rejects(
    convertRecord(zlas.record(), zlas.store, await tools(t), kOptions, kNever),
    /462_101\.zlas.*allowed: \[zlas\] command = .* in \/etc\/terravox\/converters\.toml/,
  );
  const las = await storeWith(t, 'las', makeLas());
  const none = { ...(await tools(t)), laz: undefined };
  await assert.rejects(
    convertRecord(las.record(), las.store, none, kOptions, kNever),
    /terravox-laz was not found; allowed: built/,
  );
});

test('an index is written once, and LAZ stays as it is', async (t) => {
  const { store, record } = await storeWith(t, 'laz', makeLaz());
  const all = await tools(t);
  assert.equal(
    await convertRecord(record(), store, all, { ...kOptions, index: true }, kNever),
    undefined,
  );
  assert.match((await indexRecord(record(), store, all, kNever)) ?? '', /462_101\.lax$/);
  assert.equal(await indexRecord(record(), store, all, kNever), undefined);
  assert.equal(record().state, 'fetched');
});

test('the hook of the pipeline reads its configuration, and may have no converter', async (t) => {
  const folder = await temporaryFolder(t);
  const { store, record } = await storeWith(t, 'zlas', kZlas);
  const hook = converterFor({ configFolder: folder, packageRoot: folder });
  await writeFile(join(folder, 'converters.toml'), 'id = "converters"\n');
  await hook(record(), store, kNever);
  assert.deepEqual(await storedFiles(store.root), ['lidar/si-lss/462_101.zlas']);

  const converter = await script(folder, 'c', kCopies(makeLaz()));
  const laz = await script(folder, 'laz', kFakeTool);
  await writeFile(
    join(folder, 'converters.toml'),
    `id = "converters"\n[zlas]\ncommand = ["${converter}", "{input}", "{output}"]\n` +
      `[laz]\nprogram = "${laz}"\n`,
  );
  const configured = converterFor({ configFolder: folder, packageRoot: folder });
  await configured(record(), store, kNever);
  assert.deepEqual(await storedFiles(store.root), ['lidar/si-lss/462_101.laz']);
});

test('a configuration that cannot work is refused', () => {
  const cases: [string, RegExp][] = [
    ['id = "x"', /field id is "x"/],
    ['id = "converters"\n[zlas]\ncommand = ["c", "{input}"]', /hold \{input\} and \{output\}/],
    ['id = "converters"\n[zlas]\ncommand = []', /zlas\.command/],
    [
      'id = "converters"\n[zlas]\ncommand = ["c", "{input}", "{output}"]\ntime_limit_s = 0',
      /1 to 86400/,
    ],
  ];
  for (const [toml, message] of cases) {
    assert.throws(() => parseConverters(toml, '/c/converters.toml'), message);
  }
});

test('the count of a zLAS file is read only where its header makes sense', () => {
  assert.equal(parsePointCount(makeLas({ points: 12 })), 12);
  assert.equal(parsePointCount(makeLas({ minor: 4, format: 6, points: 3, claimedPoints: 70 })), 70);
  assert.equal(parsePointCount(makeLas({ claimedPoints: 0 })), undefined);
  assert.equal(parsePointCount(makeLas({ major: 7 })), undefined);
  assert.equal(parsePointCount(kZlas), undefined);
});

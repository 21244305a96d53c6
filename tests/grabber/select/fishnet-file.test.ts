import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { copyFile, mkdir, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test, type TestContext } from 'node:test';
import { readFishnet, type FishnetFields } from '../../../grabber/src/select/fishnet-file.js';
import { recordsOf } from '../../../grabber/src/select/selection.js';
import { loadSources } from '../../../grabber/src/sources/load-sources.js';
import type { Source } from '../../../grabber/src/sources/source.js';
import { readPackageInfo } from '../../../grabber/src/util/package-info.js';
import { openStore } from '../../../grabber/src/store/open-store.js';
import { cli } from '../support/cli.js';
import { kNever, temporaryFolder } from '../support/store-fixture.js';

const kSources = join(readPackageInfo().root, '..', 'config', 'sources');

async function lss(): Promise<Source> {
  const source = (await loadSources(kSources, kNever)).get('si-lss');
  assert.ok(source);
  return source;
}

type Row = Record<string, string | number | null>;

/** A fishnet as ARSO publishes it: NAME, BLOK, CENTERX, CENTERY; rows are synthetic. */
async function fishnet(
  t: TestContext,
  rows: Row[],
  driver?: string,
  name = 'net.geojson',
): Promise<string> {
  const folder = await temporaryFolder(t);
  const geojson = join(folder, 'in.geojson');
  const features = rows.map((properties) => ({
    type: 'Feature',
    properties,
    geometry: { type: 'Point', coordinates: [462_500, 101_500] },
  }));
  await writeFile(geojson, JSON.stringify({ type: 'FeatureCollection', features }));
  if (driver === undefined) return geojson;
  await mkdir(join(folder, 'out'));
  execFileSync(
    'ogr2ogr',
    ['-f', driver, '-a_srs', 'EPSG:3794', join(folder, 'out', name), geojson],
    { stdio: 'ignore' },
  );
  return join(folder, 'out', name);
}

const row = (east: number, north: number, block: string): Row => ({
  NAME: `${east}_${north}`,
  BLOK: block,
  CENTERX: east * 1000 + 500,
  CENTERY: north * 1000 + 500,
});
const kRows = [row(463, 101, 'b_35'), row(462, 101, 'b_35'), row(545, 141, 'b_23')];

async function read(
  file: string,
  fields: FishnetFields = {},
): Promise<[string, string | null, string | undefined][]> {
  const squares = await readFishnet(file, await lss(), fields, {}, kNever);
  return squares.map(({ name, block, urls }) => [name, block, urls[0]]);
}

const kExpected = [
  ['462_101', 'b_35', 'https://gis.arso.gov.si/lidar/gkot/laz/b_35/D96TM/TM_462_101.laz'],
  ['463_101', 'b_35', 'https://gis.arso.gov.si/lidar/gkot/laz/b_35/D96TM/TM_463_101.laz'],
  ['545_141', 'b_23', 'https://gis.arso.gov.si/lidar/gkot/laz/b_23/D96TM/TM_545_141.laz'],
];

test('the fishnet of the survey is read from every format', async (t) => {
  for (const [driver, name] of [
    [undefined, ''],
    ['ESRI Shapefile', 'net.shp'],
    ['GPKG', 'net.gpkg'],
  ] as const) {
    await t.test(driver ?? 'GeoJSON', async (t) =>
      assert.deepEqual(await read(await fishnet(t, kRows, driver, name)), kExpected),
    );
  }
  await t.test('a DBF without its shapes', async (t) => {
    const shape = await fishnet(t, kRows, 'ESRI Shapefile', 'net.shp');
    const alone = join(await temporaryFolder(t), 'LIDAR_FISHNET_D96.dbf');
    await copyFile(shape.replace(/shp$/, 'dbf'), alone);
    assert.deepEqual(await read(alone), kExpected);
  });
});

test('columns and spellings of fishnets differ', async (t) => {
  const cases: {
    name: string;
    rows: Row[];
    fields?: FishnetFields;
    expected: [string, string | null];
  }[] = [
    {
      name: 'small letters',
      rows: [{ name: '462_101', blok: 'b_35' }],
      expected: ['462_101', 'b_35'],
    },
    {
      name: 'names of files',
      rows: [{ NAME: 'TM_462_101', BLOK: 'B_35' }],
      expected: ['462_101', 'b_35'],
    },
    {
      name: 'numbers of blocks',
      rows: [{ NAME: '462_101', BLOK: 35 }],
      expected: ['462_101', 'b_35'],
    },
    { name: 'no blocks', rows: [{ NAME: '462_101' }], expected: ['462_101', null] },
    {
      name: 'a block left empty',
      rows: [{ NAME: '462_101', BLOK: null }],
      expected: ['462_101', null],
    },
    {
      name: 'own columns',
      rows: [{ tile: '462_101', part: 'b_35' }],
      fields: { name: 'tile', block: 'PART' },
      expected: ['462_101', 'b_35'],
    },
  ];
  for (const { name, rows, fields, expected } of cases) {
    await t.test(name, async (t) => {
      const [square] = await read(await fishnet(t, rows), fields);
      assert.deepEqual(square?.slice(0, 2), expected);
    });
  }
});

test('a fishnet that cannot be right is refused with its row', async (t) => {
  const cases: { name: string; rows: Row[]; fields?: FishnetFields; message: RegExp }[] = [
    {
      name: 'no names',
      rows: [{ X: 1 }],
      message: /no column NAME; allowed: one of X \(--name-field\)/,
    },
    {
      name: 'a column that is not there',
      rows: kRows,
      fields: { block: 'PART' },
      message: /no column PART; allowed: one of NAME, BLOK/,
    },
    {
      name: 'a name of another form',
      rows: [...kRows, { NAME: 'A1', BLOK: 'b_35' }],
      message: /row 4: name "A1"; allowed: E_N/,
    },
    {
      name: 'an unknown block',
      rows: [{ NAME: '462_101', BLOK: 'b_99' }],
      message: /row 1: block "b_99"; allowed: one of b_11/,
    },
    {
      name: 'centres of another grid',
      rows: [{ ...row(462, 101, 'b_35'), CENTERX: 461_870 }],
      message: /row 1: the centre of square 462_101 is 461870,101500/,
    },
    {
      name: 'swapped axes',
      rows: [{ ...row(462, 101, 'b_35'), CENTERX: 101_500, CENTERY: 462_500 }],
      message: /row 1: the centre/,
    },
    {
      name: 'two blocks',
      rows: [row(462, 101, 'b_35'), row(462, 101, 'b_34')],
      message: /row 2: square 462_101 of blocks b_35 and b_34/,
    },
    { name: 'nothing', rows: [], message: /0 rows/ },
  ];
  for (const { name, rows, fields, message } of cases) {
    await t.test(name, async (t) =>
      assert.rejects(read(await fishnet(t, rows), fields), { code: 'FISHNET', message }),
    );
  }
});

test('squares of a fishnet become records, once', async (t) => {
  const source = await lss();
  const squares = await readFishnet(await fishnet(t, kRows), source, {}, {}, kNever);
  const store = openStore(await temporaryFolder(t), {}, kNever);
  t.after(() => store.close());
  const records = store.squares;
  const { source: id, grid, gridCrs, terms } = recordsOf(source);
  assert.deepEqual(records.learn(id, grid, gridCrs, terms, squares), { added: 3, changed: 0 });
  assert.deepEqual(records.learn(id, grid, gridCrs, terms, squares), { added: 0, changed: 0 });
  const record = records.get({ source: 'si-lss', grid: 'si-lss', name: '545_141' });
  assert.deepEqual(
    [record?.state, record?.block, record?.gridCrs, record?.classTable],
    ['known', 'b_23', 'EPSG:3794', 'si-lss'],
  );
  assert.deepEqual(record?.bounds, [545_000, 141_000, 546_000, 142_000]);
});

test('fishnet import counts without writing, from a file and from a grid', async (t) => {
  const file = await fishnet(t, kRows);
  const all = await cli(['fishnet', 'import', '--source', 'si-lss', '--from', file, '--dry-run']);
  assert.deepEqual(all, {
    code: 0,
    out: '3 squares of si-lss, 2 blocks, 0 without an address yet; nothing written\n',
    err: '',
  });
  const some = await cli([
    'fishnet',
    'import',
    '--source',
    'si-lss',
    '--from',
    file,
    '--dry-run',
    '--area',
    'ljubljana',
  ]);
  assert.match(some.out, /^2 squares of si-lss, 1 blocks/);
  const grid = await cli([
    'fishnet',
    'import',
    '--source',
    'nl-ahn',
    '--dry-run',
    '--area',
    'Delft',
  ]);
  assert.match(grid.out, /^1\d squares of nl-ahn, 0 blocks, 0 without/);
  const cases: { args: string[]; message: RegExp }[] = [
    { args: ['--from', file], message: /no store; allowed: --store FOLDER, or --dry-run/ },
    {
      args: ['--dry-run', '--name-field', 'X', '--area', 'bled'],
      message: /--name-field without --from/,
    },
    {
      args: ['--dry-run', '--from', file, '--area', 'bled', '--bbox', '0,0,1,1'],
      message: /one of them/,
    },
  ];
  for (const { args, message } of cases) {
    const { code, err } = await cli(['fishnet', 'import', '--source', 'si-lss', ...args]);
    assert.match(err, message);
    assert.equal(code, 2);
  }
});

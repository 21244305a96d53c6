import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { copyFile, mkdir, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test, type TestContext } from 'node:test';
import { readFishnet, type FishnetFields } from '../../../grabber/src/select/fishnet-file.js';
import { loadSources, type Source } from '../../../grabber/src/sources/source.js';
import { readPackageInfo } from '../../../grabber/src/util/package-info.js';
import { cli, words } from '../support/cli.js';
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
  const cases: [name: string, row: Row, fields: FishnetFields, block: string | null][] = [
    ['small letters, names of files', { name: 'TM_462_101', blok: 'B_35' }, {}, 'b_35'],
    ['numbers of blocks', { NAME: '462_101', BLOK: 35 }, {}, 'b_35'],
    ['no blocks', { NAME: '462_101' }, {}, null],
    ['a block left empty', { NAME: '462_101', BLOK: null }, {}, null],
    ['own', { tile: '462_101', part: 'b_35' }, { name: 'tile', block: 'PART' }, 'b_35'],
  ];
  for (const [name, row, fields, block] of cases) {
    const [square] = await read(await fishnet(t, [row]), fields);
    assert.deepEqual(square?.slice(0, 2), ['462_101', block], name);
  }
});

test('a fishnet that cannot be right is refused with its row', async (t) => {
  const good = row(462, 101, 'b_35');
  const cases: [name: string, rows: Row[], fields: FishnetFields, message: RegExp][] = [
    ['no names', [{ X: 1 }], {}, /no column NAME; allowed: one of X \(--name-field\)/],
    ['no such column', kRows, { block: 'PART' }, /no column PART; allowed: one of NAME, BLOK/],
    ['a strange name', [...kRows, { NAME: 'A1' }], {}, /row 4: name "A1"; allowed: E_N/],
    ['a strange block', [{ NAME: '462_101', BLOK: 'b_99' }], {}, /row 1: block "b_99"; allowed/],
    ['another grid', [{ ...good, CENTERX: 461_870 }], {}, /row 1: the centre .* is 461870,101500/],
    ['two blocks', [good, row(462, 101, 'b_34')], {}, /row 2: .* of blocks b_35 and b_34/],
    ['nothing', [], {}, /0 rows/],
  ];
  for (const [name, rows, fields, message] of cases) {
    await t.test(name, async (t) =>
      assert.rejects(read(await fishnet(t, rows), fields), { code: 'FISHNET', message }),
    );
  }
});

test('fishnet import counts without writing, from a file and from a grid', async (t) => {
  const file = await fishnet(t, kRows);
  const all = words`fishnet import --source si-lss --from ${file} --dry-run`;
  assert.deepEqual(await cli(all), {
    code: 0,
    out: '3 squares of si-lss, 2 blocks, 0 without an address yet; nothing written\n',
    err: '',
  });
  const some = await cli([...all, ...words`--area ljubljana`]);
  assert.match(some.out, /^2 squares of si-lss, 1 blocks/);
  const grid = await cli(words`fishnet import --source nl-ahn --dry-run --area Delft`);
  assert.match(grid.out, /^1\d squares of nl-ahn, 0 blocks, 0 without/);
});

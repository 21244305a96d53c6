import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { copyFile, mkdir, readdir, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { promisify } from 'node:util';
import { envelopeOfBlob } from '../../../grabber/src/store/geometry.js';
import { migrationsFolder } from '../../../grabber/src/store/database.js';
import { openStore } from '../../../grabber/src/store/open-store.js';
import { DatabaseSync, readValue } from '../../../grabber/src/store/sqlite.js';
import { fakeClock, kNever, temporaryFolder } from '../support/store-fixture.js';
import { catalogueSquare, kTerms, keyOfSquare } from '../support/record-fixture.js';

const run = promisify(execFile);

/** @return undefined where GDAL is not installed */
async function ogrinfo(args: readonly string[]): Promise<string | undefined> {
  try {
    return (await run('ogrinfo', ['-ro', ...args])).stdout;
  } catch (error) {
    if (error instanceof Error && 'code' in error && error.code === 'ENOENT') return undefined;
    throw error;
  }
}

test('GDAL opens the store as a GeoPackage: layers, CRS, geometry and extent', async (t) => {
  const root = await temporaryFolder(t);
  const store = openStore(root, {}, kNever);
  store.squares.learn('si-lss', 'si-lss', 'EPSG:3794', kTerms, [
    catalogueSquare(462, 101),
    catalogueSquare(463, 101),
  ]);
  store.squares.learn('adhoc', 'adhoc', null, kTerms, [
    { ...catalogueSquare(1, 1), name: 'nowhere', bounds: null },
  ]);
  store.close();
  const file = join(root, 'fishnet.gpkg');
  const all = await ogrinfo(['-so', '-al', file]);
  if (all === undefined) return t.skip('ogrinfo is not installed');
  for (const layer of ['squares', 'orthophotos', 'areas']) {
    assert.match(
      all,
      new RegExp(`Layer name: ${layer}\\n[^]*?Geometry: Polygon\\n[^]*?ID\\["EPSG",4326\\]`),
    );
  }
  assert.match(
    all,
    new RegExp(
      String.raw`Layer name: squares\n[^]*?Feature Count: 3\nExtent: \(14\.50\d*, 46\.04` +
        String.raw`\d*\) - \(14\.53\d*, 46\.05\d*\)`,
    ),
  );
  const one = await ogrinfo(['-al', '-where', "name = '462_101'", file, 'squares']);
  assert.match(one ?? '', /state \(String\) = known/);
  assert.match(
    one ?? '',
    new RegExp(
      String.raw`POLYGON \(\((14\.50\d+ 46\.04\d+),14\.5\d+ 46\.04\d+,14\.5\d+ 46\.05\d+,14` +
        String.raw`\.5\d+ 46\.05\d+,\1\)\)`,
    ),
  );
});

test('the tables of the standard are as it demands, also after squares move', async (t) => {
  const root = await temporaryFolder(t);
  const clock = fakeClock('2026-06-21T12:00:00.000Z');
  const store = openStore(root, { clock }, kNever);
  t.after(() => store.close());
  const db = new DatabaseSync(join(root, 'fishnet.gpkg'), { readOnly: true });
  t.after(() => db.close());
  assert.equal(readValue(db, 'PRAGMA application_id'), 0x47504b47);
  assert.equal(readValue(db, 'PRAGMA user_version'), 10300);
  assert.equal(readValue(db, 'PRAGMA journal_mode'), 'wal');
  assert.equal(readValue(db, 'PRAGMA integrity_check'), 'ok');
  assert.deepEqual(db.prepare('PRAGMA foreign_key_check').all(), []);
  assert.deepEqual(
    db
      .prepare('SELECT srs_id FROM gpkg_spatial_ref_sys ORDER BY srs_id')
      .all()
      .map(Object.values)
      .flat(),
    [-1, 0, 4326],
  );
  const styles = db
    .prepare('SELECT f_table_name, useAsDefault, styleQML FROM layer_styles ORDER BY 1')
    .all() as Record<string, string>[];
  assert.deepEqual(
    styles.map((style) => [style['f_table_name'], style['useAsDefault']]),
    [
      ['orthophotos', 1],
      ['squares', 1],
    ],
  );
  assert.match(
    styles[1]?.['styleQML'] ?? '',
    /type="categorizedSymbol" attr="state"[^]*value="failed"/,
  );

  const contents = (): Record<string, unknown> =>
    db
      .prepare(
        'SELECT last_change, min_x, min_y, max_x, max_y FROM gpkg_contents WHERE ' +
          "table_name = 'squares'",
      )
      .get() as Record<string, unknown>;
  assert.equal(contents()['min_x'], null);
  const learn = (e: number): void => {
    const square = { ...catalogueSquare(e, 101), name: 'a' };
    store.squares.learn('si-lss', 'si-lss', 'EPSG:3794', kTerms, [square]);
  };
  await clock.sleep(1000, kNever);
  learn(462);
  const first = contents();
  assert.equal(first['last_change'], '2026-06-21T12:00:01.000Z');
  const measured = readValue(db, 'SELECT geom FROM squares') as Uint8Array;
  assert.deepEqual(envelopeOfBlob(measured), [
    first['min_x'],
    first['max_x'],
    first['min_y'],
    first['max_y'],
  ]);
  await clock.sleep(1000, kNever);
  learn(500);
  assert.ok(
    Number(contents()['min_x']) > Number(first['max_x']),
    'the extent moves with the only square',
  );
  await clock.sleep(1000, kNever);
  learn(500);
  assert.equal(contents()['last_change'], '2026-06-21T12:00:02.000Z', 'nothing has changed');
  store.squares.want([keyOfSquare('a')]);
  assert.equal(contents()['last_change'], '2026-06-21T12:00:03.000Z');
});

test('older stores are migrated in one step, newer and foreign ones refused', async (t) => {
  const root = await temporaryFolder(t);
  const path = join(root, 'fishnet.gpkg');
  const later = join(root, 'migrations');
  await mkdir(later);
  const names = (await readdir(migrationsFolder())).sort();
  for (const name of names) await copyFile(join(migrationsFolder(), name), join(later, name));
  const store = openStore(root, {}, kNever);
  store.squares.learn('si-lss', 'si-lss', null, kTerms, [catalogueSquare(462, 101)]);
  store.close();
  const version = (): unknown => {
    const db = new DatabaseSync(path, { readOnly: true });
    const found = readValue(db, 'SELECT max(version) FROM terravox_schema');
    db.close();
    return found;
  };
  const next = join(later, `${String(names.length + 1).padStart(4, '0')}_more.sql`);
  await writeFile(next, 'CREATE TABLE more (a TEXT); INSERT INTO nowhere VALUES (1);');
  assert.throws(() => openStore(root, { migrations: later }, kNever), {
    code: 'STORE_DAMAGED',
    message: /nowhere/,
  });
  assert.equal(version(), names.length, 'a step that fails leaves all as it was');
  await writeFile(next, 'CREATE TABLE more (a TEXT);');
  assert.throws(() => openStore(root, { migrations: later, readOnly: true }, kNever), {
    code: 'STORE_FORMAT',
    message: /version is 3; allowed: 4/,
  });
  openStore(root, { migrations: later }, kNever).close();
  assert.equal(version(), names.length + 1);
  for (const readOnly of [false, true]) {
    assert.throws(() => openStore(root, { readOnly }, kNever), {
      code: 'STORE_FORMAT',
      message: /version is 4; allowed: up to 3; a newer grabber/,
    });
  }
  const kept = openStore(root, { migrations: later }, kNever);
  assert.equal(kept.squares.count({}), 1);
  kept.close();
});

function runOn(path: string, sql: string): void {
  const db = new DatabaseSync(path);
  db.exec(sql);
  db.close();
}

test('a file that is no store is refused and stays as it is', async (t) => {
  const geoPackage = 'PRAGMA application_id = 0x47504B47; CREATE TABLE a (b)';
  type Make = (path: string) => unknown;
  const cases: [make: Make, code: string, message: RegExp][] = [
    [(path) => writeFile(path, 'x'.repeat(5000)), 'STORE_DAMAGED', /not a database/],
    [(path) => runOn(path, 'CREATE TABLE a (b)'), 'STORE_FORMAT', /is 0, no GeoPackage/],
    [(path) => runOn(path, geoPackage), 'STORE_FORMAT', /without the table terravox_schema/],
  ];
  for (const [make, code, message] of cases) {
    const root = await temporaryFolder(t);
    await make(join(root, 'fishnet.gpkg'));
    for (const readOnly of [false, true]) {
      assert.throws(() => openStore(root, { readOnly }, kNever), { code, message });
    }
  }
  assert.throws(() => openStore('/nowhere', { readOnly: true }, kNever), {
    code: 'STORE_FORMAT',
    message: /no such file/,
  });
  assert.throws(() => openStore('/dev/null/x', {}, kNever), {
    code: 'STORE_IO',
    message: /make store folder/,
  });
});

test('a store is read while it is written, and from a disk that cannot be written', async (t) => {
  const root = await temporaryFolder(t);
  const writer = openStore(root, {}, kNever);
  writer.squares.learn('si-lss', 'si-lss', null, kTerms, [catalogueSquare(462, 101)]);
  const reader = openStore(root, { readOnly: true }, kNever);
  assert.equal(reader.squares.count({}), 1);
  writer.squares.want([keyOfSquare('462_101')]);
  assert.equal(reader.squares.get(keyOfSquare('462_101'))?.state, 'wanted');
  assert.throws(() => reader.squares.want([keyOfSquare('462_101')]), {
    code: 'STORE_IO',
    message: /opened for reading/,
  });
  reader.close();
  writer.close();
  // A folder in the place of the shared memory has the effect of a disk without write access, for
  // root too.
  await mkdir(join(root, 'fishnet.gpkg-shm'));
  const frozen = openStore(root, { readOnly: true }, kNever);
  assert.equal(frozen.squares.get(keyOfSquare('462_101'))?.state, 'wanted');
  frozen.close();
  await writeFile(join(root, 'fishnet.gpkg-wal'), 'what is in this log would be missing');
  assert.throws(() => openStore(root, { readOnly: true }, kNever), { code: 'STORE_IO' });
});

import assert from 'node:assert/strict';
import { test, type TestContext } from 'node:test';
import type { RecordKey, Store } from '../../../grabber/src/model/store.js';
import { openStore } from '../../../grabber/src/store/open-store.js';
import { DatabaseSync } from '../../../grabber/src/store/sqlite.js';
import { fakeClock, kNever, temporaryFolder } from '../support/store-fixture.js';
import {
  catalogueSquare,
  kTerms,
  kVerified,
  keyOfSquare,
  storedFile,
} from '../support/record-fixture.js';

const kKey = keyOfSquare('462_101');
const kStart = '2026-06-21T12:00:00.000Z';

async function newStore(t: TestContext): Promise<Store> {
  const store = openStore(await temporaryFolder(t), { clock: fakeClock(kStart) }, kNever);
  t.after(() => store.close());
  return store;
}

function learn(
  store: Store,
  square = catalogueSquare(462, 101),
  terms = kTerms,
): { added: number; changed: number } {
  return store.squares.learn('si-lss', 'si-lss', 'EPSG:3794', terms, [square]);
}

function bringIn(store: Store, key: RecordKey = kKey): void {
  store.squares.want([key]);
  store.squares.begin(key, 'http://h/first');
  store.squares.fetched(key, storedFile(key.name));
  store.squares.verified(key, kVerified);
}

test('a square goes from known to verified, and every step is in its record', async (t) => {
  const store = await newStore(t);
  assert.deepEqual(
    learn(
      store,
      catalogueSquare(462, 101, {
        block: 'b_35',
        bytes: 7,
        sha256: 'AB'.repeat(32),
        published: '2014',
      }),
    ),
    { added: 1, changed: 0 },
  );
  const known = store.squares.get(kKey);
  assert.deepEqual(known, {
    key: kKey,
    state: 'known',
    block: 'b_35',
    bounds: [462_000, 101_000, 463_000, 102_000],
    gridCrs: 'EPSG:3794',
    urls: ['http://h/462_101.laz'],
    expectedBytes: 7,
    expectedSha256: 'ab'.repeat(32),
    member: null,
    published: '2014',
    ...kTerms,
    url: null,
    file: null,
    original: null,
    points: null,
    image: null,
    warnings: [],
    lastError: null,
    attempts: 0,
    knownAt: kStart,
    wantedAt: null,
    fetchedAt: null,
    verifiedAt: null,
    convertedAt: null,
  });
  assert.equal(store.squares.want([kKey]), 1);
  assert.equal(store.squares.want([kKey]), 0, 'it is wanted already');
  store.squares.begin(kKey, 'http://h/a');
  store.squares.failed(kKey, 'NETWORK', 'first line\nsecond line');
  const failed = store.squares.get(kKey);
  assert.equal(failed?.state, 'failed');
  assert.deepEqual(failed.lastError, {
    code: 'NETWORK',
    message: 'first line second line',
    at: kStart,
  });
  const long = `run the converter${' and so on'.repeat(1000)}: disk full`;
  store.squares.failed(kKey, 'CONVERTER', long);
  const kept = store.squares.get(kKey)?.lastError?.message ?? '';
  assert.equal(kept.length, 2000);
  assert.match(kept, /^run the converter and so on.*….*and so on: disk full$/);
  store.squares.begin(kKey, 'http://h/b');
  assert.equal(store.squares.get(kKey)?.attempts, 2);
  store.squares.fetched(kKey, storedFile('462_101'));
  assert.equal(store.squares.get(kKey)?.state, 'fetched');
  store.squares.verified(kKey, { ...kVerified, warnings: ['odd'], crs: 'EPSG:3912' });
  const done = store.squares.get(kKey);
  assert.deepEqual(done, {
    ...known,
    state: 'verified',
    url: 'http://h/b',
    file: storedFile('462_101'),
    points: kVerified.points,
    warnings: ['odd'],
    crs: 'EPSG:3912',
    attempts: 2,
    wantedAt: kStart,
    fetchedAt: kStart,
    verifiedAt: kStart,
  });
  store.squares.forget(kKey);
  assert.deepEqual(store.squares.get(kKey), known);
});

test('a missing square is requested again after a month, or on request', async (t) => {
  const clock = fakeClock(kStart);
  const store = openStore(await temporaryFolder(t), { clock }, kNever);
  t.after(() => store.close());
  learn(store);
  store.squares.missing(kKey, 'no');
  const day_ms = 24 * 3600 * 1000;
  await clock.sleep(30 * day_ms, kNever);
  assert.equal(store.squares.want([kKey]), 0);
  await clock.sleep(1, kNever);
  assert.equal(store.squares.want([kKey]), 1);
  store.squares.missing(kKey, 'still no');
  assert.equal(store.squares.want([kKey]), 0, 'from now on');
  assert.equal(store.squares.want([kKey], true), 1);
});

test('a conversion keeps length and hash of what was sent', async (t) => {
  const store = await newStore(t);
  learn(store);
  store.squares.begin(kKey, 'http://h/a');
  store.squares.fetched(kKey, {
    ...storedFile('462_101', 9, '1'),
    path: 'lidar/si-lss/462_101.zlas',
  });
  store.squares.converted(kKey, storedFile('462_101', 5, '2'), kVerified);
  const record = store.squares.get(kKey);
  assert.equal(record?.state, 'converted');
  assert.deepEqual(record.original, { bytes: 9, sha256: '1'.repeat(64) });
  assert.deepEqual(record.file, storedFile('462_101', 5, '2'));
  assert.equal(record.convertedAt, kStart);
  store.squares.converted(kKey, storedFile('462_101', 6, '3'), kVerified);
  assert.deepEqual(
    store.squares.get(kKey)?.original,
    { bytes: 9, sha256: '1'.repeat(64) },
    'converted again',
  );
  store.squares.failed(kKey, 'X', 'later');
  assert.equal(store.squares.get(kKey)?.state, 'converted');
});

test('an orthophoto may be converted without a trace of what was sent', async (t) => {
  const { orthophotos } = await newStore(t);
  const key = keyOfSquare('462_101', 'si-dof', 'si-lss');
  orthophotos.learn('si-dof', 'si-lss', 'EPSG:3794', { ...kTerms, classTable: null }, [
    catalogueSquare(462, 101),
  ]);
  orthophotos.want([key]);
  orthophotos.begin(key, 'http://h/wms');
  const file = { path: 'ortho/si-dof/si-lss/462_101.tif', bytes: 3, sha256: '4'.repeat(64) };
  const image = { width_px: 2048, height_px: 2048, resolution_m: 0.5, margin_m: 12 };
  orthophotos.converted(key, file, { points: null, image, crs: null, warnings: [] });
  const record = orthophotos.get(key);
  assert.deepEqual(
    [record?.state, record?.file, record?.image, record?.original],
    ['converted', file, image, null],
  );
  assert.deepEqual(
    [record?.url, record?.fetchedAt, record?.verifiedAt],
    ['http://h/wms', kStart, kStart],
  );
});

test('a usable file survives what fails after it', async (t) => {
  const store = await newStore(t);
  learn(store);
  bringIn(store);
  const before = store.squares.get(kKey);
  assert.equal(store.squares.want([kKey]), 0);
  assert.equal(store.squares.want([kKey], true), 1);
  store.squares.begin(kKey, 'http://h/second');
  assert.equal(store.squares.get(kKey)?.state, 'fetching');
  assert.deepEqual(
    store.squares.list({ usable: true }).map(({ file }) => file),
    [before?.file],
    'also while another is fetched',
  );
  assert.deepEqual(
    [store.squares.tally()[0]?.state, store.squares.places()[0]?.state],
    ['verified', 'verified'],
  );
  store.squares.failed(kKey, 'HTTP_STATUS', '503');
  const after = store.squares.get(kKey);
  assert.deepEqual(
    [after?.state, after?.file, after?.url, after?.lastError?.code],
    ['verified', before?.file, 'http://h/first', 'HTTP_STATUS'],
  );
  store.squares.missing(kKey, 'the source has dropped it');
  assert.deepEqual(
    [store.squares.get(kKey)?.state, store.squares.get(kKey)?.lastError?.code],
    ['verified', 'MISSING'],
  );
  // A new file that turns out to be bad is another matter: the old one is gone.
  store.squares.begin(kKey, 'http://h/third');
  store.squares.fetched(kKey, storedFile('462_101', 6, '5'));
  assert.deepEqual(store.squares.list({ usable: true }), []);
  store.squares.failed(kKey, 'CONVERTER', 'bad');
  assert.deepEqual(
    [store.squares.get(kKey)?.state, store.squares.get(kKey)?.lastError?.code],
    ['fetched', 'CONVERTER'],
    'its bytes are here',
  );
  assert.equal(store.squares.get(kKey)?.url, 'http://h/third');
});

test('a later catalogue changes addresses and lengths, never state or file', async (t) => {
  const store = await newStore(t);
  learn(store, catalogueSquare(462, 101, { bytes: 5 }));
  bringIn(store);
  const file = store.squares.get(kKey)?.file;
  assert.deepEqual(learn(store, catalogueSquare(462, 101, { bytes: 5 })), { added: 0, changed: 0 });
  assert.deepEqual(learn(store, catalogueSquare(462, 101, { bytes: 5, urls: ['http://other'] })), {
    added: 0,
    changed: 1,
  });
  assert.deepEqual(store.squares.get(kKey)?.warnings, []);
  for (let times = 0; times < 2; ++times) {
    assert.deepEqual(
      learn(store, catalogueSquare(462, 101, { bytes: 6 + times, urls: ['http://other'] })),
      { added: 0, changed: 1 },
    );
    const record = store.squares.get(kKey);
    assert.deepEqual(
      [record?.state, record?.file, record?.warnings],
      ['verified', file, ['the source has a newer file']],
    );
  }
  assert.deepEqual(
    learn(store, catalogueSquare(462, 101, { bytes: 7, urls: ['http://other'] }), {
      ...kTerms,
      licence: 'CC0 1.0',
    }),
    { added: 0, changed: 1 },
  );
  assert.equal(store.squares.get(kKey)?.licence, 'CC0 1.0');
});

test('the CRS that a file names outlives its catalogue; that of a source does not', async (t) => {
  const store = await newStore(t);
  learn(store);
  learn(store, catalogueSquare(462, 101), { ...kTerms, crs: 'EPSG:3912' });
  assert.equal(store.squares.get(kKey)?.crs, 'EPSG:3912');
  store.squares.begin(kKey, 'http://h/a');
  store.squares.fetched(kKey, storedFile('462_101'));
  store.squares.verified(kKey, { ...kVerified, crs: 'EPSG:32633' });
  learn(store, catalogueSquare(462, 101), { ...kTerms, crs: 'EPSG:3035' });
  assert.equal(store.squares.get(kKey)?.crs, 'EPSG:32633');
  store.squares.forget(kKey);
  assert.equal(store.squares.get(kKey)?.crs, 'EPSG:3035');
});

test('an address found by probing survives a catalogue that lacks it', async (t) => {
  const store = await newStore(t);
  const unknown = catalogueSquare(462, 101, { urls: [] });
  learn(store, unknown);
  store.squares.located(kKey, 'b_35', ['http://h/b_35/462_101.laz']);
  assert.deepEqual(learn(store, unknown), { added: 0, changed: 0 });
  const record = store.squares.get(kKey);
  assert.deepEqual([record?.block, record?.urls], ['b_35', ['http://h/b_35/462_101.laz']]);
});

test('filters, counts and what is left to do come by source, grid and name', async (t) => {
  const { squares } = await newStore(t);
  squares.learn('si-lss', 'si-lss', 'EPSG:3794', kTerms, [
    catalogueSquare(463, 101),
    catalogueSquare(462, 101),
    catalogueSquare(462, 101),
  ]);
  squares.learn('de-by', 'de-by', 'EPSG:25832', kTerms, [catalogueSquare(690, 5336)]);
  squares.want([keyOfSquare('463_101'), keyOfSquare('690_5336', 'de-by')]);
  const names = (records: { key: RecordKey }[]): string[] =>
    records.map(({ key }) => `${key.source}/${key.name}`);
  assert.deepEqual(names(squares.list({})), ['de-by/690_5336', 'si-lss/462_101', 'si-lss/463_101']);
  assert.deepEqual(names(squares.list({ source: 'si-lss', states: ['known'] })), [
    'si-lss/462_101',
  ]);
  assert.deepEqual(names(squares.list({ names: ['463_101', 'x'] })), ['si-lss/463_101']);
  assert.deepEqual(names(squares.list({ states: [] })), []);
  assert.deepEqual(names(squares.unfinished({})), ['de-by/690_5336', 'si-lss/463_101']);
  assert.deepEqual(names(squares.unfinished({ states: ['known', 'fetching'] })), []);
  assert.equal(squares.count({ source: 'si-lss' }), 2);
  assert.equal(squares.count({}), 3);
  assert.deepEqual(
    squares.tally().map(({ source, state, count }) => [source, state, count]),
    [
      ['de-by', 'wanted', 1],
      ['si-lss', 'known', 1],
      ['si-lss', 'wanted', 1],
    ],
  );
});

test('a call on a missing record, or without the file it needs, changes nothing', async (t) => {
  const { squares } = await newStore(t);
  squares.learn('si-lss', 'si-lss', null, kTerms, [catalogueSquare(462, 101)]);
  const conflict = { code: 'STORE_CONFLICT' };
  const none = keyOfSquare('1_1');
  assert.throws(() => squares.want([kKey, none]), conflict);
  assert.equal(squares.get(kKey)?.state, 'known', 'all or nothing');
  for (const call of [
    () => squares.begin(none, 'http://h'),
    () => squares.located(none, null, []),
    () => squares.fetched(none, storedFile('1_1')),
    () => squares.converted(none, storedFile('1_1'), kVerified),
    () => squares.missing(none, ''),
    () => squares.failed(none, 'X', ''),
    () => squares.forget(none),
  ]) {
    assert.throws(call, { ...conflict, message: /si-lss\/si-lss\/1_1: no such record/ });
  }
  assert.throws(() => squares.verified(kKey, kVerified), {
    ...conflict,
    message: /it has no file/,
  });
  const bad = (name: string) => () =>
    squares.learn('si-lss', 'si-lss', null, kTerms, [
      catalogueSquare(463, 101),
      { ...catalogueSquare(1, 1), name },
    ]);
  for (const name of ['', '..', '../x', 'a/b', 'a\\b', '.hidden', 'a\nb', 'x'.repeat(201)]) {
    assert.throws(bad(name), conflict, JSON.stringify(name));
  }
  assert.equal(squares.count({}), 1, 'no square of a refused catalogue stays');
});

test('a damaged row is an error that names row and column', async (t) => {
  const cases: [column: string, value: string][] = [
    ['urls', "'no list'"],
    ['urls', "'[1]'"],
    ['attempts', '-1'],
    ['attempts', '1.5'],
    ['known_at', "'yesterday'"],
    ['north', '0'],
    ['north', 'NULL'],
    ['file_path', "'lidar/../../x.laz'"],
    ['file_sha256', "'xyz'"],
    ['point_format', '11'],
    ['state', "'lost'"],
    ['crs', "x'00'"],
  ];
  const root = await temporaryFolder(t);
  const store = openStore(root, {}, kNever);
  t.after(() => store.close());
  learn(store);
  bringIn(store);
  for (const [column, value] of cases) {
    const db = new DatabaseSync(`${root}/fishnet.gpkg`);
    db.exec('PRAGMA ignore_check_constraints = 1');
    db.exec(
      `SAVEPOINT s; CREATE TEMP TABLE kept AS SELECT ${column} AS v FROM squares; UPDATE ` +
        `squares SET ${column} = ${value}; RELEASE s`,
    );
    assert.throws(
      () => store.squares.list({}),
      (error: Error & { code?: string }) => {
        assert.equal(error.code, 'STORE_DAMAGED', `${column} = ${value}`);
        assert.match(error.message, /squares si-lss\/si-lss\/462_101: \w+ is .*; allowed: /);
        return true;
      },
    );
    db.exec(`UPDATE squares SET ${column} = (SELECT v FROM kept)`);
    db.close();
    assert.equal(store.squares.list({}).length, 1);
  }
});

test('a number in the store that JavaScript cannot hold is damage', async (t) => {
  const root = await temporaryFolder(t);
  const store = openStore(root, {}, kNever);
  t.after(() => store.close());
  learn(store);
  const db = new DatabaseSync(`${root}/fishnet.gpkg`);
  db.exec('UPDATE squares SET attempts = 9223372036854775807');
  db.close();
  assert.throws(() => store.squares.list({}), {
    code: 'STORE_DAMAGED',
    message: /^read .*fishnet\.gpkg: .*9223372036854775807.*; allowed: a sound GeoPackage/,
  });
});

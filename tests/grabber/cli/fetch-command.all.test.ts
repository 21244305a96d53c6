import assert from 'node:assert/strict';
import type { ChildProcess } from 'node:child_process';
import { mkdir, readFile, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { findGround } from '../../../grabber/src/model/store.js';
import { readRing } from '../support/record-fixture.js';
import { openStore } from '../../../grabber/src/store/open-store.js';
import { DatabaseSync } from '../../../grabber/src/store/sqlite.js';
import { cli, program, words, configFolder, templateAccess } from '../support/cli.js';
import { sendFile, sendStatus, serve } from '../support/http-fixture.js';
import { makeKeys, makeLas, makeLaz } from '../support/las-fixture.js';
import { kNever, makeSquare, storedFiles, temporaryFolder } from '../support/store-fixture.js';

const kLaz = makeLaz();
const kSecretVariable = 'TERRAVOX_TEST_KEY';
const kSecretTable = `
[secret_headers]
X-Key = "${kSecretVariable}"
`;

test('--allow-private permits the origin that was typed, not where it redirects to', async (t) => {
  const other = await serve(t, (_request, response) => sendFile(response, kLaz));
  const { port } = new URL(other.base);
  const targets: Record<string, string> = {
    '/port.laz': `${other.base}/a.laz`,
    '/name.laz': `http://localhost:${port}/a.laz`,
    '/address.laz': `http://127.0.0.2:${port}/a.laz`,
  };
  const own = await serve(t, (request, response) => {
    const location = targets[request.url ?? ''];
    if (location === undefined) return sendFile(response, kLaz);
    sendStatus(response, 302, { location });
  });
  const store = await temporaryFolder(t);
  const fetch = (name: string) =>
    cli(
      words`fetch --url-template ${own.base}/{name}.laz --allow-private --squares ${name}
        --store ${store} --as mine --retries 0`,
    );
  for (const name of ['port', 'name', 'address']) {
    const { code, err } = await fetch(name);
    assert.equal(code, 1, name);
    assert.match(err, /HOST_REFUSED/, name);
  }
  assert.equal(other.seen.length, 0, 'no request goes to another port of this machine');
  assert.equal((await fetch('castle')).code, 0);
  assert.deepEqual(await storedFiles(store), ['lidar/mine/castle.laz']);
});

test('fetch copies a local folder, and lists the files that it could not use', async (t) => {
  const folder = await temporaryFolder(t);
  await mkdir(join(folder, 'b_35'));
  await writeFile(join(folder, 'b_35', 'TM_462_101.laz'), kLaz);
  await writeFile(join(folder, 'b_35', 'TM_462_101.zlas'), 'old');
  await writeFile(
    join(folder, 'TM_463_101.las'),
    makeLas({ min: [463_000, 101_000, 0], max: [464_000, 102_000, 1] }),
  );
  await writeFile(join(folder, 'notes.laz'), kLaz);
  await writeFile(join(folder, 'TM_464_101.zlas'), 'zlas');
  const sources = await configFolder(t, templateAccess('http://127.0.0.1:1'));
  const store = await temporaryFolder(t);
  const args = words`fetch --config ${sources} --source here --from ${folder} --store ${store}`;

  const all = await cli(args);
  assert.equal(all.code, 3);
  assert.match(all.err, /warning: ignored .*notes\.laz: not a file name of here/);
  assert.match(all.err, /warning: lidar\/here\/464_101\.zlas needs a conversion/);
  assert.match(all.out, /2 fetched, 1 to convert, 0 already there, 0 missing, 0 failed/);
  // LAS is compressed where terravox-laz is built; it can be used as it is, too.
  const files = (await storedFiles(store)).map((path) => path.replace(/\.la[sz]$/, ''));
  assert.deepEqual(files, ['lidar/here/462_101', 'lidar/here/463_101', 'lidar/here/464_101.zlas']);

  const some = await cli([...args, '--bbox', '462000,101000,463000,103000']);
  assert.equal(some.code, 3);
  assert.match(some.err, /\nhole: here has no square 462_102 \([^\n]*\)\n$/);

  const names = await cli(words`fetch --from ${folder} --store ${store} --squares notes`);
  assert.equal(names.code, 0, names.err);
  assert.ok((await storedFiles(store)).includes('lidar/local/notes.laz'));
});

/** By the names of the squares; of none where a square is not drawn. */
function drawnPolygons(root: string): (Uint8Array | null)[] {
  const db = new DatabaseSync(join(root, 'fishnet.gpkg'), { readOnly: true });
  try {
    const rows = db.prepare('SELECT geom FROM squares ORDER BY name').all();
    return rows.map((row) => (row as { geom: Uint8Array | null }).geom);
  } finally {
    db.close();
  }
}

test('squares of a local folder are where the points of their files are', async (t) => {
  const folder = await temporaryFolder(t);
  const place = { min: [462_000.5, 101_000, 0], max: [462_256, 101_255.99, 9] } as const;
  const laz = (vlrs: readonly Buffer[]): Buffer =>
    makeLaz({ min: [...place.min], max: [...place.max], vlrs });
  await writeFile(join(folder, 'a.laz'), laz([makeKeys([3072, 3794])]));
  await writeFile(join(folder, 'b.laz'), laz([]));
  await writeFile(join(folder, 'c.laz'), laz([makeKeys([3072, 3912])]));
  const root = await temporaryFolder(t);
  const args = words`fetch --from ${folder} --store ${root} --crs EPSG:3794`;
  assert.equal((await cli(args)).code, 0);

  const store = openStore(root, { readOnly: true }, kNever);
  t.after(() => {
    store.close();
  });
  const records = store.squares.list({});
  assert.deepEqual(
    records.map(({ key, crs }) => `${key.name} ${crs}`),
    ['a EPSG:3794', 'b EPSG:3794', 'c EPSG:3912'],
  );
  assert.deepEqual(
    records.map(({ warnings }) => warnings.join()),
    ['', '', 'square c is in EPSG:3912, as its header says; expected EPSG:3794, which is not used'],
  );
  for (const record of records) {
    assert.deepEqual(findGround(record)?.bounds, [462_000, 101_000, 462_256, 101_256]);
  }
  assert.equal(store.squares.places().length, 3);
  const [a, b, c] = drawnPolygons(root);
  assert.deepEqual(a, b);
  assert.notDeepEqual(a, c);
  const ring = readRing(a ?? Buffer.alloc(0));
  // As PROJ has it, by gdaltransform.
  for (const [axis, degrees] of [14.508973, 46.047744].entries()) {
    assert.ok(Math.abs((ring[0]?.[axis] ?? 0) - degrees) < 3e-5, String(ring[0]));
  }

  // As a grabber has left it that did not draw them.
  const db = new DatabaseSync(join(root, 'fishnet.gpkg'));
  db.exec('UPDATE squares SET geom = NULL; UPDATE gpkg_contents SET min_x = NULL, max_x = NULL');
  db.close();
  openStore(root, {}, kNever).close();
  assert.deepEqual(drawnPolygons(root), [a, b, c]);
});

test(
  'SIGINT stops a fetch cleanly and the next run continues it',
  { skip: process.platform === 'win32' && 'no signals there' },
  async (t) => {
    const body = makeLaz({ dataBytes: 100_000 });
    let child: ChildProcess | undefined;
    let stopping = true;
    const server = await serve(t, (request, response) => {
      if (request.url !== '/TM_463_101.laz' || !stopping) return sendFile(response, body);
      response.writeHead(200, { 'content-length': String(body.length), etag: '"v1"' });
      response.write(body.subarray(0, 50_000), () => child?.kill('SIGINT'));
    });
    const sources = await configFolder(t, templateAccess(server.base));
    const store = await temporaryFolder(t);
    const args = words`fetch --config ${sources} --source here --store ${store}
      --squares 462_101,463_101,464_101 --concurrency 1`;

    const stopped = await program(args, (started) => (child = started));
    assert.equal(stopped.code, 130);
    assert.equal(stopped.err, 'error: stopped by SIGINT; the next run continues\n');
    const files = await storedFiles(store);
    assert.deepEqual(
      files.filter((file) => !file.includes('.part')),
      ['lidar/here/462_101.laz'],
      'no lock and no unfinished file is left',
    );

    stopping = false;
    const next = await cli(args);
    assert.equal(next.code, 0, next.err);
    assert.match(next.out, /2 fetched, 1 already there/);
  },
);

test('a dry run lists squares, addresses and sizes, and makes nothing', async (t) => {
  const server = await serve(t, (_request, response) => sendFile(response, kLaz));
  const sources = await configFolder(t, templateAccess(server.base));
  const store = join(await temporaryFolder(t), 'not', 'there');
  const args = words`fetch --config ${sources} --source here --squares 462_101,463_101
    --store ${store} --dry-run`;
  const plain = await cli(args);
  assert.equal(plain.code, 0, plain.err);
  assert.match(
    plain.out,
    new RegExp(
      String.raw`^462_101\t\?\thttp[^\n]*TM_462_101\.laz\n463_101[^\n]*\n2 squares, 0 B ` +
        String.raw`and 2 of unknown size \(--sizes requests it\); [^\n]* free\n$`,
    ),
  );
  assert.equal(server.seen.length, 0);
  const sized = await cli([...args, '--sizes', '--json']);
  const lines = sized.out
    .trimEnd()
    .split('\n')
    .map((line) => JSON.parse(line) as Record<string, unknown>);
  assert.deepEqual(
    lines.map((line) => line['bytes'] ?? line['known_bytes']),
    [kLaz.length, kLaz.length, 2 * kLaz.length],
  );
  assert.equal(server.seen.length, 2);
  await assert.rejects(storedFiles(store), { code: 'ENOENT' });
});

test('resume continues unfinished squares, and reports those that it cannot', async (t) => {
  const server = await serve(t, (_request, response) => sendFile(response, kLaz));
  const sources = await configFolder(t, templateAccess(server.base));
  const store = await temporaryFolder(t);
  const resume = words`resume --config ${sources} --store ${store}`;
  const none = await cli(resume);
  assert.deepEqual([none.code, none.err.includes('fishnet.gpkg: no such file')], [1, true]);

  const open = openStore(store, {}, kNever);
  const terms = { crs: null, classTable: null, licence: null, attribution: null };
  open.squares.learn('here', 'here', null, terms, [
    makeSquare('462_101', [`${server.base}/a.laz`]),
    makeSquare('463_101', ['file:///etc/passwd']),
  ]);
  open.squares.learn('adhoc', 'adhoc', null, terms, [
    makeSquare('470_101', [`${server.base}/b.laz`]),
  ]);
  open.squares.want([...open.squares.list({})].map(({ key }) => key));
  open.close();

  const some = await cli([...resume, ...words`--retries 0`]);
  assert.equal(some.code, 1);
  assert.match(
    some.err,
    new RegExp(
      String.raw`error: adhoc not continued, 1 files: its source has no configuration; ` +
        String.raw`allowed: run fetch again`,
    ),
  );
  assert.match(some.err, /error: here not continued, 1 files: they came from a folder/);
  assert.match(some.out, /^verified 462_101 /);
  assert.deepEqual(await storedFiles(store), ['lidar/here/462_101.laz']);
  assert.equal((await cli([...resume, ...words`--source nothing`])).code, 2);
});

test('no secret is printed, whatever the options', async (t) => {
  const server = await serve(t, (request, response) => {
    if (request.headers['x-key'] !== 'hush-hush') return sendStatus(response, 401);
    if (request.url === '/TM_463_101.laz') {
      return sendFile(response, Buffer.from(`<html><title>${request.headers['x-key']}</title>`));
    }
    sendFile(response, kLaz);
  });
  const sources = await configFolder(t, templateAccess(server.base));
  const toml = join(sources, 'sources', 'here.toml');
  await writeFile(toml, `${await readFile(toml, 'utf8')}${kSecretTable}`);
  process.env[kSecretVariable] = 'hush-hush';
  t.after(() => delete process.env[kSecretVariable]);
  for (const json of [[], ['--json']]) {
    const store = await temporaryFolder(t);
    const args = words`fetch --config ${sources} --source here --squares 462_101,463_101
      --retries 0 --store ${store}`;
    const { code, out, err } = await cli([...args, ...json]);
    assert.equal(code, 1, err);
    assert.match(out, /462_101/);
    assert.match(out + err, /\*\*\*/);
    assert.ok(!(out + err).includes('hush'), out + err);
  }
});

import assert from 'node:assert/strict';
import type { ServerResponse } from 'node:http';
import { rm, writeFile } from 'node:fs/promises';
import { test } from 'node:test';
import type { Outcome } from '../../grabber/src/fetch/fetch-square.js';
import { fetchSquares } from '../../grabber/src/fetch/fetch-squares.js';
import { squareAt } from '../../grabber/src/sources/square.js';
import { Manifest } from '../../grabber/src/store/manifest.js';
import { sendFile, sendPart, sendStatus, serve } from './support/http-fixture.js';
import { makeLaz } from './support/las-fixture.js';
import { fetchFixture, kNever, storedFiles } from './support/store-fixture.js';

const kLaz = makeLaz();
const kRow = Array.from({ length: 7 }, (_unused, index) => squareAt((460 + index) * 1000, 101_000));
const kIgnore = (): void => undefined;

test('no more squares are under way than allowed, and as many as allowed', async (t) => {
  const open: ServerResponse[] = [];
  let most = 0;
  const server = await serve(t, (_request, response, index) => {
    open.push(response);
    most = Math.max(most, open.length);
    // Answers only once three wait, or none more can come: a fourth request would be seen meanwhile.
    if (open.length === 3 || index === kRow.length - 1) for (const waiting of open.splice(0)) sendFile(waiting, kLaz);
  });
  const fixture = await fetchFixture(t, server.base);
  const tally = await fetchSquares(kRow, 3, fixture, kIgnore, kNever);
  assert.deepEqual(tally, { verified: 7, kept: 0, missing: 0, failed: 0 });
  assert.equal(most, 3);
});

test('bad squares do not stop the good ones, and all are counted', async (t) => {
  const server = await serve(t, (request, response) => {
    if (request.url === '/TM_461_101.laz') return sendStatus(response, 404);
    if (request.url === '/TM_462_101.laz')
      return sendFile(response, Buffer.from('<html>'), { 'content-type': 'text/html' });
    sendFile(response, kLaz);
  });
  const fixture = await fetchFixture(t, server.base);
  const outcomes: Outcome[] = [];
  const tally = await fetchSquares(kRow, 2, fixture, (outcome) => outcomes.push(outcome), kNever);
  assert.deepEqual(tally, { verified: 5, kept: 0, missing: 1, failed: 1 });
  assert.equal(outcomes.length, 7);
  const records = (await Manifest.open(fixture.store.manifest, kNever)).records();
  assert.deepEqual(
    records.map((record) => record.state),
    ['verified', 'missing', 'failed', 'verified', 'verified', 'verified', 'verified'],
  );
});

test('a stop ends the squares under way, starts no other, and the next run goes on', async (t) => {
  const stop = new AbortController();
  const server = await serve(t, (_request, response, index) => {
    if (index === 2) {
      response.writeHead(200, { 'content-length': String(kLaz.length), etag: '"v1"' });
      response.write(kLaz.subarray(0, 500), () => stop.abort(new Error('stopped')));
      return;
    }
    sendFile(response, kLaz);
  });
  const fixture = await fetchFixture(t, server.base);
  await assert.rejects(fetchSquares(kRow, 1, fixture, kIgnore, stop.signal), { message: 'stopped' });
  assert.equal(server.seen.length, 3);
  assert.deepEqual(
    (await storedFiles(fixture.store.root)).filter((file) => file.endsWith('.laz')),
    ['lidar/test/460_101.laz', 'lidar/test/461_101.laz'],
  );

  const next = await fetchFixture(t, server.base, { root: fixture.store.root });
  assert.deepEqual(await fetchSquares(kRow, 1, next, kIgnore, kNever), { verified: 5, kept: 2, missing: 0, failed: 0 });
});

test('a store that cannot be written ends the run instead of downloading for nothing', async (t) => {
  const server = await serve(t, (_request, response) => sendFile(response, kLaz));
  const fixture = await fetchFixture(t, server.base);
  await rm(fixture.store.root, { recursive: true });
  await writeFile(fixture.store.root, 'a file where the folder was');
  await assert.rejects(fetchSquares(kRow, 1, fixture, kIgnore, kNever), {
    code: 'STORE_IO',
    message: /write .*manifest\.json/,
  });
  assert.equal(server.seen.length, 0);
});

test('a cut connection on every try is a failure that leaves the part for later', async (t) => {
  const server = await serve(t, (_request, response) => sendPart(response, kLaz, 600, { etag: '"v1"' }));
  const fixture = await fetchFixture(t, server.base, { retries: 1, onStored: () => server.cut() });
  const tally = await fetchSquares(kRow.slice(0, 1), 1, fixture, kIgnore, kNever);
  assert.equal(tally.failed, 1);
  assert.deepEqual(await storedFiles(fixture.store.root), [
    'lidar/test/.460_101.part',
    'lidar/test/.460_101.part.json',
  ]);
});

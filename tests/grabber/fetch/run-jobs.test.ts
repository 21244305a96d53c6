import assert from 'node:assert/strict';
import type { ServerResponse } from 'node:http';
import { rm, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { sendFile, sendStatus, serve } from '../support/http-fixture.js';
import { makeLaz } from '../support/las-fixture.js';
import { fetchFixture, toKey, kNever, makeSquare } from '../support/store-fixture.js';
import type { CatalogueSquare } from '../../../grabber/src/model/store.js';

const kLaz = makeLaz();
const kNames = Array.from({ length: 7 }, (_unused, index) => `${460 + index}_101`);

function row(base: string): CatalogueSquare[] {
  return kNames.map((name) => makeSquare(name, [`${base}/TM_${name}.laz`]));
}

test('no more squares are under way than allowed, and as many as allowed', async (t) => {
  const open: ServerResponse[] = [];
  let most = 0;
  const server = await serve(t, (_request, response, index) => {
    open.push(response);
    most = Math.max(most, open.length);
    // Answers only once three wait, or none more can come: a fourth request would be seen
    // meanwhile.
    if (open.length === 3 || index === kNames.length - 1) {
      for (const waiting of open.splice(0)) sendFile(waiting, kLaz);
    }
  });
  const fixture = await fetchFixture(t, server.base, { concurrency: 3 });
  const outcomes = await fixture.fetch(row(server.base));
  assert.deepEqual(
    outcomes.map(({ state }) => state),
    kNames.map(() => 'verified'),
  );
  assert.equal(most, 3);
});

test('bad squares do not stop the good ones, and all are counted', async (t) => {
  const server = await serve(t, (request, response) => {
    if (request.url === '/TM_461_101.laz') return sendStatus(response, 404);
    if (request.url === '/TM_462_101.laz') return sendFile(response, Buffer.from('PKno'));
    sendFile(response, kLaz);
  });
  const fixture = await fetchFixture(t, server.base);
  assert.equal((await fixture.fetch(row(server.base))).length, 7);
  assert.deepEqual(
    fixture.store.squares.list({}).map(({ state }) => state),
    ['verified', 'missing', 'failed', 'verified', 'verified', 'verified', 'verified'],
  );
});

test('a square that waits for another try does not occupy a slot of its host', async (t) => {
  const served: string[] = [];
  const server = await serve(t, (request, response) => {
    served.push(request.url ?? '');
    if (request.url === '/TM_460_101.laz' && served.length < 7) return sendStatus(response, 500);
    sendFile(response, kLaz);
  });
  const fixture = await fetchFixture(t, server.base, { concurrency: 1, retries: 20 });
  // A wait ends when six other squares are there: with its place kept, it would wait forever.
  fixture.clock.sleep = async () => {
    while (fixture.store.squares.count({ states: ['verified'] }) < 6) {
      await new Promise((resolve) => setImmediate(resolve));
    }
  };
  const outcomes = await fixture.fetch(row(server.base));
  assert.equal(outcomes.filter(({ state }) => state === 'verified').length, 7);
  assert.equal(outcomes.at(-1)?.key.name, '460_101');
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
  const fixture = await fetchFixture(t, server.base, { concurrency: 1 });
  await assert.rejects(fixture.fetch(row(server.base), false, stop.signal), { message: 'stopped' });
  assert.equal(server.seen.length, 3);
  const before = fixture.store.squares.count({ states: ['verified'] });
  assert.ok(before <= 2);
  const outcomes = await fixture.resume();
  assert.equal(outcomes.length, 7 - before);
  assert.equal(fixture.store.squares.count({ states: ['verified'] }), 7);
});

test('a store that cannot be written ends the run before more is downloaded', async (t) => {
  const server = await serve(t, (_request, response) => sendFile(response, kLaz));
  const fixture = await fetchFixture(t, server.base);
  await writeFile(join(fixture.root, 'lidar'), 'a file where the folder should be');
  await assert.rejects(fixture.fetch(row(server.base)), {
    code: 'STORE_IO',
    message: /write .*lidar/,
  });
  assert.equal(server.seen.length, 0);
  await rm(join(fixture.root, 'lidar'));
  assert.equal((await fixture.resume()).length, 7);
});

test('an unknown address is looked for, in neighbouring blocks first, and recorded', async (t) => {
  const requests: string[] = [];
  const server = await serve(t, (request, response) => {
    requests.push(`${request.method ?? ''} ${request.url ?? ''}`);
    if (request.method === 'HEAD' && request.url === '/b_12/461_101') {
      return sendStatus(response, 405);
    }
    if (!(request.url ?? '').startsWith('/b_12')) return sendStatus(response, 404);
    sendFile(response, kLaz);
  });
  const fixture = await fetchFixture(t, server.base, {
    job: {
      locate: async (square, near, there, signal) => {
        for (const block of [...new Set([...near, 'b_11', 'b_12'])]) {
          const url = `${server.base}/${block}/${square.name}`;
          if (await there(url, signal)) return { ...square, block, urls: [url] };
        }
        return undefined;
      },
    },
  });
  await fixture.fetch([makeSquare('460_101', [`${server.base}/b_12/460_101`], { block: 'b_12' })]);
  requests.length = 0;
  const [outcome] = await fixture.fetch([makeSquare('461_101', [])]);
  assert.equal(outcome?.state, 'verified');
  assert.deepEqual(requests, ['HEAD /b_12/461_101', 'GET /b_12/461_101', 'GET /b_12/461_101']);
  const record = fixture.store.squares.get(toKey('461_101'));
  assert.deepEqual([record?.block, record?.urls], ['b_12', [`${server.base}/b_12/461_101`]]);
  const nowhere = await fetchFixture(t, server.base, {
    job: { locate: () => Promise.resolve(undefined) },
  });
  assert.equal(
    (await nowhere.fetch([makeSquare('999_999', [])], false, kNever))[0]?.state,
    'missing',
  );
});

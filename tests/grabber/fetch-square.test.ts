import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { readFile, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { fetchSquare } from '../../grabber/src/fetch/fetch-square.js';
import { Manifest } from '../../grabber/src/store/manifest.js';
import { sendFile, sendStatus, serve, type Handler } from './support/http-fixture.js';
import { makeLas, makeLaz } from './support/las-fixture.js';
import { fetchFixture, kNever, kSquare, storedFiles, type FixtureOptions } from './support/store-fixture.js';

const kLaz = makeLaz({ dataBytes: 200_000 });

test('a good file is stored under its square, hashed and recorded', async (t) => {
  const server = await serve(t, (_request, response) => sendFile(response, kLaz));
  const fixture = await fetchFixture(t, server.base);
  const outcome = await fetchSquare(kSquare, fixture, kNever);
  assert.equal(outcome.state, 'verified');
  assert.deepEqual(await storedFiles(fixture.store.root), ['lidar/test/462_101.laz']);
  assert.deepEqual(await readFile(join(fixture.store.root, 'lidar/test/462_101.laz')), kLaz);

  const [record] = (await Manifest.open(fixture.store.manifest, kNever)).records();
  assert.deepEqual(record, {
    source: 'test',
    square: '462_101',
    url: `${server.base}/TM_462_101.laz`,
    state: 'verified',
    crs: 'EPSG:3794',
    class_table: 'asprs',
    licence: 'CC BY 4.0',
    attribution: 'Somebody',
    file: {
      path: 'lidar/test/462_101.laz',
      bytes: kLaz.length,
      sha256: createHash('sha256').update(kLaz).digest('hex'),
      point_count: 10,
      las_version: '1.2',
      point_format: 1,
      bounds: { min: [462_000, 101_000, 280], max: [463_000, 102_000, 540.5] },
      fetched_at: '2026-06-21T12:00:00.000Z',
    },
    warnings: [],
    last_error: null,
  });
  assert.equal(server.seen[0]?.headers['user-agent'], 'terravox-grabber/test');
  assert.equal(server.seen[0]?.headers['accept-encoding'], 'identity');
});

test('a file without compression is stored as LAS, whatever its address says', async (t) => {
  const server = await serve(t, (_request, response) => sendFile(response, makeLas()));
  const fixture = await fetchFixture(t, server.base);
  assert.equal((await fetchSquare(kSquare, fixture, kNever)).state, 'verified');
  assert.deepEqual(await storedFiles(fixture.store.root), ['lidar/test/462_101.las']);
});

test('a verified file is not fetched again, by this run or the next', async (t) => {
  const server = await serve(t, (_request, response) => sendFile(response, kLaz));
  const fixture = await fetchFixture(t, server.base);
  await fetchSquare(kSquare, fixture, kNever);
  assert.equal((await fetchSquare(kSquare, fixture, kNever)).state, 'kept');
  const next = await fetchFixture(t, server.base, { root: fixture.store.root });
  assert.equal((await fetchSquare(kSquare, next, kNever)).state, 'kept');
  assert.equal(server.seen.length, 1);
  const again = await fetchFixture(t, server.base, { root: fixture.store.root, refetch: true });
  assert.equal((await fetchSquare(kSquare, again, kNever)).state, 'verified');
  assert.equal(server.seen.length, 2);
});

test('a verified file that was cut or lost since is fetched again', async (t) => {
  const server = await serve(t, (_request, response) => sendFile(response, kLaz));
  const fixture = await fetchFixture(t, server.base);
  await fetchSquare(kSquare, fixture, kNever);
  await writeFile(join(fixture.store.root, 'lidar/test/462_101.laz'), 'LASF');
  assert.equal((await fetchSquare(kSquare, fixture, kNever)).state, 'verified');
  assert.equal(server.seen.length, 2);
});

test('a failed refetch keeps the file that was verified before', async (t) => {
  const server = await serve(t, (_request, response, index) =>
    index === 0 ? sendFile(response, kLaz) : sendStatus(response, 403),
  );
  const fixture = await fetchFixture(t, server.base);
  await fetchSquare(kSquare, fixture, kNever);
  assert.equal((await fetchSquare(kSquare, { ...fixture, refetch: true }, kNever)).state, 'failed');
  const record = fixture.manifest.get('test', '462_101');
  assert.equal(record?.state, 'verified');
  assert.equal(record?.last_error?.code, 'HTTP_STATUS');
  assert.deepEqual(await storedFiles(fixture.store.root), ['lidar/test/462_101.laz']);
});

type BadAnswer = {
  name: string;
  answer: Handler;
  options?: FixtureOptions;
  state: 'failed' | 'missing';
  code?: string;
  message: RegExp;
  requests?: number;
};

const kBadAnswers: BadAnswer[] = [
  {
    name: 'an HTML page with status 200',
    answer: (_request, response) =>
      sendFile(response, Buffer.from('<html><title>Down\nfor repairs</title></html>'), { 'content-type': 'text/html' }),
    state: 'failed',
    code: 'HTML_BODY',
    message: /HTTP 200 but the body is an HTML page titled "Down for repairs"; allowed: a LAS or LAZ file/,
  },
  {
    name: 'an HTML page that calls itself LAZ',
    answer: (_request, response) =>
      sendFile(response, Buffer.from('\uFEFF <!DOCTYPE html><p>no</p>'), {
        'content-type': 'application/octet-stream',
      }),
    state: 'failed',
    code: 'HTML_BODY',
    message: /an HTML or XML page/,
  },
  {
    name: 'a ZIP file',
    answer: (_request, response) => sendFile(response, Buffer.from('PK\u0003\u0004rest')),
    state: 'failed',
    code: 'NOT_LAS',
    message: /starts with "PK/,
  },
  {
    name: 'an empty body',
    answer: (_request, response) => sendFile(response, Buffer.alloc(0)),
    state: 'failed',
    code: 'NOT_LAS',
    message: /0 bytes/,
  },
  {
    name: '404 as configured',
    answer: (_request, response) => sendStatus(response, 404),
    state: 'missing',
    message: /test has no square 462_101 \(HTTP 404\)/,
  },
  {
    name: '403 as configured',
    answer: (_request, response) => sendStatus(response, 403),
    options: { profile: { missing_status: [403, 404] } },
    state: 'missing',
    message: /HTTP 403/,
  },
  {
    name: '403 not configured',
    answer: (_request, response) => sendStatus(response, 403),
    state: 'failed',
    code: 'HTTP_STATUS',
    message: /HTTP 403; allowed: 200, or for "no such square": 404/,
  },
  {
    name: '500 to the end',
    answer: (_request, response) => sendStatus(response, 500),
    state: 'failed',
    code: 'HTTP_STATUS',
    message: /HTTP 500/,
    requests: 4,
  },
  {
    name: 'gzip although identity was asked for',
    answer: (_request, response) => sendFile(response, kLaz, { 'content-encoding': 'gzip' }),
    state: 'failed',
    code: 'HTTP_PROTOCOL',
    message: /Content-Encoding is gzip; allowed: identity/,
  },
  {
    name: 'a header cut off',
    answer: (_request, response) => sendFile(response, kLaz.subarray(0, 150)),
    state: 'failed',
    code: 'LAS_TRUNCATED',
    message: /the header needs 227/,
    requests: 4,
  },
  {
    name: 'a LAS with fewer points than it says',
    answer: (_request, response) => sendFile(response, makeLas({ claimedPoints: 5000 })),
    state: 'failed',
    code: 'LAS_TRUNCATED',
    message: /5000 point records/,
    requests: 4,
  },
  {
    name: 'a cut file whose server tells no length',
    answer: (_request, response) => {
      response.writeHead(200);
      response.end(kLaz.subarray(0, 5000));
    },
    state: 'failed',
    code: 'LAS_TRUNCATED',
    message: /the chunk table needs/,
    requests: 4,
  },
  {
    name: 'a longer body announced than sent',
    answer: (_request, response) => {
      response.writeHead(200, { 'content-length': String(kLaz.length + 10) });
      response.write(kLaz, () => response.destroy());
    },
    state: 'failed',
    code: 'NETWORK',
    message: /fetch http/,
    requests: 4,
  },
  {
    name: 'redirects in a circle',
    answer: (_request, response) => sendStatus(response, 302, { location: '/again' }),
    state: 'failed',
    code: 'REDIRECT',
    message: /more than 5 redirects/,
    requests: 6,
  },
  {
    name: 'a redirect to a file',
    answer: (_request, response) => sendStatus(response, 302, { location: 'file:///etc/passwd' }),
    state: 'failed',
    code: 'REDIRECT',
    message: /leads to file:/,
  },
];

test('a bad answer is reported for what it is, and leaves no file', async (t) => {
  for (const { name, answer, options, state, code, message, requests } of kBadAnswers) {
    await t.test(name, async (t) => {
      const server = await serve(t, answer);
      const fixture = await fetchFixture(t, server.base, options);
      const outcome = await fetchSquare(kSquare, fixture, kNever);
      assert.equal(outcome.state, state);
      assert.equal(outcome.state === 'failed' ? outcome.code : undefined, code);
      const shown = outcome.state === 'failed' ? outcome.message : outcome.state === 'missing' ? outcome.reason : '';
      assert.match(shown, message);
      assert.ok(!shown.includes('\n'), 'one line');
      assert.equal(server.seen.length, requests ?? 1);
      const files = await storedFiles(fixture.store.root);
      assert.deepEqual(
        files.filter((file) => !file.includes('.part')),
        [],
      );
      const record = fixture.manifest.get('test', '462_101');
      assert.equal(record?.state, state);
      assert.equal(record?.file, null);
      assert.equal(record?.last_error?.code, code);
    });
  }
});

test('a redirect is followed to the file', async (t) => {
  const server = await serve(t, (request, response) =>
    request.url === '/moved' ? sendFile(response, kLaz) : sendStatus(response, 301, { location: '/moved' }),
  );
  const fixture = await fetchFixture(t, server.base);
  assert.equal((await fetchSquare(kSquare, fixture, kNever)).state, 'verified');
});

test('a busy server is asked again when it said, and no earlier', async (t) => {
  const server = await serve(t, (_request, response, index) =>
    index === 0 ? sendStatus(response, 503, { 'retry-after': '7' }) : sendFile(response, kLaz),
  );
  const fixture = await fetchFixture(t, server.base);
  assert.equal((await fetchSquare(kSquare, fixture, kNever)).state, 'verified');
  assert.deepEqual(fixture.clock.slept_ms, [7000]);
});

test('a 429 without Retry-After backs off by itself', async (t) => {
  const server = await serve(t, (_request, response, index) =>
    index < 2 ? sendStatus(response, 429) : sendFile(response, kLaz),
  );
  const fixture = await fetchFixture(t, server.base);
  assert.equal((await fetchSquare(kSquare, fixture, kNever)).state, 'verified');
  assert.deepEqual(fixture.clock.slept_ms, [500, 1000]);
});

test('points in another place are kept, but said', async (t) => {
  const server = await serve(t, (_request, response) =>
    sendFile(response, makeLaz({ min: [0, 0, 0], max: [9, 9, 9] })),
  );
  const fixture = await fetchFixture(t, server.base);
  const outcome = await fetchSquare(kSquare, fixture, kNever);
  assert.equal(outcome.state, 'verified');
  assert.match(fixture.manifest.get('test', '462_101')?.warnings[0] ?? '', /lie elsewhere: x 0 to 9/);
});

test('without a configured source, a name from another address is a conflict', async (t) => {
  const server = await serve(t, (_request, response) => sendFile(response, kLaz));
  const first = await fetchFixture(t, server.base, { profile: { configured: false } });
  await fetchSquare(kSquare, first, kNever);
  const other = await fetchFixture(t, server.base, {
    root: first.store.root,
    profile: { configured: false },
    template: `${server.base}/other/{name}.laz`,
  });
  const outcome = await fetchSquare(kSquare, other, kNever);
  assert.equal(outcome.state === 'failed' && outcome.code, 'STORE_CONFLICT');
  assert.equal(other.manifest.get('test', '462_101')?.state, 'verified');
});

test('zLAS is refused before anything is downloaded', async (t) => {
  const server = await serve(t, (_request, response) => sendFile(response, kLaz));
  const fixture = await fetchFixture(t, server.base, { template: `${server.base}/{name}.zlas` });
  const outcome = await fetchSquare(kSquare, fixture, kNever);
  assert.equal(outcome.state === 'failed' && outcome.code, 'ZLAS_UNSUPPORTED');
  assert.equal(server.seen.length, 0);
});

import assert from 'node:assert/strict';
import { readFile, stat } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { sendPart, sendFile, sendRest, serve, type HttpFixture } from '../support/http-fixture.js';
import { makeLaz } from '../support/las-fixture.js';
import { computeSha256 } from '../support/record-fixture.js';
import {
  fetchFixture,
  kName,
  makeSquare,
  storedFiles,
  type Fixture,
  type FixtureOptions,
} from '../support/store-fixture.js';

const kLaz = makeLaz({ dataBytes: 300_000 });
const kNewer = makeLaz({ dataBytes: 300_000, max: [463_000, 102_000, 999] });
const kCutAt = 120_000;
const kEtag = '"v1"';

/** Breaks the connection when the first part is on disk. */
function cutting(server: HttpFixture): FixtureOptions {
  return { onStored: (bytes) => (bytes === kCutAt ? server.cut() : undefined) };
}

async function state(fixture: Fixture, server: HttpFixture): Promise<string | undefined> {
  return (await fixture.fetch([makeSquare(kName, [`${server.base}/a.laz`])]))[0]?.state;
}

async function assertStored(fixture: Fixture, body: Buffer): Promise<void> {
  assert.deepEqual(await storedFiles(fixture.root), ['lidar/test/462_101.laz']);
  assert.deepEqual(await readFile(join(fixture.root, 'lidar/test/462_101.laz')), body);
  assert.equal(fixture.record()?.file?.sha256, computeSha256(body));
}

test('a broken download continues where it stopped, by its ETag or else its date', async (t) => {
  const date = 'Sun, 21 Jun 2026 10:00:00 GMT';
  for (const [header, value] of [
    ['etag', kEtag],
    ['last-modified', date],
  ] as const) {
    const server = await serve(t, (request, response, index) =>
      index === 0
        ? sendPart(response, kLaz, kCutAt, { [header]: value })
        : sendRest(request, response, kLaz, value),
    );
    const fixture = await fetchFixture(t, server.base, cutting(server));
    assert.equal(await state(fixture, server), 'verified');
    await assertStored(fixture, kLaz);
    assert.deepEqual(fixture.retries, ['NETWORK']);
    assert.equal(server.seen[1]?.headers.range, `bytes=${kCutAt}-`);
    assert.equal(server.seen[1]?.headers['if-range'], value);
  }
});

test('a download broken in one run continues in the next', async (t) => {
  const server = await serve(t, (request, response, index) =>
    index === 0
      ? sendPart(response, kLaz, kCutAt, { etag: kEtag })
      : sendRest(request, response, kLaz, kEtag),
  );
  const first = await fetchFixture(t, server.base, { ...cutting(server), retries: 0 });
  assert.equal(await state(first, server), 'failed');
  assert.equal((await stat(join(first.root, 'lidar/test/.462_101.part'))).size, kCutAt);
  const second = await fetchFixture(t, server.base, { root: first.root });
  assert.equal(await state(second, server), 'verified');
  assert.equal(server.seen[1]?.headers.range, `bytes=${kCutAt}-`);
  await assertStored(second, kLaz);
});

test('a whole file in answer to Range replaces the part, never glued together', async (t) => {
  for (const [body, etag] of [
    [kLaz, kEtag],
    [kNewer, '"v2"'],
  ] as const) {
    const server = await serve(t, (_request, response, index) =>
      index === 0
        ? sendPart(response, kLaz, kCutAt, { etag: kEtag })
        : sendFile(response, body, { etag }),
    );
    const fixture = await fetchFixture(t, server.base, cutting(server));
    assert.equal(await state(fixture, server), 'verified');
    assert.match(server.seen[1]?.headers.range ?? '', /^bytes=/);
    await assertStored(fixture, body);
  }
});

test('nothing is continued that cannot be identified', async (t) => {
  const cases: [name: string, headers: Record<string, string>][] = [
    ['no ETag and no date', {}],
    ['a weak ETag', { etag: 'W/"v1"' }],
  ];
  for (const [name, headers] of cases) {
    await t.test(name, async (t) => {
      const server = await serve(t, (_request, response, index) =>
        index === 0 ? sendPart(response, kLaz, kCutAt, headers) : sendFile(response, kLaz),
      );
      const fixture = await fetchFixture(t, server.base, cutting(server));
      assert.equal(await state(fixture, server), 'verified');
      assert.equal(server.seen[1]?.headers.range, undefined);
      await assertStored(fixture, kLaz);
    });
  }
});

test('a wrong answer to Range starts anew', async (t) => {
  const cases: [name: string, status: number, range: string][] = [
    ['another start', 206, `bytes 5-${kLaz.length - 1}/${kLaz.length}`],
    ['another length', 206, 'bytes 120000-999999/1000000'],
    ['no Content-Range', 206, ''],
    ['range not satisfiable', 416, `bytes */${kLaz.length}`],
  ];
  for (const [name, status, range] of cases) {
    await t.test(name, async (t) => {
      const server = await serve(t, (request, response, index) => {
        if (index === 0) return sendPart(response, kLaz, kCutAt, { etag: kEtag });
        if (request.headers.range === undefined) return sendFile(response, kLaz);
        response.writeHead(status, range === '' ? {} : { 'content-range': range });
        response.end('x');
      });
      const fixture = await fetchFixture(t, server.base, cutting(server));
      assert.equal(await state(fixture, server), 'verified');
      assert.deepEqual(fixture.retries, ['NETWORK', 'RESUME_REFUSED']);
      assert.equal(server.seen[2]?.headers.range, undefined);
      await assertStored(fixture, kLaz);
    });
  }
});

test('a rest that comes in pieces is requested until the file is whole', async (t) => {
  const piece = 100_000;
  const server = await serve(t, (request, response, index) => {
    if (index === 0) return sendPart(response, kLaz, kCutAt, { etag: kEtag });
    const start = Number(/^bytes=(\d+)-$/.exec(request.headers.range ?? '')?.[1]);
    const end = Math.min(start + piece, kLaz.length);
    response.writeHead(206, {
      etag: kEtag,
      'content-length': String(end - start),
      'content-range': `bytes ${start}-${end - 1}/${kLaz.length}`,
    });
    response.end(kLaz.subarray(start, end));
  });
  const fixture = await fetchFixture(t, server.base, cutting(server));
  assert.equal(await state(fixture, server), 'verified');
  assert.deepEqual(fixture.retries, ['NETWORK', 'LENGTH']);
  assert.deepEqual(
    server.seen.map((seen) => seen.headers.range),
    [undefined, 'bytes=120000-', 'bytes=220000-'],
  );
  await assertStored(fixture, kLaz);
});

test('the rest of another file is never appended, however If-Range is handled', async (t) => {
  const cases: { name: string; first: Record<string, string>; second: Record<string, string> }[] = [
    { name: 'another ETag', first: { etag: '"v1"' }, second: { etag: '"v2"' } },
    { name: 'a weak ETag', first: { etag: '"v1"' }, second: { etag: 'W/"v1"' } },
    {
      name: 'another date',
      first: { 'last-modified': 'Sun, 21 Jun 2026 10:00:00 GMT' },
      second: { 'last-modified': 'Sun, 21 Jun 2026 11:00:00 GMT' },
    },
  ];
  for (const { name, first, second } of cases) {
    await t.test(name, async (t) => {
      const server = await serve(t, (request, response, index) => {
        if (index === 0) return sendPart(response, kLaz, kCutAt, first);
        if (request.headers.range === undefined) return sendFile(response, kNewer, second);
        response.writeHead(206, {
          ...second,
          'content-length': String(kNewer.length - kCutAt),
          'content-range': `bytes ${kCutAt}-${kNewer.length - 1}/${kNewer.length}`,
        });
        response.end(kNewer.subarray(kCutAt));
      });
      const fixture = await fetchFixture(t, server.base, cutting(server));
      assert.equal(await state(fixture, server), 'verified');
      assert.deepEqual(fixture.retries, ['NETWORK', 'RESUME_REFUSED']);
      await assertStored(fixture, kNewer);
    });
  }
});

import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { DataErrorKind } from '../../voxelserver/serve/page/src/http/errors.js';
import type { RangeFile } from '../../voxelserver/serve/page/src/viewer/data/range-file.js';
import { findGaps, planRanges } from '../../voxelserver/serve/page/src/viewer/data/range-plan.js';
import { catchKind, kindOfAsync } from './support/data-errors.js';
import {
  kOpen,
  type Handler,
  FakeHost,
  status,
  brokenBody,
  makePart,
} from './support/fake-host.js';

test('ranges are merged over small gaps, up to a size, and each is in one request', () => {
  const KiB = 1024;
  const gap = 64 * KiB;
  // Offsets and lengths, one after the other.
  const cases: [name: string, wanted: number[], requests: number[]][] = [
    ['none', [], []],
    ['a gap of 64 KiB', [0, 10, 10 + gap, 10], [0, 20 + gap]],
    ['a larger gap', [0, 10, 11 + gap, 10], [0, 10, 11 + gap, 10]],
    ['out of order, overlapping', [50, 50, 0, 60, 20, 10], [0, 100]],
    ['1 MiB', [0, 1000 * KiB, 1000 * KiB, 24 * KiB], [0, 1024 * KiB]],
    ['above', [0, 1000 * KiB, 1000 * KiB, 25 * KiB], [0, 1000 * KiB, 1000 * KiB, 25 * KiB]],
    ['a large one', [5, 3000 * KiB], [5, 3000 * KiB]],
  ];
  for (const [name, wanted, requests] of cases) {
    const ranges = wanted.flatMap((offset, i) =>
      i % 2 === 0 ? [{ offset, bytes: wanted[i + 1]! }] : [],
    );
    const plan = planRanges(ranges);
    const made = plan.flatMap(({ offset, bytes }) => [offset, bytes]);
    assert.deepEqual(made, requests, name);
    assert.equal(plan.flatMap((one) => one.ranges).length, ranges.length, name);
  }
});

test('what a request reads besides its ranges are the gaps between them', () => {
  const ranges = [
    { offset: 5, bytes: 10 },
    { offset: 7, bytes: 2 },
    { offset: 15, bytes: 5 },
    { offset: 30, bytes: 1 },
  ];
  assert.deepEqual(planRanges(ranges).map(findGaps), [[{ offset: 20, bytes: 10 }]]);
});

const kContent = Uint8Array.from({ length: 1000 }, (_, i) => i % 251);

const read = (host: FakeHost, file: RangeFile, offset: number, length: number) =>
  host.clock.finish(file.read(offset, length, kOpen));

test('a file is read by ranges, and its size is that of the first reply', async () => {
  const host = new FakeHost({ 'http://host/a': kContent });
  const file = host.file();
  assert.equal(file.size, undefined);
  assert.deepEqual(await host.clock.finish(file.head(64, kOpen)), kContent.subarray(0, 64));
  assert.equal(file.size, 1000);
  assert.deepEqual(await read(host, file, 900, 100), kContent.subarray(900));
  assert.equal((await read(host, file, 5, 0)).length, 0);
  assert.equal(await kindOfAsync(read(host, file, 900, 101)), 'cut');
  assert.deepEqual(host.http.stats, { requests: 2, bytes: 164 });
  assert.deepEqual(
    host.asked.map(({ init }) => init.headers),
    [{ Range: 'bytes=0-63' }, { Range: 'bytes=900-999', 'If-Match': '"one"' }],
  );
  const small = host.file();
  assert.equal((await host.clock.finish(small.head(5000, kOpen))).length, 1000);
});

test('what is kept or remembered of a file takes no request', async () => {
  const host = new FakeHost({ 'http://host/a': kContent });
  const file = host.file();
  file.keep(0, await host.clock.finish(file.head(10, kOpen)));
  file.keep(990, await read(host, file, 990, 10));
  file.remember(500, kContent.subarray(500, 520));
  assert.equal(host.asked.length, 2);
  const there = [
    [0, 10],
    [3, 2],
    [990, 10],
    [999, 1],
    [500, 20],
    [510, 5],
  ] as const;
  for (const [offset, length] of there) {
    assert.ok(file.has(offset, length), `${offset}`);
    const bytes = await read(host, file, offset, length);
    assert.deepEqual([...bytes], [...kContent.subarray(offset, offset + length)]);
  }
  assert.equal(host.asked.length, 2);
  for (const [offset, length] of [
    [9, 2],
    [989, 5],
    [499, 5],
    [515, 6],
  ] as const) {
    assert.ok(!file.has(offset, length), `${offset}`);
  }
  await read(host, file, 515, 6);
  assert.equal(host.asked.length, 3);
});

test('a file remembers up to 8 MiB: what came first leaves first', () => {
  const MiB = 1024 * 1024;
  const file = new FakeHost().file();
  for (let i = 0; i < 9; ++i) file.remember(i * MiB, new Uint8Array(MiB));
  assert.deepEqual(
    Array.from({ length: 9 }, (_, i) => file.has(i * MiB, MiB)),
    [false, true, true, true, true, true, true, true, true],
  );
  file.remember(50 * MiB, new Uint8Array(9 * MiB));
  assert.ok(!file.has(50 * MiB, MiB) && file.has(8 * MiB, MiB));
});

test('parts of a file are read as one', async () => {
  const host = new FakeHost();
  const parts = [400, 1, 599].map((bytes, i) => ({ url: `http://other/${i}`, bytes }));
  let start = 0;
  for (const { url, bytes } of parts) {
    host.files.set(url, kContent.subarray(start, start + bytes));
    start += bytes;
  }
  const file = host.file(parts);
  assert.equal(file.size, 1000);
  assert.deepEqual(await read(host, file, 390, 20), kContent.subarray(390, 410));
  assert.equal(host.asked.length, 3);
  assert.deepEqual(await read(host, file, 500, 7), kContent.subarray(500, 507));
  assert.equal(host.asked.length, 4);
  // A condition would take a preflight request on another origin.
  assert.deepEqual(host.asked[3]!.init.headers, { Range: 'bytes=99-105' });
  host.files.set('http://other/0', kContent.subarray(0, 399));
  assert.equal(await kindOfAsync(read(host, host.file(parts), 0, 5)), 'changed');
  assert.equal(
    catchKind(() => host.file([{ url: 'http://h/', bytes: 0 }])),
    'damaged',
  );
});

test('failures of a host have their kinds; only those that may pass are tried again', async () => {
  const ok = 'bytes 0-9/1000';
  const cases: [string, Handler, DataErrorKind, number][] = [
    ['404', status(404), 'missing', 1],
    ['401', status(401), 'refused', 1],
    ['403', status(403), 'refused', 1],
    ['400', status(400), 'refused', 1],
    ['412', status(412), 'changed', 1],
    ['416', status(416, { 'Content-Range': 'bytes */5' }), 'range', 1],
    ['204', status(204), 'no-range', 1],
    ['429', status(429), 'server', 3],
    ['500', status(500), 'server', 3],
    ['503', status(503), 'server', 3],
    ['no network', () => Promise.reject(new TypeError('failed')), 'cors', 3],
    ['no reply', () => new Promise<Response>(() => undefined), 'timeout', 3],
    ['a stalled body', () => makePart(brokenBody(3, 'hangs'), ok), 'timeout', 3],
    ['a lost connection', () => makePart(brokenBody(3, 'fails'), ok), 'cut', 3],
    ['a short body', () => makePart(brokenBody(3, 'ends'), ok), 'cut', 3],
    ['a long body', () => makePart(brokenBody(99, 'hangs'), ok), 'no-range', 1],
    ['no Content-Range', () => new Response('x', { status: 206 }), 'no-range', 1],
    ['another range', () => makePart('0123456789', 'bytes 1-10/1000'), 'range', 1],
    ['a longer range', () => makePart('01234567890', 'bytes 0-10/1000'), 'range', 1],
    ['no size', () => makePart('0123456789', 'bytes 0-9/*'), 'no-range', 1],
  ];
  for (const [name, handler, kind, attempts] of cases) {
    const host = new FakeHost();
    host.handler = handler;
    const found = host.clock.finish(host.file().head(10, kOpen));
    assert.equal(await kindOfAsync(found), kind, name);
    assert.equal(host.asked.length, attempts, name);
    const message = await found.catch((error: Error) => error.message);
    assert.match(String(message), /^fetch http:\/\/host\/a, bytes 0 to 9: [^\n]+$|^read/, name);
  }
});

test('waits between attempts grow, and are as long as Retry-After, up to a minute', async () => {
  const waitsWith = async (headers: Record<string, string>): Promise<number[]> => {
    const host = new FakeHost({ 'http://host/a': kContent });
    host.next.push(status(503, headers), status(429, headers));
    assert.equal((await host.clock.finish(host.file().head(10, kOpen))).length, 10);
    return host.clock.waits;
  };
  assert.deepEqual(await waitsWith({}), [500, 2000]);
  assert.deepEqual(await waitsWith({ 'Retry-After': '7' }), [7000, 7000]);
  assert.deepEqual(await waitsWith({ 'Retry-After': '3600' }), [60_000, 60_000]);
});

test('a host that ignores ranges is refused, and what it sends is not read', async () => {
  let isRead = false;
  const body = new ReadableStream({ pull: () => void (isRead = true) }, { highWaterMark: 0 });
  const host = new FakeHost();
  host.handler = () => new Response(body, { status: 200 });
  assert.equal(await kindOfAsync(host.clock.finish(host.file().head(64, kOpen))), 'no-range');
  assert.equal(isRead, false);
});

test('a file that changes ends reading for good, on any origin', async () => {
  const range = 'bytes 5-9/1000';
  const changes: [string, Handler][] = [
    ['another tag', () => makePart('56789', range, '"two"')],
    ['another size', () => makePart('56789', 'bytes 5-9/1001')],
    ['no tag', () => new Response('56789', { status: 206, headers: { 'Content-Range': range } })],
    ['412', status(412)],
    ['416 of a shorter file', status(416, { 'Content-Range': 'bytes */3', ETag: '"two"' })],
  ];
  for (const url of ['http://host/a', 'http://other/a']) {
    for (const [name, handler] of changes) {
      const host = new FakeHost({ [url]: kContent });
      const file = host.file(url);
      await host.clock.finish(file.head(64, kOpen));
      host.next.push(handler, handler);
      assert.equal(await kindOfAsync(read(host, file, 5, 5)), 'changed', `${url}: ${name}`);
      const asked = host.asked.length;
      assert.equal(await kindOfAsync(read(host, file, 5, 5)), 'changed', `${url}: ${name}`);
      assert.equal(host.asked.length, asked);
    }
  }
});

test('an outdated reply of the cache is requested again, past the cache', async () => {
  for (const [url, etag] of [
    ['http://other/a', '"one"'],
    ['http://host/a', 'W/"one"'],
  ] as const) {
    const host = new FakeHost({ [url]: kContent });
    host.etag = etag;
    const file = host.file(url);
    await host.clock.finish(file.head(64, kOpen));
    host.next.push(() => makePart('56789', 'bytes 5-9/1000', '"old"'));
    assert.deepEqual(await read(host, file, 5, 5), kContent.subarray(5, 10));
    const modes = host.asked.map(({ init }) => init.cache);
    assert.deepEqual(modes, ['no-store', 'default', 'reload']);
  }
});

test('weak tags are compared and not sent; a date stands in for a tag', async () => {
  const host = new FakeHost({ 'http://host/a': kContent });
  host.etag = 'W/"one"';
  const file = host.file();
  await host.clock.finish(file.head(64, kOpen));
  await read(host, file, 5, 5);
  assert.deepEqual(host.asked[1]!.init.headers, { Range: 'bytes=5-9' });
  const date = 'Sun, 06 Nov 1994 08:49:37 GMT';
  const dated = new FakeHost();
  dated.handler = (_, init) => {
    const [, from, to] = /(\d+)-(\d+)/.exec(new Headers(init.headers).get('Range')!)!;
    const body = kContent.slice(Number(from), Number(to) + 1);
    const headers = { 'Content-Range': `bytes ${from}-${to}/1000`, 'Last-Modified': date };
    return new Response(body, { status: 206, headers });
  };
  const other = dated.file();
  await dated.clock.finish(other.head(64, kOpen));
  await read(dated, other, 5, 5);
  const sent = dated.asked[1]!.init.headers;
  assert.deepEqual(sent, { Range: 'bytes=5-9', 'If-Unmodified-Since': date });
});

test('a cancelled read rejects with the reason and sends nothing more', async () => {
  const host = new FakeHost();
  host.handler = () => makePart(brokenBody(3, 'hangs'), 'bytes 0-9/1000');
  const controller = new AbortController();
  const reading = host.file().head(10, controller.signal);
  await new Promise((resolve) => setImmediate(resolve));
  controller.abort(new Error('enough'));
  await assert.rejects(reading, /enough/);
  await assert.rejects(host.file().head(10, controller.signal), /enough/);
  assert.equal(host.asked.length, 1);
});

import assert from 'node:assert/strict';
import { readFile, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { gzipSync } from 'node:zlib';
import type { CatalogueSquare, StoreRecord } from '../../../grabber/src/model/store.js';
import type { Outcome } from '../../../grabber/src/progress/reporter.js';
import { GrabberError } from '../../../grabber/src/util/errors.js';
import { sendFile, sendStatus, serve, type Handler } from '../support/http-fixture.js';
import { makeLas, makeLaz } from '../support/las-fixture.js';
import { kTerms, computeSha256 } from '../support/record-fixture.js';
import {
  fetchFixture,
  toKey,
  kName,
  makeSquare,
  storedFiles,
  type FixtureOptions,
} from '../support/store-fixture.js';

const kLaz = makeLaz({ dataBytes: 200_000 });
const kSha = computeSha256(kLaz);

function one(base: string, more: Partial<CatalogueSquare> = {}): CatalogueSquare[] {
  return [makeSquare(kName, [`${base}/TM_${kName}.laz`], more)];
}

test('a good file is stored under its square, hashed and recorded', async (t) => {
  const server = await serve(t, (_request, response) => sendFile(response, kLaz));
  const fixture = await fetchFixture(t, server.base);
  const [outcome] = await fixture.fetch(one(server.base));
  assert.equal(outcome?.state, 'verified');
  assert.deepEqual(await storedFiles(fixture.root), ['lidar/test/462_101.laz']);
  assert.deepEqual(await readFile(join(fixture.root, 'lidar/test/462_101.laz')), kLaz);
  const record = fixture.record();
  assert.equal(record?.state, 'verified');
  assert.equal(record.url, `${server.base}/TM_462_101.laz`);
  assert.deepEqual(record.file, {
    path: 'lidar/test/462_101.laz',
    bytes: kLaz.length,
    sha256: kSha,
  });
  assert.deepEqual(record.points, {
    pointCount: 10,
    lasVersion: '1.2',
    pointFormat: 1,
    min: [462_000, 101_000, 280],
    max: [463_000, 102_000, 540.5],
  });
  assert.deepEqual([record.warnings, record.lastError, record.licence], [[], null, 'CC BY 4.0']);
  assert.equal(server.seen[0]?.headers['user-agent'], 'terravox-grabber/test');
  assert.equal(server.seen[0]?.headers['accept-encoding'], 'identity');
});

test('a file without compression is stored as LAS, whatever the ending of its URL', async (t) => {
  const server = await serve(t, (_request, response) => sendFile(response, makeLas()));
  const fixture = await fetchFixture(t, server.base);
  await fixture.fetch(one(server.base));
  assert.deepEqual(await storedFiles(fixture.root), ['lidar/test/462_101.las']);
});

test('a verified file is not fetched again, but where that is wanted', async (t) => {
  const server = await serve(t, (_request, response, index) =>
    sendFile(response, index === 0 ? makeLas() : kLaz),
  );
  const fixture = await fetchFixture(t, server.base);
  await fixture.fetch(one(server.base));
  assert.deepEqual(await fixture.fetch(one(server.base)), []);
  assert.equal(server.seen.length, 1);
  assert.equal((await fixture.fetch(one(server.base), true))[0]?.state, 'verified');
  assert.equal(server.seen.length, 2);
  assert.deepEqual(
    await storedFiles(fixture.root),
    ['lidar/test/462_101.laz'],
    'the LAS of before is gone',
  );
});

test('a failed refetch keeps the file that was verified before', async (t) => {
  const answers: { name: string; answer: Handler }[] = [
    { name: 'refused', answer: (_, response) => sendStatus(response, 403) },
    { name: 'missing', answer: (_, response) => sendStatus(response, 404) },
    { name: 'bad', answer: (_, response) => sendFile(response, kLaz.subarray(0, 5000)) },
  ];
  for (const { name, answer } of answers) {
    await t.test(name, async (t) => {
      const server = await serve(t, (request, response, index) =>
        index === 0 ? sendFile(response, kLaz) : answer(request, response, index),
      );
      const fixture = await fetchFixture(t, server.base);
      await fixture.fetch(one(server.base));
      assert.notEqual((await fixture.fetch(one(server.base), true))[0]?.state, 'verified');
      const record = fixture.record();
      assert.equal(record?.state, 'verified');
      assert.equal(record.file?.sha256, kSha);
      assert.notEqual(record.lastError, null);
      assert.deepEqual(await storedFiles(fixture.root), ['lidar/test/462_101.laz']);
    });
  }
});

const file =
  (body: Buffer | string, headers: Record<string, string> = {}): Handler =>
  (_, response) =>
    sendFile(response, Buffer.from(body), headers);
const status =
  (code: number, headers: Record<string, string> = {}): Handler =>
  (_, response) =>
    sendStatus(response, code, headers);
const lengthless =
  (body: Buffer): Handler =>
  (_, response) =>
    void response.writeHead(200).end(body);
const breaksOff: Handler = (_, response) => {
  response.writeHead(200, { 'content-length': String(kLaz.length + 10) });
  response.write(kLaz, () => response.destroy());
};

const kGzip = { 'content-encoding': 'gzip' };
const kBomb = gzipSync(Buffer.concat([kLaz, Buffer.alloc(80_000_000)]));
const kPage = '<html><title>Down\nfor repairs</title></html>';
const kCallsItselfLaz = { 'content-type': 'application/octet-stream' };
const kSmall = { job: { max_bytes: 100_000 } };

/** A bad answer, how it is reported, and how often it is asked for. */
const kBadAnswers: [
  name: string,
  answer: Handler,
  code: string,
  message: RegExp,
  requests: number,
  more?: { options?: FixtureOptions; square?: Partial<CatalogueSquare> },
][] = [
  [
    'an HTML page with status 200',
    file(kPage, { 'content-type': 'text/html' }),
    'HTML_BODY',
    /HTTP 200 but the body is an HTML page titled "Down for repairs"; allowed: a LAS or LAZ file/,
    4,
  ],
  [
    'an HTML page that calls itself LAZ',
    file('\uFEFF <!DOCTYPE html><p>no</p>', kCallsItselfLaz),
    'HTML_BODY',
    /an HTML or XML page/,
    4,
  ],
  ['an empty body', file(''), 'NOT_LAS', /0 bytes/, 1],
  ['404 as configured', status(404), 'MISSING', /test has no square 462_101 \(HTTP 404\)/, 1],
  [
    '403 not configured',
    status(403),
    'HTTP_STATUS',
    /403; allowed: 200, or for "no such .*: 404/,
    1,
  ],
  ['500 to the end', status(500), 'HTTP_STATUS', /HTTP 500/, 4],
  [
    'an unknown encoding',
    file(kLaz, { 'content-encoding': 'br' }),
    'HTTP_PROTOCOL',
    /Content-Encoding is br; allowed: identity/,
    1,
  ],
  ['gzip that is none', file(kLaz, kGzip), 'HTTP_PROTOCOL', /incorrect header check/, 4],
  [
    'gzip that ends early',
    file(gzipSync(kLaz).subarray(0, -20), kGzip),
    'HTTP_PROTOCOL',
    /unexpected end of file/,
    4,
  ],
  ['a gzip bomb', file(kBomb, kGzip), 'TOO_LARGE', /have grown to \d+; allowed: 100 times/, 1],
  [
    'an announced length beyond the size limit',
    file(kLaz),
    'TOO_LARGE',
    /it has \d+ bytes or more; allowed: 100000 \(--max-file-gib\)/,
    1,
    { options: kSmall },
  ],
  [
    'a body without length beyond the size limit',
    lengthless(kLaz),
    'TOO_LARGE',
    /allowed: 100000/,
    1,
    { options: kSmall },
  ],
  [
    'a cut file whose server sends no length',
    lengthless(kLaz.subarray(0, 5000)),
    'LAS_TRUNCATED',
    /the chunk table needs/,
    4,
  ],
  ['a longer body announced than sent', breaksOff, 'NETWORK', /fetch http/, 4],
  [
    'another file than the catalogue has hashed',
    file(kLaz),
    'CHECKSUM',
    /SHA-256 is [0-9a-f]{64}; allowed: 0{64}, as its catalogue says/,
    4,
    { square: { sha256: '0'.repeat(64) } },
  ],
  [
    'redirects in a circle',
    status(302, { location: '/again' }),
    'REDIRECT',
    /more than 5 redirects/,
    6,
  ],
  ['a redirect to nowhere', status(302), 'REDIRECT', /leads to nowhere/, 1],
  [
    'a redirect to another host',
    status(302, { location: 'http://elsewhere.example/a.laz' }),
    'HOST_REFUSED',
    /host elsewhere.example is not one of its source's; allowed: 127\.0\.0\.1/,
    1,
  ],
];

function describeOutcome(outcome: Outcome): string {
  if (outcome.state === 'failed') return outcome.message;
  return outcome.state === 'missing' ? outcome.reason : '';
}

test('a bad answer is reported for what it is, and leaves no file', async (t) => {
  for (const [name, answer, code, message, requests, more] of kBadAnswers) {
    await t.test(name, async (t) => {
      const server = await serve(t, answer);
      const fixture = await fetchFixture(t, server.base, more?.options);
      const [outcome] = await fixture.fetch(one(server.base, more?.square));
      const state = code === 'MISSING' ? 'missing' : 'failed';
      assert.equal(outcome?.state, state);
      const shown = describeOutcome(outcome);
      assert.match(shown, message);
      assert.ok(!shown.includes('\n'), 'one line');
      assert.equal(server.seen.length, requests);
      assert.deepEqual(
        (await storedFiles(fixture.root)).filter((file) => !file.includes('.part')),
        [],
      );
      const record = fixture.record();
      assert.deepEqual([record?.state, record?.file], [state, null]);
      assert.equal(record?.lastError?.code, code);
    });
  }
});

test('a body that is compressed against the request is decompressed on the way', async (t) => {
  for (const coding of ['gzip', 'x-gzip']) {
    const server = await serve(t, (_request, response) =>
      sendFile(response, gzipSync(kLaz), { 'content-encoding': coding, etag: '"v1"' }),
    );
    const fixture = await fetchFixture(t, server.base);
    await fixture.fetch(one(server.base, { sha256: kSha }));
    assert.equal(fixture.record()?.file?.sha256, kSha, coding);
  }
});

test('a busy server is tried again after its Retry-After, or a growing wait', async (t) => {
  for (const [headers, slept_ms] of [
    [{ 'retry-after': '7' }, [7000]],
    [{}, [500, 1000]],
  ] as const) {
    const server = await serve(t, (_request, response, index) =>
      index < slept_ms.length ? sendStatus(response, 429, headers) : sendFile(response, kLaz),
    );
    const fixture = await fetchFixture(t, server.base);
    assert.equal((await fixture.fetch(one(server.base)))[0]?.state, 'verified');
    assert.deepEqual(fixture.clock.slept_ms, slept_ms);
  }
});

test('points in another place are kept, but said', async (t) => {
  const server = await serve(t, (_request, response) =>
    sendFile(response, makeLaz({ min: [0, 0, 0], max: [9, 9, 9] })),
  );
  const fixture = await fetchFixture(t, server.base);
  assert.equal((await fixture.fetch(one(server.base)))[0]?.state, 'verified');
  assert.match(fixture.record()?.warnings[0] ?? '', /lie elsewhere: x 0 to 9/);
});

test('mirrors are tried in order, and a square is missing only where all lack it', async (t) => {
  const cases: [name: string, a: number, b: number, state: string, seen: string[]][] = [
    ['the first has it', 200, 200, 'verified', ['/a']],
    ['the first has not', 404, 200, 'verified', ['/a', '/b']],
    ['the first is broken', 500, 200, 'verified', ['/a', '/a', '/b']],
    ['none has it', 404, 404, 'missing', ['/a', '/b']],
    ['one is broken and one has not', 500, 404, 'failed', ['/a', '/a', '/b']],
  ];
  for (const [name, a, b, state, seen] of cases) {
    await t.test(name, async (t) => {
      const server = await serve(t, (request, response) => {
        const status = request.url === '/a' ? a : b;
        if (status === 200) sendFile(response, kLaz);
        else sendStatus(response, status);
      });
      const fixture = await fetchFixture(t, server.base, { retries: 1 });
      const [outcome] = await fixture.fetch([
        makeSquare(kName, [`${server.base}/a`, `${server.base}/b`]),
      ]);
      assert.equal(outcome?.state, state);
      assert.deepEqual(
        server.seen.map(({ path }) => path),
        seen,
      );
    });
  }
});

test('zLAS is kept as it came, and waits for its conversion', async (t) => {
  const server = await serve(t, (_request, response) =>
    sendFile(response, Buffer.from('some bytes of zLAS')),
  );
  const fixture = await fetchFixture(t, server.base);
  const squares = [makeSquare(kName, [`${server.base}/${kName}.zlas`])];
  assert.equal((await fixture.fetch(squares))[0]?.state, 'fetched');
  assert.equal(fixture.record()?.state, 'fetched');
  assert.deepEqual(await storedFiles(fixture.root), ['lidar/test/462_101.zlas']);
  assert.equal((await fixture.resume())[0]?.state, 'fetched');
  assert.equal(server.seen.length, 1, 'it is not fetched again');
});

test('a conversion runs after the check', async (t) => {
  const server = await serve(t, (_request, response) => sendFile(response, kLaz));
  const seen: string[] = [];
  const convert = (record: StoreRecord): Promise<void> => {
    seen.push(`${record.key.name} ${record.state}`);
    return Promise.resolve();
  };
  await (await fetchFixture(t, server.base, { job: { convert } })).fetch(one(server.base));
  assert.deepEqual(seen, ['462_101 verified']);
});

test('a whole file that could not be converted is not fetched again', async (t) => {
  const server = await serve(t, (_request, response) =>
    sendFile(response, Buffer.from('ZLAS of which nobody knows more')),
  );
  const convert = (): Promise<void> =>
    Promise.reject(new GrabberError('CONVERTER', 'convert it: no'));
  const fixture = await fetchFixture(t, server.base, { job: { convert } });
  const square = [makeSquare(kName, [`${server.base}/${kName}.zlas`])];
  for (let times = 0; times < 2; ++times) {
    assert.equal((await fixture.fetch(square))[0]?.state, 'failed');
    assert.deepEqual(
      [fixture.record()?.state, fixture.record()?.lastError?.code],
      ['fetched', 'CONVERTER'],
    );
  }
  assert.equal(server.seen.length, 1);
});

test('a full disk stops the run before the download', async (t) => {
  const server = await serve(t, (_request, response) => sendFile(response, kLaz));
  const fixture = await fetchFixture(t, server.base, { freeBytes: () => 256 * 1024 * 1024 + 1000 });
  await assert.rejects(fixture.fetch(one(server.base)), {
    code: 'DISK_FULL',
    message: /it needs \d+ bytes, \d+ are free/,
  });
  assert.deepEqual(await storedFiles(fixture.root), []);
});

test('a finished file without its record is adopted when it is the expected one', async (t) => {
  const bytes = kLaz.length;
  const another = makeLaz({ dataBytes: 200_000, max: [463_000, 102_000, 1000] });
  const cases: [name: string, more: Partial<CatalogueSquare>, body: Buffer, requests: number][] = [
    ['its hash is known', { sha256: kSha }, kLaz, 0],
    ['its length is known', { bytes }, kLaz, 0],
    ['nothing is known of it', {}, kLaz, 1],
    ['its hash is another', { sha256: kSha }, another, 1],
    ['it is damaged', { bytes }, Buffer.alloc(bytes), 1],
  ];
  for (const [name, more, body, requests] of cases) {
    await t.test(name, async (t) => {
      const server = await serve(t, (_request, response) => sendFile(response, kLaz));
      const failing = await serve(t, (_request, response) => sendStatus(response, 403));
      const fixture = await fetchFixture(t, server.base);
      await fixture.fetch(one(failing.base, more));
      await writeFile(join(fixture.root, 'lidar/test/462_101.laz'), body);
      const key = toKey(kName);
      fixture.store.squares.learn('test', 'test', null, kTerms, one(server.base, more));
      fixture.store.squares.want([key]);
      fixture.store.squares.begin(key, `${server.base}/TM_462_101.laz`);
      assert.equal((await fixture.resume())[0]?.state, 'verified');
      assert.equal(server.seen.length, requests);
      assert.equal(fixture.record()?.file?.sha256, kSha);
    });
  }
});

test('a run that was killed after the check fetches nothing again', async (t) => {
  for (const place of ['.462_101.part', '462_101.laz']) {
    await t.test(`the file is still ${place}`, async (t) => {
      const server = await serve(t, (_request, response) => sendFile(response, kLaz));
      const fixture = await fetchFixture(t, server.base);
      await fixture.fetch(one(server.base), false);
      const key = toKey(kName);
      fixture.store.squares.want([key], true);
      fixture.store.squares.begin(key, 'x');
      fixture.store.squares.fetched(key, {
        path: 'lidar/test/462_101.laz',
        bytes: kLaz.length,
        sha256: kSha,
      });
      await writeFile(join(fixture.root, 'lidar/test', place), kLaz);
      if (place.endsWith('.part')) {
        await writeFile(join(fixture.root, 'lidar/test/462_101.laz'), 'older');
      }
      assert.equal((await fixture.resume())[0]?.state, 'verified');
      assert.equal(server.seen.length, 1);
      assert.deepEqual(await storedFiles(fixture.root), ['lidar/test/462_101.laz']);
      assert.deepEqual(await readFile(join(fixture.root, 'lidar/test/462_101.laz')), kLaz);
    });
  }
});

import assert from 'node:assert/strict';
import type { ServerResponse } from 'node:http';
import { test, type TestContext } from 'node:test';
import { createHttpClient, type HttpClient } from '../../../grabber/src/fetch/http-client.js';
import type { Clock } from '../../../grabber/src/util/clock.js';
import { fakeClock, kNever } from '../support/store-fixture.js';
import { kHere, kNoListener, sendFile, serve } from '../support/http-fixture.js';

/** A body that never ends, a byte at a time. */
function trickle(
  response: ServerResponse,
  status: number,
  headers: Record<string, string> = {},
): void {
  response.writeHead(status, headers);
  const timer = setInterval(() => response.write('x'), 2);
  response.on('close', () => clearInterval(timer));
}

function clientWith(t: TestContext, timeout_ms: number, clock?: Clock): HttpClient {
  const http = createHttpClient({
    userAgent: 'terravox-grabber/test',
    timeout_ms,
    access: kHere,
    ...(clock === undefined ? {} : { clock }),
  });
  t.after(() => http.close());
  return http;
}

/** For servers that fall silent. */
const impatient = (t: TestContext): HttpClient => clientWith(t, 200);
/** For those that answer, however loaded the machine is. */
const slowTimeout = (t: TestContext): HttpClient => clientWith(t, 300_000);

async function readAll(body: AsyncIterable<Uint8Array>): Promise<number> {
  let bytes = 0;
  for await (const chunk of body) bytes += chunk.length;
  return bytes;
}

test('a server that never answers is given up on', async (t) => {
  const server = await serve(t, () => undefined);
  await assert.rejects(impatient(t).get(server.base, {}, kNever), {
    code: 'NETWORK',
    retryable: true,
    message: /Headers Timeout/,
  });
});

test('a server that falls silent in the middle of a body is given up on', async (t) => {
  const server = await serve(t, (_request, response) => {
    response.writeHead(200, { 'content-length': '100' });
    response.write('x');
  });
  const response = await impatient(t).get(server.base, {}, kNever);
  await assert.rejects(readAll(response.body), {
    code: 'NETWORK',
    retryable: true,
    message: /Body Timeout/,
  });
});

test('a server that is not there is a network error that names the address', async (t) => {
  await assert.rejects(slowTimeout(t).get(`${kNoListener}/a.laz`, {}, kNever), {
    code: 'NETWORK',
    message: /fetch http:\/\/127\.0\.0\.1:1\/a\.laz: .*ECONNREFUSED/,
  });
});

test('a stop is passed on as what it is, before the answer and within the body', async (t) => {
  const stop = new AbortController();
  const silent = await serve(t, () => stop.abort(new Error('stopped')));
  await assert.rejects(slowTimeout(t).get(silent.base, {}, stop.signal), { message: 'stopped' });

  const later = new AbortController();
  const halting = await serve(t, (_request, response) => {
    response.writeHead(200, { 'content-length': '100' });
    response.write('x');
  });
  const response = await slowTimeout(t).get(halting.base, {}, later.signal);
  later.abort(new Error('stopped later'));
  await assert.rejects(readAll(response.body), { message: 'stopped later' });
});

test('a body that trickles is given up on, in every way of reading it', async (t) => {
  const server = await serve(t, (_request, response) => trickle(response, 200));
  const clock = fakeClock();
  // Each call finds the clock 50 s later.
  const now = (): Date => {
    void clock.sleep(50_000, kNever);
    return clock.now();
  };
  const http = clientWith(t, 20_000, { ...clock, now });
  const response = await http.get(server.base, {}, kNever);
  await assert.rejects(readAll(response.body), {
    code: 'TOO_SLOW',
    retryable: true,
    message: /allowed: at least 512/,
  });
});

test('a dropped body is not waited for', async (t) => {
  const server = await serve(t, (request, response) => {
    if (request.url === '/moved') return trickle(response, 302, { location: '/file' });
    if (request.url === '/file') return sendFile(response, Buffer.from('here'));
    trickle(response, 404);
  });
  // Without an end to the wait, each of these would last for ever.
  const http = createHttpClient({
    userAgent: 'terravox-grabber/test',
    timeout_ms: 20_000,
    access: kHere,
  });
  t.after(() => http.close());
  await (await http.get(`${server.base}/none`, {}, kNever)).discard();
  assert.equal(await readAll((await http.get(`${server.base}/moved`, {}, kNever)).body), 4);
});

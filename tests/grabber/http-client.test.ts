import assert from 'node:assert/strict';
import { test, type TestContext } from 'node:test';
import { createHttpClient, type HttpClient } from '../../grabber/src/fetch/http-client.js';
import { serve } from './support/http-fixture.js';
import { kNever } from './support/store-fixture.js';

function impatient(t: TestContext): HttpClient {
  const http = createHttpClient({ userAgent: 'terravox-grabber/test', timeout_ms: 200, access: { hosts: ['127.0.0.1'], allowPrivate: true, secretHeaders: {} } });
  t.after(() => http.close());
  return http;
}

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
  await assert.rejects(readAll(response.body), { code: 'NETWORK', retryable: true, message: /Body Timeout/ });
});

test('a server that is not there is a network error that names the address', async (t) => {
  // Port 1 is reserved and nobody listens on it.
  await assert.rejects(impatient(t).get('http://127.0.0.1:1/a.laz', {}, kNever), {
    code: 'NETWORK',
    message: /fetch http:\/\/127\.0\.0\.1:1\/a\.laz: .*ECONNREFUSED/,
  });
});

test('a stop is passed on as what it is, before the answer and within the body', async (t) => {
  const stop = new AbortController();
  const silent = await serve(t, () => stop.abort(new Error('stopped')));
  await assert.rejects(impatient(t).get(silent.base, {}, stop.signal), { message: 'stopped' });

  const later = new AbortController();
  const halting = await serve(t, (_request, response) => {
    response.writeHead(200, { 'content-length': '100' });
    response.write('x');
  });
  const response = await impatient(t).get(halting.base, {}, later.signal);
  later.abort(new Error('stopped later'));
  await assert.rejects(readAll(response.body), { message: 'stopped later' });
});

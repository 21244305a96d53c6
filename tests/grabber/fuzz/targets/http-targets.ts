import assert from 'node:assert/strict';
import { deflateSync, gzipSync } from 'node:zlib';
import * as fc from 'fast-check';
import { decoded } from '../../../../grabber/src/fetch/body-writer.js';
import { addressAllowed, checkUrl } from '../../../../grabber/src/fetch/host-policy.js';
import type { Resumable } from '../../../../grabber/src/fetch/partial.js';
import {
  bodyPlan,
  isWhole,
  htmlError,
  statusError,
} from '../../../../grabber/src/fetch/response-check.js';
import { parseRetryAfter } from '../../../../grabber/src/fetch/retry.js';
import { arrived, arbitraryDamage } from '../damage.js';
import { acceptedOrRefused, makeResponse, type Target, target } from './target.js';

/** Values of headers as servers send them, nearly as they send them, and anything else. */
const headerValue = fc.oneof(
  fc.string({ maxLength: 60 }),
  fc.string({ unit: 'binary', maxLength: 60 }),
  fc.integer().map(String),
  fc.double().map(String),
  fc.date({ noInvalidDate: false }).map(String),
  fc.date().map((date) => date.toUTCString()),
  fc
    .tuple(fc.nat(), fc.nat(), fc.oneof(fc.nat().map(String), fc.constant('*')))
    .map(([a, b, c]) => `bytes ${a}-${b}/${c}`),
  fc.constantFrom(
    'gzip',
    'deflate',
    'identity',
    'br',
    '"tag"',
    'text/html',
    'bytes */5',
    'bytes 5-9/10',
  ),
);

const kHeaders = [
  'content-length',
  'content-range',
  'content-encoding',
  'content-type',
  'etag',
  'last-modified',
  'retry-after',
  'location',
] as const;

const headers = fc.dictionary(fc.constantFrom(...kHeaders), headerValue, {
  maxKeys: kHeaders.length,
});

export function httpTargets(): Target[] {
  const now = new Date('2026-06-21T12:00:00Z');
  const url = 'https://h.example/a.laz';
  const retryAfter = target('retry-after', 2000, headerValue, (value) => {
    const wait_ms = parseRetryAfter(value, now);
    if (wait_ms !== undefined) {
      assert.ok(Number.isFinite(wait_ms) && wait_ms >= 0, `waits ${wait_ms} ms`);
    }
  });
  const status = fc.constantFrom(200, 206, 404, 416, 429, 500, 503);
  const part: Resumable = { url, offset_bytes: 5, if_range: '"tag"', total_bytes: 10 };
  const responses = target(
    'http-headers',
    2000,
    fc.tuple(status, headers, fc.boolean(), fc.uint8Array()),
    async ([code, values, resumed, start]) => {
      const response = makeResponse(code, values);
      const resumable = resumed ? part : undefined;
      const plan = await acceptedOrRefused(['HTTP_PROTOCOL', 'RESUME_REFUSED'], () =>
        bodyPlan(url, response, resumable),
      );
      if (plan !== undefined) {
        assert.ok(plan.offset_bytes === 0 || plan.offset_bytes === part.offset_bytes);
        assert.ok(plan.total_bytes === undefined || Number.isSafeInteger(plan.total_bytes));
      }
      isWhole(response, part);
      const wait_ms = statusError(url, response, [404], now).retryAfterMs;
      assert.ok(wait_ms === undefined || (Number.isFinite(wait_ms) && wait_ms >= 0));
      htmlError(url, response, start, (text) => text);
    },
  );
  const text = Buffer.from('points '.repeat(500));
  const packed = [gzipSync(text), deflateSync(text)];
  const codings = target('content-coding', 200, arbitraryDamage(packed.length), (input) =>
    acceptedOrRefused(['HTTP_PROTOCOL', 'TOO_LARGE'], async () => {
      const body = makeResponse(200, {}, arrived(packed, input)).body;
      let bytes = 0;
      for await (const piece of decoded(body, input.base === 0 ? 'gzip' : 'deflate', url)) {
        bytes += piece.length;
      }
      return bytes;
    }),
  );
  return [retryAfter, responses, codings, addressTarget()];
}

function addressTarget(): Target {
  const access = {
    hosts: ['data.example', '127.0.0.1', 'files.example:8080'],
    privateOrigins: ['http://127.0.0.1:8000'],
  };
  const hosts = '127.0.0.1 0x7f.1 2130706433 [::1] [::ffff:127.0.0.1] data.example files.example';
  const signs = 'http: https: file: // / \\ @ : . ? # %2f 。 １ 8000 8080 user localhost';
  const part = fc.constantFrom(...hosts.split(' '), ...signs.split(' '), '\t', '\n');
  const address = fc.oneof(
    fc.webUrl(),
    fc
      .array(fc.oneof(part, fc.string({ maxLength: 4 })), { maxLength: 8 })
      .map((parts) => parts.join('')),
  );
  return target('address', 3000, address, async (text) => {
    const url = await acceptedOrRefused(['HOST_REFUSED'], () => checkUrl(text, access));
    if (url === undefined) return;
    assert.ok(
      ['http:', 'https:'].includes(url.protocol) && url.username === '' && url.password === '',
    );
    assert.ok(access.hosts.includes(url.hostname) || access.hosts.includes(url.host), url.href);
    if (/^[\d.]+$|^\[/.test(url.hostname)) {
      assert.ok(
        access.privateOrigins.includes(url.origin) && addressAllowed(url.hostname, true),
        url.href,
      );
    }
  });
}

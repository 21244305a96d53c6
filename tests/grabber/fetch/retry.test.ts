import assert from 'node:assert/strict';
import { test } from 'node:test';
import { HostRateLimiter } from '../../../grabber/src/fetch/host-queues.js';
import { backoffMs, parseRetryAfter, withRetries } from '../../../grabber/src/fetch/retry.js';
import { kSystemClock } from '../../../grabber/src/util/clock.js';
import { GrabberError } from '../../../grabber/src/util/errors.js';
import { seededRandom } from '../portal/pattern.js';
import { fakeClock, kNever } from '../support/store-fixture.js';

const kPolicy = { retries: 3, base_ms: 1000, cap_ms: 5000, max_wait_ms: 60_000 };
const kIgnore = (): void => undefined;

test('the backoff is any part of a time that doubles up to its cap', () => {
  const random = seededRandom(7);
  const sums = new Map<number, number>();
  for (let round = 0; round < 2000; ++round) {
    const attempt = Math.floor(random() * 60);
    const drawn = random();
    const whole = Math.min(kPolicy.cap_ms, kPolicy.base_ms * 2 ** attempt);
    const wait = backoffMs(attempt, kPolicy, drawn);
    assert.ok(
      wait >= 0 && wait <= whole,
      `attempt ${attempt}, random ${drawn}: ${wait} of ${whole}`,
    );
    sums.set(whole, (sums.get(whole) ?? 0) + wait / whole);
  }
  assert.equal(backoffMs(0, kPolicy, 0), 0);
  assert.equal(backoffMs(1, kPolicy, 0.5), 1000);
  assert.equal(backoffMs(1023, kPolicy, 0.999), 4995);
  const mean = [...sums.values()].reduce((a, b) => a + b, 0) / 2000;
  assert.ok(mean > 0.45 && mean < 0.55, `mean part ${mean}`);
});

test('retries start anew when an attempt got further', async () => {
  const clock = fakeClock('2026-06-21T12:00:00.000Z', 0.5);
  let calls = 0;
  const attempt = (): Promise<string> => {
    calls += 1;
    return calls < 10
      ? Promise.reject(new GrabberError('NETWORK', `call ${calls}`, { retryable: true }))
      : Promise.resolve('whole');
  };
  assert.equal(
    await withRetries(attempt, { ...kPolicy, retries: 1 }, clock, kIgnore, kNever, () => true),
    'whole',
  );
  assert.deepEqual([...new Set(clock.slept_ms)], [500]);
});

test('requests to a host with a rate are kept apart', async () => {
  const clock = fakeClock();
  const limiter = new HostRateLimiter(clock, 60_000);
  for (let request = 0; request < 4; ++request) await limiter.acquire('a.example', kNever, 2);
  await limiter.acquire('b.example', kNever, 2);
  assert.deepEqual(clock.slept_ms, [500, 500, 500]);
});

test('Retry-After is read as seconds or as a date', () => {
  const now = new Date('2026-06-21T12:00:00Z');
  const cases: [value: string | undefined, ms: number | undefined][] = [
    ['120', 120_000],
    ['0', 0],
    ['Sun, 21 Jun 2026 12:00:30 GMT', 30_000],
    ['Sun, 21 Jun 2026 11:00:00 GMT', 0],
    ['soon', undefined],
    [undefined, undefined],
  ];
  for (const [value, ms] of cases) assert.equal(parseRetryAfter(value, now), ms, value);
});

test('temporary errors are tried again until the retries are used up', async () => {
  const clock = fakeClock('2026-06-21T12:00:00.000Z', 0.5);
  let calls = 0;
  const failing = (): Promise<never> => {
    ++calls;
    return Promise.reject(new GrabberError('NETWORK', `call ${calls}`, { retryable: true }));
  };
  await assert.rejects(withRetries(failing, kPolicy, clock, kIgnore, kNever), {
    message: 'call 4',
  });
  assert.deepEqual(clock.slept_ms, [500, 1000, 2000]);
});

test('lasting errors are not tried again', async () => {
  const clock = fakeClock();
  const failing = (): Promise<never> => Promise.reject(new GrabberError('HTML_BODY', 'page'));
  await assert.rejects(withRetries(failing, kPolicy, clock, kIgnore, kNever), {
    code: 'HTML_BODY',
  });
  assert.deepEqual(clock.slept_ms, []);
});

test('a stop ends the retries', async () => {
  const stop = new AbortController();
  const failing = (): Promise<never> =>
    Promise.reject(new GrabberError('NETWORK', 'x', { retryable: true }));
  const run = withRetries(
    failing,
    kPolicy,
    fakeClock(),
    () => stop.abort(new Error('stopped')),
    stop.signal,
  );
  await assert.rejects(run, { message: 'stopped' });
});

test('Retry-After of a host delays all requests to it', async () => {
  const clock = fakeClock();
  const limiter = new HostRateLimiter(clock, 60_000);
  limiter.pause('a.example', 20_000);
  limiter.pause('a.example', 5_000);
  await limiter.acquire('b.example', kNever);
  assert.deepEqual(clock.slept_ms, []);
  await limiter.acquire('a.example', kNever);
  assert.deepEqual(clock.slept_ms, [20_000]);
  await limiter.acquire('a.example', kNever);
  assert.deepEqual(clock.slept_ms, [20_000]);
});

test('too long a Retry-After fails the request at once', async () => {
  const clock = fakeClock();
  const limiter = new HostRateLimiter(clock, 60_000);
  limiter.pause('a.example', 3_600_000);
  await assert.rejects(limiter.acquire('a.example', kNever), {
    code: 'RETRY_AFTER_TOO_LONG',
    message: /3600 s; allowed: at most 60 s/,
  });
  assert.deepEqual(clock.slept_ms, []);
});

test('a request with too long a Retry-After is not retried, and does not wait', async () => {
  const clock = fakeClock();
  const notices: number[] = [];
  const retryAfter = (ms: number) => () =>
    Promise.reject(
      new GrabberError('HTTP_STATUS', 'fetch a: HTTP 503', { retryable: true, retryAfterMs: ms }),
    );
  await assert.rejects(
    withRetries(retryAfter(60_001), kPolicy, clock, ({ wait_ms }) => notices.push(wait_ms), kNever),
    {
      code: 'RETRY_AFTER_TOO_LONG',
      message: /fetch a: HTTP 503: .*wait for 61 s; allowed: at most 60 s \(--max-wait-s\)/,
    },
  );
  assert.deepEqual([clock.slept_ms, notices], [[], []]);
  await assert.rejects(withRetries(retryAfter(60_000), kPolicy, clock, kIgnore, kNever), {
    code: 'HTTP_STATUS',
  });
  assert.deepEqual(clock.slept_ms, [60_000, 60_000, 60_000]);
});

test('a sleep longer than a timer can count is no shorter', async () => {
  const stop = new AbortController();
  const sleeping = kSystemClock.sleep(2 ** 31 + 5, stop.signal);
  setTimeout(() => stop.abort(new Error('still asleep')), 50);
  await assert.rejects(sleeping, { message: 'still asleep' });
});

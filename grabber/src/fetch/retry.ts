import type { Clock } from '../util/clock.js';
import { GrabberError } from '../util/errors.js';

export type RetryPolicy = {
  /** Tries after the first one, 0 or more. */
  readonly retries: number;
  readonly base_ms: number;
  readonly cap_ms: number;
  /** Longest Retry-After to obey; a longer one ends the retries. */
  readonly max_wait_ms: number;
};

export const kBackoff = { base_ms: 1000, cap_ms: 60_000, max_wait_ms: 600_000 } as const;

/**
 * A random part of a time that doubles from `base_ms` up to `cap_ms`: many clients that failed
 * together come back spread over all of that time. Ref: Brooker, "Exponential Backoff And Jitter",
 * 2015 (there "full jitter").
 * @param attempt 0 for the first retry
 * @param random  in [0, 1)
 */
export function backoffMs(
  attempt: number,
  policy: Pick<RetryPolicy, 'base_ms' | 'cap_ms'>,
  random: number,
): number {
  return Math.round(Math.min(policy.cap_ms, policy.base_ms * 2 ** attempt) * random);
}

/**
 * @return milliseconds from `now`, or undefined when the header holds neither seconds nor a date
 */
export function parseRetryAfter(value: string | undefined, now: Date): number | undefined {
  if (value === undefined) return undefined;
  if (/^\s*\d{1,9}\s*$/.test(value)) return Number(value) * 1000;
  const date = Date.parse(value);
  return Number.isNaN(date) ? undefined : Math.max(0, date - now.getTime());
}

export type RetryNotice = {
  readonly error: GrabberError;
  readonly retry: number;
  readonly wait_ms: number;
};

/**
 * Runs `attempt` until it succeeds, fails for good, or the retries are used up; then throws its
 * last error.
 * @param advanced whether the last attempt got further than all before it, as a resumed download
 *   does; then the count of retries starts anew, so that a large file arrives over a bad line
 */
export async function withRetries<T>(
  attempt: () => Promise<T>,
  policy: RetryPolicy,
  clock: Clock,
  notify: (notice: RetryNotice) => void,
  signal: AbortSignal,
  advanced: () => boolean = () => false,
): Promise<T> {
  for (let retry = 0; ; ++retry) {
    signal.throwIfAborted();
    try {
      return await attempt();
    } catch (error) {
      signal.throwIfAborted();
      if (!(error instanceof GrabberError) || !error.retryable) throw error;
      if (advanced()) retry = 0;
      if (retry >= policy.retries) throw error;
      checkWait(error, policy.max_wait_ms);
      const wait_ms = Math.max(error.retryAfterMs ?? 0, backoffMs(retry, policy, clock.random()));
      notify({ error, retry: retry + 1, wait_ms });
      await clock.sleep(wait_ms, signal);
    }
  }
}

function checkWait({ message, retryAfterMs = 0 }: GrabberError, max_wait_ms: number): void {
  if (retryAfterMs > max_wait_ms) throw tooLongWait(message, retryAfterMs, max_wait_ms);
}

export function tooLongWait(attempt: string, wait_ms: number, max_wait_ms: number): GrabberError {
  return new GrabberError(
    'RETRY_AFTER_TOO_LONG',
    `${attempt}: the server asks to wait for ${Math.ceil(wait_ms / 1000)} s; allowed: at ` +
      `most ${max_wait_ms / 1000} s (--max-wait-s)`,
  );
}

import { wait, type Environment } from './environment.js';
import { DataError, type DataErrorKind } from './errors.js';

/** When what failed is tried again: requests after errors that may pass, and polls after all. */

const kWaitsMs = [500, 2000];
const kMaxRetryAfterMs = 60_000;
const kMaxPollTimes = 10;
const kPassing: ReadonlySet<DataErrorKind> = new Set(['cors', 'cut', 'timeout', 'server']);

/**
 * Calls `attempt` up to three times, with growing waits, while it throws errors of the network, 429
 * or 5xx. A `Retry-After` of up to a minute lengthens the wait.
 * @throws what the last attempt threw, or the reason of `signal`
 */
export async function withRetries<T>(
  environment: Environment,
  signal: AbortSignal,
  attempt: () => Promise<T>,
): Promise<T> {
  for (let attempts = 1; ; ++attempts) {
    try {
      return await attempt();
    } catch (error) {
      const waitMs = waitBeforeRetry(environment, error, attempts);
      if (waitMs === undefined) throw error;
      await wait(environment.clock, waitMs, signal);
    }
  }
}

/**
 * @param attempts how many were made
 * @return undefined: no further attempt
 */
export function waitBeforeRetry(
  environment: Environment,
  error: unknown,
  attempts: number,
): number | undefined {
  const waitMs = kWaitsMs[attempts - 1];
  if (waitMs === undefined || !mayPass(error)) return undefined;
  const spread = waitMs * (0.75 + environment.random() / 2);
  return Math.max(spread, Math.min(error.retryAfterMs, kMaxRetryAfterMs));
}

/** Whether an error of the network, 429 or 5xx, which another attempt may not meet. */
export const mayPass = (error: unknown): error is DataError =>
  error instanceof DataError && kPassing.has(error.kind);

/** How long a poll waits after so many failures in a row: up to ten times as long as otherwise. */
export function pollWaitMs(error: unknown, everyMs: number, failures: number): number {
  const waitMs = everyMs * Math.min(kMaxPollTimes, 1 + failures);
  return mayPass(error) ? Math.max(waitMs, Math.min(error.retryAfterMs, kMaxRetryAfterMs)) : waitMs;
}

/** Of `Retry-After`: seconds or a date, as ms from now; 0 where there is none. */
export function retryAfterMs(headers: Headers, nowMs: number): number {
  const text = headers.get('Retry-After') ?? '';
  if (/^\d{1,9}$/.test(text)) return Number(text) * 1000;
  const date = Date.parse(text);
  return Number.isNaN(date) ? 0 : Math.max(0, date - nowMs);
}

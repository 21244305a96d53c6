import PQueue from 'p-queue';
import type { Clock } from '../util/clock.js';
import { tooLongWait } from './retry.js';

export type HostLimits = {
  /** Requests at a time, 1 or more. */
  readonly max_concurrent: number;
  /** Requests a second, null = no limit. */
  readonly max_per_s: number | null;
};

/**
 * One queue for each host, shared by all jobs of a run, so that two sources on one host do not
 * double its load. Waiting for a retry happens outside the queue, so that a bad file does not block
 * its host.
 */
export class HostQueues {
  readonly limiter: HostRateLimiter;
  readonly #queues = new Map<string, PQueue>();

  constructor(limiter: HostRateLimiter) {
    this.limiter = limiter;
  }

  /** Runs `request` when its host has room. The first caller's concurrency holds for a host. */
  async run<T>(
    host: string,
    limits: HostLimits,
    request: () => Promise<T>,
    signal: AbortSignal,
  ): Promise<T> {
    let queue = this.#queues.get(host);
    if (queue === undefined) {
      queue = new PQueue({ concurrency: limits.max_concurrent });
      this.#queues.set(host, queue);
    }
    return queue.add(async () => {
      await this.limiter.acquire(host, signal, limits.max_per_s);
      return request();
    });
  }
}

/**
 * Delays all requests to a host that sent Retry-After, not only the one that it answered, and
 * spaces requests to a host with a rate limit. When Retry-After exceeds `max_wait_ms`, the squares
 * of the host fail at once, without a request: waiting for hours inside a run is of no use, and an
 * earlier request would ignore the server's limit.
 */
export class HostRateLimiter {
  readonly #clock: Clock;
  readonly #max_wait_ms: number;
  readonly #openAt_ms = new Map<string, number>();
  /** When the next request may start, by host with a rate. */
  readonly #nextAt_ms = new Map<string, number>();

  constructor(clock: Clock, max_wait_ms: number) {
    this.#clock = clock;
    this.#max_wait_ms = max_wait_ms;
  }

  pause(host: string, wait_ms: number): void {
    const until = this.#clock.now().getTime() + wait_ms;
    this.#openAt_ms.set(host, Math.max(until, this.#openAt_ms.get(host) ?? 0));
  }

  /** @param max_per_s requests a second, null = no limit */
  async acquire(host: string, signal: AbortSignal, max_per_s: number | null = null): Promise<void> {
    for (;;) {
      signal.throwIfAborted();
      const left_ms = (this.#openAt_ms.get(host) ?? 0) - this.#clock.now().getTime();
      if (left_ms <= 0) break;
      if (left_ms > this.#max_wait_ms) {
        throw tooLongWait(`request from ${host}`, left_ms, this.#max_wait_ms);
      }
      await this.#clock.sleep(left_ms, signal);
    }
    if (max_per_s !== null) await this.#waitForTurn(host, 1000 / max_per_s, signal);
  }

  async #waitForTurn(host: string, gap_ms: number, signal: AbortSignal): Promise<void> {
    const now = this.#clock.now().getTime();
    const at = Math.max(now, this.#nextAt_ms.get(host) ?? 0);
    this.#nextAt_ms.set(host, at + gap_ms);
    if (at > now) await this.#clock.sleep(at - now, signal);
  }
}

import PQueue from 'p-queue';
import type { HostRateLimiter } from './host-rate-limiter.js';

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

import type { Clock } from '../util/clock.js';
import { GrabberError } from '../util/errors.js';

/**
 * A body that trickles keeps every time-out of silence from firing, and its host's queue from
 * moving.
 */
export const kMinRate_bytes_per_s = 512;
export const kRateWindow_ms = 120_000;

/** Gives up on a body that comes too slowly over a whole window. */
export class StallDetector {
  readonly #clock: Clock;
  readonly #shown: string;
  #since_ms: number;
  #bytes = 0;

  constructor(clock: Clock, shown: string) {
    this.#clock = clock;
    this.#shown = shown;
    this.#since_ms = clock.now().getTime();
  }

  /**
   * @param bytes of the piece that has just come
   * @throws GrabberError TOO_SLOW
   */
  check(bytes: number): void {
    this.#bytes += bytes;
    const now_ms = this.#clock.now().getTime();
    const spent_ms = now_ms - this.#since_ms;
    if (spent_ms < kRateWindow_ms) return;
    const rate = (this.#bytes * 1000) / spent_ms;
    if (rate < kMinRate_bytes_per_s) {
      throw new GrabberError(
        'TOO_SLOW',
        `fetch ${this.#shown}: ${Math.round(rate)} bytes a second over ` +
          `${Math.round(spent_ms / 1000)} s; allowed: at least ${kMinRate_bytes_per_s}`,
        { retryable: true },
      );
    }
    this.#since_ms = now_ms;
    this.#bytes = 0;
  }
}

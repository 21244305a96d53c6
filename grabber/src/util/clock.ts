import { setTimeout as delay } from 'node:timers/promises';

/** Time and chance enter here, so that tests can replace them. */
export type Clock = {
  now(): Date;
  /** @throws the signal's reason when it aborts first */
  sleep(ms: number, signal: AbortSignal): Promise<void>;
  /** @return a number in [0, 1) */
  random(): number;
};

/** Timers of Node.js that wait longer do not wait at all. */
const kMaxTimer_ms = 2 ** 31 - 1;

export const kSystemClock: Clock = {
  now: () => new Date(),
  sleep: async (ms, signal) => {
    signal.throwIfAborted();
    try {
      for (let left_ms = ms; left_ms > 0; left_ms -= kMaxTimer_ms) {
        await delay(Math.min(left_ms, kMaxTimer_ms), undefined, { signal });
      }
    } catch (error) {
      signal.throwIfAborted();
      throw error;
    }
  },
  random: () => Math.random(),
};

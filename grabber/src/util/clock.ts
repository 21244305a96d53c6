import { setTimeout as delay } from 'node:timers/promises';

/** Time and chance enter here, so that tests can replace them. */
export type Clock = {
  now(): Date;
  /** @throws the signal's reason when it aborts first */
  sleep(ms: number, signal: AbortSignal): Promise<void>;
  /** @return a number in [0, 1) */
  random(): number;
};

export const kSystemClock: Clock = {
  now: () => new Date(),
  sleep: async (ms, signal) => {
    signal.throwIfAborted();
    try {
      await delay(ms, undefined, { signal });
    } catch (error) {
      signal.throwIfAborted();
      throw error;
    }
  },
  random: () => Math.random(),
};

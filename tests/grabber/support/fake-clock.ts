import type { Clock } from '../../../grabber/src/util/clock.js';

export type FakeClock = { -readonly [K in keyof Clock]: Clock[K] } & {
  readonly slept_ms: number[];
};

/** Sleeps take no time here, but move the time on. */
export function fakeClock(start = '2026-06-21T12:00:00.000Z', random = 0): FakeClock {
  let now_ms = Date.parse(start);
  const slept_ms: number[] = [];
  return {
    slept_ms,
    now: () => new Date(now_ms),
    random: () => random,
    sleep: (ms, signal) => {
      signal.throwIfAborted();
      slept_ms.push(ms);
      now_ms += ms;
      return Promise.resolve();
    },
  };
}

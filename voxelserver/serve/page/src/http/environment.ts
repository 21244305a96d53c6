/** What the data layer takes from its surroundings, so that tests can pass their own. */

export type Fetch = (url: string, init: RequestInit) => Promise<Response>;

export type Clock = {
  /** Milliseconds since 1970. */
  now(): number;
  /** Calls `run` once after `ms` milliseconds. @return cancels that */
  after(ms: number, run: () => void): () => void;
};

export type Environment = {
  readonly fetch: Fetch;
  readonly clock: Clock;
  /** In [0, 1): spreads the waits between attempts. */
  readonly random: () => number;
  /** Origin of the page, as in "https://example.org". */
  readonly origin: string;
};

/** @throws the reason of `signal` when it is aborted before `ms` milliseconds have passed */
export function wait(clock: Clock, ms: number, signal: AbortSignal): Promise<void> {
  return new Promise((resolve, reject) => {
    if (signal.aborted) {
      reject(signal.reason as Error);
      return;
    }
    const onAbort = (): void => {
      cancel();
      reject(signal.reason as Error);
    };
    const cancel = clock.after(ms, () => {
      signal.removeEventListener('abort', onAbort);
      resolve();
    });
    signal.addEventListener('abort', onAbort, { once: true });
  });
}

/** The surroundings of a worker, or of a page. */
export function browserEnvironment(): Environment {
  return {
    fetch: (url, init) => fetch(url, init),
    clock: {
      now: () => Date.now(),
      after: (ms, run) => {
        const timer = setTimeout(run, ms);
        return () => clearTimeout(timer);
      },
    },
    random: Math.random,
    origin: self.location.origin,
  };
}

import { pollWaitMs } from './retry.js';

/** Time enters here, so that tests can replace it. */
export type PollClock = {
  readonly after: (ms: number, run: () => void) => void;
  /** True while the tab is hidden. */
  readonly isPaused: () => boolean;
};

const kPageClock: PollClock = {
  after: (ms, run) => void setTimeout(run, ms),
  isPaused: () => document.hidden,
};

/**
 * Runs a job again and again, never twice at once. After a failure the next run waits longer;
 * wake() runs it soon, for a tab that is visible again or a new token.
 */
export class Poller {
  readonly #job: () => Promise<void>;
  readonly #everyMs: number;
  readonly #clock: PollClock;
  #failures = 0;
  #running = false;
  #turn = 0;

  constructor(everyMs: number, job: () => Promise<void>, clock = kPageClock) {
    this.#everyMs = everyMs;
    this.#job = job;
    this.#clock = clock;
  }

  wake(): void {
    this.#failures = 0;
    void this.#run();
  }

  async #run(): Promise<void> {
    if (this.#running || this.#clock.isPaused()) return;
    this.#running = true;
    let waitMs = this.#everyMs;
    try {
      await this.#job();
      this.#failures = 0;
    } catch (error) {
      // The job has reported it.
      this.#failures += 1;
      waitMs = pollWaitMs(error, this.#everyMs, this.#failures);
    } finally {
      this.#running = false;
      this.#turn += 1;
      const turn = this.#turn;
      this.#clock.after(waitMs, () => {
        if (turn === this.#turn) void this.#run();
      });
    }
  }
}

/** Wakes polls whenever the tab is visible again. */
export function wakeWhenShown(...polls: readonly Poller[]): void {
  document.addEventListener('visibilitychange', () => {
    if (!document.hidden) for (const poll of polls) poll.wake();
  });
}

/** Time enters here, so that tests can replace it. */
export type Clock = {
  readonly after: (ms: number, run: () => void) => void;
  /** True while the tab is hidden. */
  readonly isPaused: () => boolean;
};

/**
 * Runs a job again and again, never twice at once. After a failure the next run waits longer, up to
 * ten times as long; wake() runs it soon, for a tab that is visible again or a new token.
 */
export class Poller {
  readonly #job: () => Promise<void>;
  readonly #everyMs: number;
  readonly #clock: Clock;
  #failures = 0;
  #running = false;
  #turn = 0;

  constructor(everyMs: number, job: () => Promise<void>, clock: Clock) {
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
    try {
      await this.#job();
      this.#failures = 0;
    } catch {
      // The job has reported the error.
      ++this.#failures;
    } finally {
      this.#running = false;
      const turn = ++this.#turn;
      this.#clock.after(this.#everyMs * Math.min(10, 1 + this.#failures), () => {
        if (turn === this.#turn) void this.#run();
      });
    }
  }
}

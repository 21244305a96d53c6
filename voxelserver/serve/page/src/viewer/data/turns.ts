import { wait, type Clock } from '../../http/environment.js';

/**
 * Interrupts long work so that messages to the worker, such as a cancellation, get their turn.
 */
export class Turns {
  readonly #clock: Clock;
  readonly #limitBytes: number;
  #bytes = 0;

  /** @param limitBytes of unpacked data after which give() waits for other events */
  constructor(clock: Clock, limitBytes = 8 * 1024 * 1024) {
    this.#clock = clock;
    this.#limitBytes = limitBytes;
  }

  spend(bytes: number): void {
    this.#bytes += bytes;
  }

  /** @throws the reason of `signal` */
  async give(signal: AbortSignal): Promise<void> {
    if (this.#bytes < this.#limitBytes) return;
    this.#bytes = 0;
    await wait(this.#clock, 0, signal);
  }
}

import type { Clock } from '../util/clock.js';
import { tooLongWait } from './retry.js';

/**
 * Holds back all requests to a host that asked to be left alone for a while (Retry-After), not only the one it told,
 * and keeps requests to a host with a rate apart.
 * A host that asks for more than `max_wait_ms` fails its squares at once, without a request: waiting hours inside a
 * run helps nobody, and asking earlier than told is rude.
 */
export class HostGate {
  readonly #clock: Clock;
  readonly #max_wait_ms: number;
  readonly #openAt_ms = new Map<string, number>();
  /** When the next request may start, by host with a rate. */
  readonly #nextAt_ms = new Map<string, number>();

  constructor(clock: Clock, max_wait_ms: number) {
    this.#clock = clock;
    this.#max_wait_ms = max_wait_ms;
  }

  closeFor(host: string, wait_ms: number): void {
    const until = this.#clock.now().getTime() + wait_ms;
    this.#openAt_ms.set(host, Math.max(until, this.#openAt_ms.get(host) ?? 0));
  }

  /** @param max_per_s requests a second, null = no limit */
  async pass(host: string, signal: AbortSignal, max_per_s: number | null = null): Promise<void> {
    for (;;) {
      signal.throwIfAborted();
      const left_ms = (this.#openAt_ms.get(host) ?? 0) - this.#clock.now().getTime();
      if (left_ms <= 0) break;
      if (left_ms > this.#max_wait_ms) throw tooLongWait(`ask ${host}`, left_ms, this.#max_wait_ms);
      await this.#clock.sleep(left_ms, signal);
    }
    if (max_per_s !== null) await this.#keepApart(host, 1000 / max_per_s, signal);
  }

  async #keepApart(host: string, gap_ms: number, signal: AbortSignal): Promise<void> {
    const now = this.#clock.now().getTime();
    const at = Math.max(now, this.#nextAt_ms.get(host) ?? 0);
    this.#nextAt_ms.set(host, at + gap_ms);
    if (at > now) await this.#clock.sleep(at - now, signal);
  }
}

import PQueue from 'p-queue';
import type { HostGate } from './host-gate.js';

export type HostLimits = {
  /** Requests at a time, 1 or more. */
  readonly max_concurrent: number;
  /** Requests a second, null = no limit. */
  readonly max_per_s: number | null;
};

/**
 * One queue per host, shared by all that a run does: two sources on one host do not ask it twice as much. Whoever
 * waits for another try waits outside, so that a bad file does not block its host.
 */
export class HostLanes {
  readonly gate: HostGate;
  readonly #lanes = new Map<string, PQueue>();

  constructor(gate: HostGate) {
    this.gate = gate;
  }

  /** Runs `request` when its host has room. The first caller's concurrency holds for a host. */
  async run<T>(host: string, limits: HostLimits, request: () => Promise<T>, signal: AbortSignal): Promise<T> {
    let lane = this.#lanes.get(host);
    if (lane === undefined) {
      lane = new PQueue({ concurrency: limits.max_concurrent });
      this.#lanes.set(host, lane);
    }
    return lane.add(async () => {
      await this.gate.pass(host, signal, limits.max_per_s);
      return request();
    });
  }
}

import type { StoreRecord } from '../model/square.js';
import { compareText } from '../util/order.js';

const kGridName = /^(-?\d{1,6})_(-?\d{1,6})$/;

/**
 * Records the blocks of squares, so that an unknown block is searched among those of its neighbours
 * first.
 */
export class NearBlocks {
  readonly #byName = new Map<string, string>();
  readonly #counts = new Map<string, number>();

  constructor(records: Iterable<StoreRecord>) {
    for (const { key, block } of records) this.add(key.name, block);
  }

  add(name: string, block: string | null): void {
    if (block === null || this.#byName.has(name)) return;
    this.#byName.set(name, block);
    this.#counts.set(block, (this.#counts.get(block) ?? 0) + 1);
  }

  /**
   * @return blocks of the eight neighbours, then all others, each group with the most frequent
   *   first
   */
  near(name: string): string[] {
    const around = new Map<string, number>();
    const match = kGridName.exec(name);
    for (const east of [-1, 0, 1]) {
      for (const north of [-1, 0, 1]) {
        if (match === null) continue;
        const block = this.#byName.get(`${Number(match[1]) + east}_${Number(match[2]) + north}`);
        if (block !== undefined) around.set(block, (around.get(block) ?? 0) + 1);
      }
    }
    return [...new Set([...byCount(around), ...byCount(this.#counts)])];
  }
}

/** @return the blocks, the most frequent first, equally frequent ones by name */
function byCount(counts: ReadonlyMap<string, number>): string[] {
  const sorted = [...counts].sort(([a, m], [b, n]) => n - m || compareText(a, b));
  return sorted.map(([block]) => block);
}

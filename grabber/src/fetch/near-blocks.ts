import type { StoreRecord } from '../model/square.js';

const kGridName = /^(-?\d{1,6})_(-?\d{1,6})$/;

/** Remembers the blocks of squares, so that the block of a square nobody knows is first looked for next door. */
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

  /** Blocks of the eight neighbours first, the commonest first; then all others, the commonest first. */
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

function byCount(counts: ReadonlyMap<string, number>): string[] {
  return [...counts].sort(([a, m], [b, n]) => n - m || (a < b ? -1 : 1)).map(([block]) => block);
}

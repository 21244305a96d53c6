/**
 * Which boxes are in the pools, which of them a picture shows, and which are wanted next. A column
 * of boxes is the unit. A column of the cut is split only when all of its halves can be shown, so
 * that something coarser stands where finer boxes are missing; with all wanted columns there, what
 * is shown is exactly the cut. Pure logic: pools are behind `ColumnStore`.
 */
import { nameOfColumn, type ColumnKey } from '../data/columns.js';
import type { BoxSlot, CutColumn } from './column-table.js';
import type { LevelCut } from './level-cut.js';

/** A column in the pools. */
export type StoredColumn = { readonly byBegin: number; readonly slots: readonly BoxSlot[] };

export type ColumnStore = {
  /** Frees the rows of a column. */
  drop(column: StoredColumn): void;
};

export type Plan = {
  /** What is shown: leaves and split columns. Empty while not even the coarsest level is there. */
  readonly shown: readonly CutColumn[];
  /** What is missing, most wanted first: coarse before fine, then in view, then near. */
  readonly wanted: readonly ColumnKey[];
  /** Whether what is shown is the cut itself. */
  readonly isComplete: boolean;
};

type Entry = { readonly key: ColumnKey; readonly column: StoredColumn; usedAt: number };

export class Residency {
  readonly #store: ColumnStore;
  readonly #entries = new Map<string, Entry>();
  #planNumber = 0;

  constructor(store: ColumnStore) {
    this.#store = store;
  }

  get size(): number {
    return this.#entries.size;
  }

  has(key: ColumnKey): boolean {
    return this.#entries.has(nameOfColumn(key));
  }

  add(key: ColumnKey, column: StoredColumn): void {
    const name = nameOfColumn(key);
    const old = this.#entries.get(name);
    if (old !== undefined) this.#store.drop(old.column);
    this.#entries.set(name, { key, column, usedAt: this.#planNumber });
  }

  /**
   * Drops the column that was used longest ago, if it is not part of the newest plan.
   * @return false when there is none
   */
  dropOldest(): boolean {
    let oldest: [string, Entry] | undefined;
    for (const item of this.#entries) {
      if (oldest === undefined || item[1].usedAt < oldest[1].usedAt) oldest = item;
    }
    if (oldest === undefined || oldest[1].usedAt >= this.#planNumber) return false;
    this.#entries.delete(oldest[0]);
    this.#store.drop(oldest[1].column);
    return true;
  }

  /** @param isInView whether a column may be visible; decides only the order of what is wanted */
  plan(cut: LevelCut, isInView: (key: ColumnKey) => boolean): Plan {
    ++this.#planNumber;
    const wanted: ColumnKey[] = [];
    const shown: CutColumn[] = [];
    const roots = cut.roots();
    let isComplete = true;
    for (let bx = roots.x[0]; bx < roots.x[1]; ++bx) {
      for (let bz = roots.z[0]; bz < roots.z[1]; ++bz) {
        const part = this.#visit(cut, { level: cut.coarsest, bx, bz }, wanted);
        if (part === undefined) isComplete = false;
        else shown.push(...part);
      }
    }
    isComplete &&= wanted.length === 0;
    const order = new Map(wanted.map((key) => [key, urgency(cut, key, isInView(key))]));
    wanted.sort((a, b) => b.level - a.level || order.get(a)! - order.get(b)!);
    return { shown, wanted, isComplete };
  }

  // What stands for a column and all below it; undefined: nothing that is there covers it.
  #visit(cut: LevelCut, key: ColumnKey, wanted: ColumnKey[]): CutColumn[] | undefined {
    const entry = this.#entries.get(nameOfColumn(key));
    if (entry === undefined) wanted.push(key);
    else entry.usedAt = this.#planNumber;
    if (!cut.isFarEnough(key.level, key.bx, key.bz)) {
      const out: CutColumn[] = [{ ...key, boxes: undefined }];
      let areHalvesThere = true;
      for (const half of listChildren(key)) {
        if (!cut.touches(half.level, half.bx, half.bz)) continue;
        const part = this.#visit(cut, half, wanted);
        if (part === undefined) areHalvesThere = false;
        else if (areHalvesThere) out.push(...part);
      }
      if (areHalvesThere) return out;
    }
    return entry === undefined ? undefined : [{ ...key, boxes: entry.column }];
  }
}

function listChildren(key: ColumnKey): ColumnKey[] {
  const level = key.level - 1;
  const [bx, bz] = [key.bx * 2, key.bz * 2];
  return [
    { level, bx, bz },
    { level, bx: bx + 1, bz },
    { level, bx, bz: bz + 1 },
    { level, bx: bx + 1, bz: bz + 1 },
  ];
}

const kBehind = 1e30; // squared voxels: more than any distance in a world

function urgency(cut: LevelCut, key: ColumnKey, isInView: boolean): number {
  return cut.distance2(key.level, key.bx, key.bz) + (isInView ? 0 : kBehind);
}

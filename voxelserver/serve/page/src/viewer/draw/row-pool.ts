/**
 * Rows of a texture array, handed out in runs: a box gets whole rows for its cells, and rows for
 * its attributes. A run may begin in one layer and end in another, so that the largest box has room
 * too. First fit; neighbouring free runs are joined. Pure bookkeeping.
 */
export class RowPool {
  readonly capacity: number;
  /** Free runs in ascending order. */
  readonly #free: { at: number; rows: number }[];
  #used = 0;

  /** @param rows of all layers together */
  constructor(rows: number) {
    this.capacity = rows;
    this.#free = [{ at: 0, rows }];
  }

  get used(): number {
    return this.#used;
  }

  /** @return the first row; undefined when no run is long enough */
  take(rows: number): number | undefined {
    const i = this.#free.findIndex((run) => run.rows >= rows);
    const run = this.#free[i];
    if (run === undefined) return undefined;
    const { at } = run;
    run.at += rows;
    run.rows -= rows;
    if (run.rows === 0) this.#free.splice(i, 1);
    this.#used += rows;
    return at;
  }

  /** Frees what take(rows) returned. */
  free(at: number, rows: number): void {
    let i = this.#free.findIndex((run) => run.at > at);
    if (i < 0) i = this.#free.length;
    this.#free.splice(i, 0, { at, rows });
    this.#join(i);
    if (i > 0) this.#join(i - 1);
    this.#used -= rows;
  }

  #join(i: number): void {
    const run = this.#free[i]!;
    const next = this.#free[i + 1];
    if (next === undefined || run.at + run.rows !== next.at) return;
    run.rows += next.rows;
    this.#free.splice(i + 1, 1);
  }
}

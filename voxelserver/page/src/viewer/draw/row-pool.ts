/**
 * Rows of a texture array, handed out in runs: a box gets whole rows of one layer for its cells,
 * and rows for its attributes. First fit; neighbouring free runs are joined. Pure bookkeeping.
 */
export class RowPool {
  /** Free runs by layer, in ascending order. */
  readonly #free: { at: number; rows: number }[][];
  readonly #rowsOfLayer: number;
  #used = 0;

  constructor(layers: number, rowsOfLayer: number) {
    this.#rowsOfLayer = rowsOfLayer;
    this.#free = Array.from({ length: layers }, () => [{ at: 0, rows: rowsOfLayer }]);
  }

  get capacity(): number {
    return this.#free.length * this.#rowsOfLayer;
  }

  get used(): number {
    return this.#used;
  }

  /** @return the first row, counted over all layers; undefined when no run is long enough */
  take(rows: number): number | undefined {
    for (const [layer, runs] of this.#free.entries()) {
      const i = runs.findIndex((run) => run.rows >= rows);
      const run = runs[i];
      if (run === undefined) continue;
      const at = run.at;
      run.at += rows;
      run.rows -= rows;
      if (run.rows === 0) runs.splice(i, 1);
      this.#used += rows;
      return layer * this.#rowsOfLayer + at;
    }
    return undefined;
  }

  /** Frees what take(rows) returned. */
  free(first: number, rows: number): void {
    const layer = Math.floor(first / this.#rowsOfLayer);
    const at = first % this.#rowsOfLayer;
    const runs = this.#free[layer]!;
    let i = runs.findIndex((run) => run.at > at);
    if (i < 0) i = runs.length;
    runs.splice(i, 0, { at, rows });
    this.#join(runs, i);
    if (i > 0) this.#join(runs, i - 1);
    this.#used -= rows;
  }

  #join(runs: { at: number; rows: number }[], i: number): void {
    const run = runs[i]!;
    const next = runs[i + 1];
    if (next === undefined || run.at + run.rows !== next.at) return;
    run.rows += next.rows;
    runs.splice(i + 1, 1);
  }
}

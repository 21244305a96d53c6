export type FileStats = {
  requests: number;
  /** Bytes of bodies handed to the network. */
  bytes: number;
  /** Answers with status 200 whose whole body was handed over. */
  whole: number;
  faults: number;
};

/** What was sent, by path. */
export class PortalStats {
  readonly #files = new Map<string, FileStats>();

  of(path: string): FileStats {
    let stats = this.#files.get(path);
    if (stats === undefined) {
      stats = { requests: 0, bytes: 0, whole: 0, faults: 0 };
      this.#files.set(path, stats);
    }
    return stats;
  }

  reset(): void {
    this.#files.clear();
  }

  toJSON(): Record<string, FileStats> {
    return Object.fromEntries(this.#files);
  }
}

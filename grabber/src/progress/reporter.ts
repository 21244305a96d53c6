import type { FetchEvents, Summary } from './events.js';

/** Reports the progress of a run to the user or to a program. */
export type Reporter = FetchEvents & {
  /** With --from: a file whose name is not one of the source's. */
  ignored(path: string, source: string): void;
  /** Records that this run cannot continue. */
  skipped(source: string, files: number, why: string): void;
  /**
   * Orthophotos of squares of a LiDAR source that a run has begun, and this one does not continue.
   */
  orthophotosLeft(source: string, grid: string, count: number): void;
  summary(summary: Summary): void;
  /** Leaves the terminal as it was; also after an error. */
  close(): void;
};

import type { Source } from '../sources/source.js';
import type { PackageInfo } from '../util/package-info.js';
import type { Output } from './output.js';

/** What every command may use. */
export type CliContext = {
  readonly output: Output;
  /** Aborts at SIGINT and SIGTERM. */
  readonly signal: AbortSignal;
  readonly info: PackageInfo;
  /** The folder of `sources/`, `areas/` and the rest of the configuration. */
  readonly configFolder: () => string;
  /**
   * Reads the configured sources, by id.
   * @throws GrabberError CONFIG for a file that is not valid
   */
  readonly sources: () => Promise<ReadonlyMap<string, Source>>;
  /** Sets the exit code of the process, which is 0 unless a command sets another. */
  readonly exit: (code: number) => void;
};

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
  configFolder(): string;
  sources(): Promise<ReadonlyMap<string, Source>>;
  /** What the process will end with; 0 unless a command says otherwise. */
  exit(code: number): void;
};

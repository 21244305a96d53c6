import type { Source } from '../sources/source.js';
import type { PackageInfo } from '../util/package-info.js';
import { printable, printableLine } from '../util/text.js';

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

/**
 * The exit codes of the program. They are part of its interface, because scripts branch on them.
 */
export const kExit = {
  done: 0,
  /** Some square failed, or the command could not run. */
  failed: 1,
  /** Wrong usage, or a configuration file with a value that is not allowed. */
  usage: 2,
  /** Done, but the source lacks some of the requested squares, or some wait for another command. */
  holes: 3,
  /** 128 + the signal's number, as shells do. */
  interrupted: 130,
  terminated: 143,
} as const;

/**
 * Combines the exit codes of two parts of a run.
 * @return the more severe one
 */
export function chooseWorse(a: number, b: number): number {
  const order: readonly number[] = [kExit.failed, kExit.holes, kExit.done];
  return order.find((code) => code === a || code === b) ?? kExit.done;
}

/** The streams of the process; tests put their own in their place. */
export type Streams = {
  /** Writes to standard output. */
  readonly out: (text: string) => void;
  /** Writes to standard error. */
  readonly err: (text: string) => void;
};

/**
 * Where a command writes. Names, addresses and messages come from strangers: servers, files, other
 * people's stores. So nothing but line breaks and tabs reaches a terminal as a control character,
 * and a line stays one.
 */
export type Output = Streams & {
  /** Writes one line to standard output. */
  readonly outLine: (text: string) => void;
  /** Writes one line to standard error. */
  readonly errLine: (text: string) => void;
  /** As they are, for colours and cursor movements; texts of strangers must be printable there. */
  readonly drawn: Streams;
};

export function outputTo(streams: Streams): Output {
  return {
    out: (text) => streams.out(printable(text)),
    err: (text) => streams.err(printable(text)),
    outLine: (text) => streams.out(`${printableLine(text)}\n`),
    errLine: (text) => streams.err(`${printableLine(text)}\n`),
    drawn: streams,
  };
}

/** Left-aligned columns, two blanks apart; a cell stays on its line. */
export function formatTable(
  header: readonly string[],
  rows: readonly (readonly string[])[],
): string {
  const lines = [header, ...rows].map((line) => line.map(printableLine));
  const widths = header.map((_title, column) =>
    Math.max(...lines.map((line) => (line[column] ?? '').length)),
  );
  return lines
    .map((line) =>
      line
        .map((cell, column) => cell.padEnd(widths[column] ?? 0))
        .join('  ')
        .trimEnd(),
    )
    .map((line) => `${line}\n`)
    .join('');
}

export function formatBytes(bytes: number): string {
  if (bytes < 1000) return `${bytes} B`;
  if (bytes < 1_000_000) return `${(bytes / 1000).toFixed(1)} kB`;
  if (bytes < 1_000_000_000) return `${(bytes / 1_000_000).toFixed(1)} MB`;
  return `${(bytes / 1_000_000_000).toFixed(2)} GB`;
}

import { Option, type Command } from 'commander';
import { kBackoff, type RetryNotice, type RetryPolicy } from '../fetch/retry.js';
import { jsonReporter } from '../progress/json-reporter.js';
import { barReporter } from '../progress/bar-reporter.js';
import type { Reporter } from '../progress/reporter.js';
import { textReporter } from '../progress/text-reporter.js';
import type { CatalogueOptions } from '../sources/catalogue/options.js';
import { GrabberError } from '../util/errors.js';
import { kExit } from './exit-codes.js';
import { integerIn } from './option-parsers.js';
import type { Output } from './output.js';

/** Limits for requests to servers; every command that contacts one has these options. */
export type RequestOptions = { retries: number; timeoutS: number; maxWaitS: number };

/** What fetch and resume have in common. */
export type RunOptions = RequestOptions & {
  store?: string;
  concurrency?: number;
  maxFileGib: number;
  json?: boolean;
};

/** @param store help text of --store, whose presence the caller checks */
export function addRunOptions(command: Command, store: string): Command {
  return addRequestOptions(
    command.addOption(new Option('--store <folder>', store).env('TERRAVOX_STORE')),
  )
    .option(
      '--concurrency <n>',
      "files at a time, 1 to 32 (default: the source's, else 4)",
      integerIn(1, 32, 'files at a time'),
    )
    .option(
      '--max-file-gib <n>',
      'largest file to take, GiB, 1 to 1024',
      integerIn(1, 1024, 'GiB'),
      16,
    )
    .option('--json', 'log one JSON object a line to standard output');
}

export function addRequestOptions(command: Command): Command {
  return command
    .option(
      '--retries <n>',
      'tries after the first, 0 to 20',
      integerIn(0, 20, 'tries after the first'),
      5,
    )
    .option(
      '--timeout-s <s>',
      'longest silence of a server, seconds, 1 to 3600',
      integerIn(1, 3600, 'seconds'),
      60,
    )
    .option(
      '--max-wait-s <s>',
      'longest Retry-After to obey, seconds, 1 to 86400',
      integerIn(1, 86_400, 'seconds'),
      600,
    );
}

export function toPolicy({ retries, maxWaitS }: Omit<RequestOptions, 'timeoutS'>): RetryPolicy {
  return { ...kBackoff, retries, max_wait_ms: maxWaitS * 1000 };
}

export type CatalogueMonitor = Pick<CatalogueOptions, 'policy' | 'onRetry' | 'onLeftOut'> & {
  /**
   * @return the exit code as far as the catalogue goes: there may be squares in what could not be
   * read
   */
  code(): number;
};

/**
 * Makes the settings for requests to a catalogue, and reports retries and skipped entries on
 * standard error, since results go to standard output.
 */
export function monitorCatalogue(options: RequestOptions, output: Output): CatalogueMonitor {
  let leftOut = 0;
  const onRetry = ({ error, retry, wait_ms }: RetryNotice): void =>
    output.errLine(
      `retry ${retry} of the catalogue in ${(wait_ms / 1000).toFixed(1)} s: ${error.message}`,
    );
  const onLeftOut = (error: GrabberError): void => {
    ++leftOut;
    output.errLine(`warning: left out of the catalogue (${leftOut}): ${error.message}`);
  };
  return {
    policy: toPolicy(options),
    onRetry,
    onLeftOut,
    code: () => (leftOut === 0 ? kExit.done : kExit.holes),
  };
}

/** @throws GrabberError USAGE without a store */
export function chooseStore(options: { readonly store?: string }): string {
  if (options.store !== undefined) return options.store;
  throw new GrabberError(
    'USAGE',
    'choose store: none given; allowed: --store FOLDER, or the environment variable TERRAVOX_STORE',
  );
}

/** Bars are shown on a terminal only, and only where nothing else is written to it. */
export function chooseReporter(options: RunOptions, output: Output): Reporter {
  if (options.json === true) return jsonReporter(output);
  const terminal = process.stderr.isTTY && process.stdout.isTTY && process.env['TERM'] !== 'dumb';
  return terminal ? barReporter(output, process.stderr) : textReporter(output);
}

import { Option, type Command } from 'commander';
import { usage, type GrabberError } from '../util/errors.js';
import { kBackoff, type RetryNotice, type RetryPolicy } from '../fetch/retry.js';
import { jsonReporter, barReporter, type Reporter, textReporter } from '../progress/reporter.js';
import type { CatalogueOptions } from '../sources/catalogue/listing.js';
import { kExit, type Output } from './context.js';
import { integerIn, kSilence, limit } from './options.js';

/** Limits for requests to servers; every command that contacts one has these options. */
export type RequestOptions = { retries: number; timeoutS: number; maxWaitS: number };

/** What fetch and resume have in common. */
export type RunOptions = RequestOptions & {
  store?: string;
  concurrency?: number;
  maxFileGib: number;
  json?: boolean;
};

const kLongestWait = 'longest Retry-After to obey, seconds';

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
    .addOption(limit('--max-file-gib <n>', 'largest file to take, GiB', 1, 1024, 'GiB', 16))
    .option('--json', 'log one JSON object a line to standard output');
}

export function addRequestOptions(command: Command): Command {
  return command
    .addOption(limit('--retries <n>', 'tries after the first', 0, 20, 'tries after the first', 5))
    .addOption(limit('--timeout-s <s>', kSilence, 1, 3600, 'seconds', 60))
    .addOption(limit('--max-wait-s <s>', kLongestWait, 1, 86_400, 'seconds', 600));
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
  throw usage(
    'choose store: none given; allowed: --store FOLDER, or the environment variable TERRAVOX_STORE',
  );
}

/** Bars are shown on a terminal only, and only where nothing else is written to it. */
export function chooseReporter(options: RunOptions, output: Output): Reporter {
  if (options.json === true) return jsonReporter(output);
  const terminal = process.stderr.isTTY && process.stdout.isTTY && process.env['TERM'] !== 'dumb';
  return terminal ? barReporter(output, process.stderr) : textReporter(output);
}

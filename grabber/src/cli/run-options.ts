import type { Command } from 'commander';
import { jsonReporter } from '../progress/json-reporter.js';
import { barReporter } from '../progress/bar-reporter.js';
import type { Reporter } from '../progress/reporter.js';
import { textReporter } from '../progress/text-reporter.js';
import { integerIn } from './option-parsers.js';
import type { Output } from './output.js';

/** What fetch and resume have in common. */
export type RunOptions = {
  store: string;
  concurrency?: number;
  retries: number;
  timeoutS: number;
  maxWaitS: number;
  maxFileGib: number;
  json?: boolean;
};

export function addRunOptions(command: Command): Command {
  addStoreOption(command)
    .option('--concurrency <n>', "files at a time, 1 to 32 (default: the source's, else 4)", integerIn(1, 32, 'files at a time'))
    .option('--retries <n>', 'tries after the first, 0 to 20', integerIn(0, 20, 'tries after the first'), 5)
    .option('--timeout-s <s>', 'longest silence of a server, seconds, 1 to 3600', integerIn(1, 3600, 'seconds'), 60)
    .option('--max-wait-s <s>', 'longest Retry-After to obey, seconds, 1 to 86400', integerIn(1, 86_400, 'seconds'), 600)
    .option('--max-file-gib <n>', 'largest file to take, GiB, 1 to 1024', integerIn(1, 1024, 'GiB'), 16)
    .option('--json', 'log one JSON object a line to standard output');
  return command;
}

export function addStoreOption(command: Command): Command {
  const fromEnvironment = process.env['TERRAVOX_STORE'];
  const about = 'store to fill; made when it is not there (default: environment variable TERRAVOX_STORE)';
  if (fromEnvironment === undefined || fromEnvironment === '') return command.requiredOption('--store <folder>', about);
  return command.option('--store <folder>', about, fromEnvironment);
}

/** Bars are for eyes: only where a person looks, and nothing else is written to the terminal. */
export function chooseReporter(options: RunOptions, output: Output): Reporter {
  if (options.json === true) return jsonReporter(output);
  const terminal = process.stderr.isTTY && process.stdout.isTTY && process.env['TERM'] !== 'dumb';
  return terminal ? barReporter(output, process.stderr) : textReporter(output);
}

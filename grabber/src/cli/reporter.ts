import { pino } from 'pino';
import type { Outcome } from '../fetch/fetch-square.js';
import type { Tally } from '../fetch/fetch-squares.js';
import type { RetryNotice } from '../fetch/retry.js';
import { formatBytes, type Output } from './output.js';

export type Summary = Tally & { readonly ignored: number; readonly seconds: number };

/** Tells the user, or a program, how a fetch goes. */
export type Reporter = {
  outcome(outcome: Outcome): void;
  retry(square: string, notice: RetryNotice): void;
  ignored(path: string, source: string): void;
  summary(summary: Summary): void;
};

/** Results to standard output, troubles to standard error, a line each. */
export function textReporter(output: Output): Reporter {
  return {
    outcome(outcome) {
      if (outcome.state === 'failed')
        return output.err(`error: ${outcome.square} ${outcome.code}: ${outcome.message}\n`);
      if (outcome.state === 'missing') return output.err(`hole: ${outcome.reason}\n`);
      const { bytes, point_count, path } = outcome.file;
      output.out(`${outcome.state} ${outcome.square}  ${formatBytes(bytes)}  ${point_count} points  ${path}\n`);
      for (const warning of outcome.warnings) output.err(`warning: ${warning}\n`);
    },
    retry(square, { error, retry, wait_ms }) {
      output.err(`retry ${retry} of ${square} in ${(wait_ms / 1000).toFixed(1)} s: ${error.message}\n`);
    },
    ignored(path, source) {
      output.err(`warning: ignored ${path}: not a file name of source ${source}\n`);
    },
    summary(sum) {
      const ignored = sum.ignored === 0 ? '' : `, ${sum.ignored} files ignored`;
      output.out(
        `${sum.verified} fetched, ${sum.kept} already there, ${sum.missing} missing, ${sum.failed} failed${ignored}, ${sum.seconds.toFixed(1)} s\n`,
      );
    },
  };
}

/** One JSON object a line on standard output, for programs. */
export function jsonReporter(output: Output): Reporter {
  const log = pino(
    { base: null, timestamp: pino.stdTimeFunctions.isoTime, formatters: { level: (label) => ({ level: label }) } },
    {
      write: (line: string) => output.out(line),
    },
  );
  return {
    outcome(outcome) {
      const fields = { event: 'square', ...outcome };
      if (outcome.state === 'failed') log.error(fields, outcome.message);
      else if (outcome.state === 'missing') log.warn(fields, outcome.reason);
      else if (outcome.warnings.length > 0) log.warn(fields, outcome.warnings.join('; '));
      else log.info(fields, `${outcome.state} ${outcome.square}`);
    },
    retry(square, { error, retry, wait_ms }) {
      log.warn({ event: 'retry', square, retry, wait_ms, code: error.code }, error.message);
    },
    ignored(path, source) {
      log.warn({ event: 'ignored', path, source }, 'not a file name of the source');
    },
    summary(sum) {
      log.info({ event: 'summary', ...sum }, 'done');
    },
  };
}

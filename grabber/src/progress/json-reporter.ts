import { pino } from 'pino';
import type { Output } from '../cli/output.js';
import type { RecordKey } from '../model/square.js';
import type { Outcome } from './events.js';
import type { Reporter } from './reporter.js';
import { orthophotosLine } from './text-reporter.js';

const kProgressEvery_ms = 1000;

/** One JSON object a line on standard output, for programs. */
export function jsonReporter(
  output: Output,
  now_ms: () => number = () => performance.now(),
): Reporter {
  const log = pino(
    {
      base: null,
      timestamp: pino.stdTimeFunctions.isoTime,
      formatters: { level: (label) => ({ level: label }) },
    },
    { write: (line: string) => output.out(line) },
  );
  const shownAt_ms = new Map<string, number>();
  return {
    plan: (plan) => log.info({ event: 'plan', ...plan }),
    begin: (key, url) => {
      shownAt_ms.set(shown(key), now_ms());
      log.info({ event: 'begin', ...toFields(key), url });
    },
    bytes(key, done_bytes, _fresh, total_bytes) {
      const now = now_ms();
      if (now - (shownAt_ms.get(shown(key)) ?? 0) < kProgressEvery_ms) return;
      shownAt_ms.set(shown(key), now);
      log.info({
        event: 'progress',
        ...toFields(key),
        done_bytes,
        total_bytes: total_bytes ?? null,
      });
    },
    outcome(outcome) {
      shownAt_ms.delete(shown(outcome.key));
      const { key, ...rest } = outcome;
      const fields = { event: 'state', ...toFields(key), ...rest };
      if (outcome.state === 'failed') log.error(fields, outcome.message);
      else if (outcome.state === 'missing') log.warn(fields, outcome.reason);
      else log[hasWarnings(outcome) ? 'warn' : 'info'](fields, `${outcome.state} ${key.name}`);
    },
    retry(key, { error, retry, wait_ms }) {
      log.warn(
        { event: 'retry', ...toFields(key), retry, wait_ms, code: error.code },
        error.message,
      );
    },
    ignored: (path, source) =>
      log.warn({ event: 'ignored', path, source }, 'not a file name of the source'),
    skipped: (source, files, why) => log.error({ event: 'skipped', source, files }, why),
    orthophotosLeft: (source, grid, files) =>
      log.warn({ event: 'unfinished', source, grid, files }, orthophotosLine(source, grid, files)),
    summary: (sum) => log.info({ event: 'summary', ...sum }, 'done'),
    close: () => undefined,
  };
}

function toFields(key: RecordKey): { source: string; grid: string; square: string } {
  return { source: key.source, grid: key.grid, square: key.name };
}

function shown(key: RecordKey): string {
  return `${key.source}/${key.grid}/${key.name}`;
}

function hasWarnings(outcome: Outcome): boolean {
  return outcome.state !== 'failed' && outcome.state !== 'missing' && outcome.warnings.length > 0;
}

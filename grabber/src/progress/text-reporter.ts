import { formatBytes, type Output } from '../cli/output.js';
import type { Outcome, Summary } from './events.js';
import type { Reporter } from './reporter.js';

/** Results to standard output, troubles to standard error, a line each. */
export function textReporter(output: Output): Reporter {
  return {
    plan: () => undefined,
    begin: () => undefined,
    bytes: () => undefined,
    outcome(outcome) {
      const { text, good } = outcomeLine(outcome);
      if (good) output.outLine(text);
      else output.errLine(text);
      for (const line of warningLines(outcome)) output.errLine(line);
    },
    retry(key, { error, retry, wait_ms }) {
      output.errLine(
        `retry ${retry} of ${key.name} in ${(wait_ms / 1000).toFixed(1)} s: ${error.message}`,
      );
    },
    ignored: (path, source) => output.errLine(ignoredLine(path, source)),
    skipped: (source, files, why) => output.errLine(skippedLine(source, files, why)),
    orthophotosLeft: (source, grid, count) => output.errLine(orthophotosLine(source, grid, count)),
    summary: (sum) => output.outLine(summaryLine(sum)),
    close: () => undefined,
  };
}

export function outcomeLine(outcome: Outcome): { text: string; good: boolean } {
  if (outcome.state === 'failed') {
    return { text: `error: ${outcome.key.name} ${outcome.code}: ${outcome.message}`, good: false };
  }
  if (outcome.state === 'missing') return { text: `hole: ${outcome.reason}`, good: false };
  const points = outcome.point_count === null ? '' : `  ${outcome.point_count} points`;
  return {
    text:
      `${outcome.state} ${outcome.key.name}  ${formatBytes(outcome.file.bytes)}${points}  ` +
      `${outcome.file.path}`,
    good: true,
  };
}

export function warningLines(outcome: Outcome): string[] {
  if (outcome.state === 'failed' || outcome.state === 'missing') return [];
  const lines = outcome.warnings.map((warning) => `warning: ${warning}`);
  if (outcome.state === 'fetched') {
    lines.push(
      `warning: ${outcome.file.path} needs a conversion before it can be used (grab convert)`,
    );
  }
  return lines;
}

export function ignoredLine(path: string, source: string): string {
  return `warning: ignored ${path}: not a file name of ${source}`;
}

export function skippedLine(source: string, files: number, why: string): string {
  return `error: ${source} not continued, ${files} files: ${why}`;
}

export function orthophotosLine(source: string, grid: string, count: number): string {
  return (
    `warning: ${count} orthophotos of ${source} are unfinished (grab ortho --source ` +
    `${source} --grid ${grid}; pictures of your own: --from)`
  );
}

export function summaryLine(sum: Summary): string {
  const parts = [
    `${sum.verified + sum.converted} fetched`,
    ...(sum.fetched === 0 ? [] : [`${sum.fetched} to convert`]),
    `${sum.kept} already there`,
    `${sum.missing} missing`,
    ...(sum.known_missing === 0
      ? []
      : [`${sum.known_missing} known to be missing (--refetch requests them again)`]),
    `${sum.failed} failed`,
    formatBytes(sum.received_bytes),
    `${sum.seconds.toFixed(1)} s`,
  ];
  return parts.join(', ');
}

import { pino } from 'pino';
import cliProgress, { type MultiBar, type SingleBar } from 'cli-progress';
import type { RetryNotice } from '../fetch/retry.js';
import type { RecordKey, StoredFile } from '../model/store.js';
import { formatBytes, type Output } from '../cli/context.js';
import { printableLine } from '../util/text.js';

/** How the work on one record ended. */
export type Outcome = { readonly key: RecordKey; readonly url: string | null } & (
  | {
      /**
       * fetched: whole, but not usable before a conversion, which has not been made. kept: was
       * there before the run.
       */
      readonly state: 'verified' | 'converted' | 'fetched' | 'kept';
      readonly file: StoredFile;
      readonly point_count: number | null;
      readonly warnings: readonly string[];
    }
  | { readonly state: 'missing'; readonly reason: string }
  | { readonly state: 'failed'; readonly code: string; readonly message: string }
);

export type OutcomeState = Outcome['state'];
export type Tally = Record<OutcomeState, number>;

/** What is known before the first request. */
export type Plan = {
  readonly files: number;
  readonly kept: number;
  readonly known_bytes: number;
  readonly unknown_sizes: number;
};

export type Summary = Tally & {
  readonly known_missing: number;
  readonly received_bytes: number;
  readonly seconds: number;
};

/**
 * Receives the progress of a run. Called often, so an implementation decides itself what it shows;
 * must not throw.
 */
export type FetchEvents = {
  plan(plan: Plan): void;
  begin(key: RecordKey, url: string): void;
  /** @param total_bytes undefined = not known */
  bytes(
    key: RecordKey,
    done_bytes: number,
    fresh_bytes: number,
    total_bytes: number | undefined,
  ): void;
  retry(key: RecordKey, notice: RetryNotice): void;
  outcome(outcome: Outcome): void;
};

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

/** Results to standard output, troubles to standard error, a line each. */
export function textReporter(output: Pick<Output, 'outLine' | 'errLine'>): Reporter {
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
    ignored: (path, source) =>
      output.errLine(`warning: ignored ${path}: not a file name of ${source}`),
    skipped: (source, files, why) =>
      output.errLine(`error: ${source} not continued, ${files} files: ${why}`),
    orthophotosLeft: (source, grid, count) => output.errLine(orthophotosLine(source, grid, count)),
    summary: (sum) => output.outLine(summaryLine(sum)),
    close: () => undefined,
  };
}

function outcomeLine(outcome: Outcome): { text: string; good: boolean } {
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

function warningLines(outcome: Outcome): string[] {
  if (outcome.state === 'failed' || outcome.state === 'missing') return [];
  const lines = outcome.warnings.map((warning) => `warning: ${warning}`);
  if (outcome.state === 'fetched') {
    lines.push(
      `warning: ${outcome.file.path} needs a conversion before it can be used (grab convert)`,
    );
  }
  return lines;
}

function orthophotosLine(source: string, grid: string, count: number): string {
  return (
    `warning: ${count} orthophotos of ${source} are unfinished (grab ortho --source ` +
    `${source} --grid ${grid}; pictures of your own: --from)`
  );
}

function summaryLine(sum: Summary): string {
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

function hasWarnings(outcome: Outcome): boolean {
  return outcome.state !== 'failed' && outcome.state !== 'missing' && outcome.warnings.length > 0;
}

const kTotalFormat = '{name} [{bar}] {value}/{total} files  {bytes}  {rate}/s  {left}';
const kFileFormat = '{name} [{bar}] {bytes} of {size}';
const kNameWidth = 14;

/**
 * Bars on a terminal: one for the run, one for each file under way. Successes show in the
 * bars; holes, errors and warnings stay above them as lines.
 */
export function barReporter(
  output: Output,
  stream: NodeJS.WritableStream,
  now_ms: () => number = () => performance.now(),
): Reporter {
  const bars = createBars(stream);
  const total = bars.create(1, 0, totalFields('', 0, ''), { format: kTotalFormat });
  const files = new FileBars(bars);
  const rate = new Rate(now_ms);
  let done = 0;
  let wanted = 0;
  let received = 0;
  let expected = 0;

  const show = (): void => {
    const left = timeLeft(leftSeconds(rate, received, expected, done, wanted));
    total.update(done, totalFields(formatBytes(rate.perSecond()), received, left));
  };
  const line = (text: string): void => bars.log(`${printableLine(text)}\n`);
  const lines = textReporter({ outLine: () => undefined, errLine: line });
  const stop = (): void => {
    // Lines are written with the next picture of the bars, which stop() does not make.
    if (bars.isActive) bars.update();
    bars.stop();
  };
  return {
    // Successes show in the bars.
    ...lines,
    plan(plan) {
      wanted = plan.files;
      expected = plan.unknown_sizes === 0 ? plan.known_bytes : 0;
      total.setTotal(plan.files);
    },
    bytes(key, done_bytes, fresh_bytes, total_bytes) {
      received += fresh_bytes;
      rate.add(fresh_bytes);
      files.of(key, total_bytes).update(done_bytes, {
        bytes: formatBytes(done_bytes),
        size: total_bytes === undefined ? '?' : formatBytes(total_bytes),
      });
      show();
    },
    outcome(outcome) {
      ++done;
      files.remove(outcome.key);
      lines.outcome(outcome);
      show();
    },
    orthophotosLeft: (source, grid, count) => output.errLine(orthophotosLine(source, grid, count)),
    summary(sum) {
      stop();
      output.outLine(summaryLine(sum));
    },
    close: stop,
  };
}

/** The bars of the files under way. */
class FileBars {
  readonly #bars: MultiBar;
  readonly #byKey = new Map<string, SingleBar>();

  constructor(bars: MultiBar) {
    this.#bars = bars;
  }

  /** @return the bar of a file; a new one for a file that has none yet */
  of(key: RecordKey, total_bytes: number | undefined): SingleBar {
    const known = this.#byKey.get(shown(key));
    if (known !== undefined) return known;
    const fields = { name: printableLine(key.name).padEnd(kNameWidth), bytes: '', size: '' };
    const bar = this.#bars.create(total_bytes ?? 0, 0, fields);
    this.#byKey.set(shown(key), bar);
    return bar;
  }

  /** Removes the bar of a file, where it has one. */
  remove(key: RecordKey): void {
    const bar = this.#byKey.get(shown(key));
    if (bar !== undefined) this.#bars.remove(bar);
    this.#byKey.delete(shown(key));
  }
}

function createBars(stream: NodeJS.WritableStream): MultiBar {
  const options = {
    stream,
    clearOnComplete: true,
    hideCursor: true,
    barsize: 24,
    fps: 5,
    format: kFileFormat,
    gracefulExit: false,
  };
  return new cliProgress.MultiBar(options, cliProgress.Presets.legacy);
}

function totalFields(rate: string, received: number, left: string): Record<string, string> {
  return { name: 'all'.padEnd(kNameWidth), bytes: formatBytes(received), rate, left };
}

/**
 * Estimates the rest of the run, in seconds: by bytes where all sizes are known, else by files.
 * @return undefined before there is anything to estimate from
 */
function leftSeconds(
  rate: Rate,
  received: number,
  expected: number,
  done: number,
  wanted: number,
): number | undefined {
  const perSecond = rate.perSecond();
  if (expected > received && perSecond > 0) return (expected - received) / perSecond;
  return done > 0 ? (rate.elapsed_s() / done) * (wanted - done) : undefined;
}

/** Shows hours and minutes, or minutes and seconds. */
function timeLeft(seconds: number | undefined): string {
  if (seconds === undefined || !Number.isFinite(seconds)) return '';
  const whole = Math.round(seconds);
  const hours = Math.floor(whole / 3600);
  const minutes = Math.floor((whole % 3600) / 60);
  const parts = [
    hours > 0 ? `${hours} h ` : '',
    minutes > 0 ? `${minutes} min ` : '',
    hours > 0 ? '' : `${whole % 60} s `,
  ];
  return `${parts.join('')}left`;
}

function shown(key: RecordKey): string {
  return `${key.source}/${key.grid}/${key.name}`;
}

const kWindow_ms = 10_000;
const kSlot_ms = 500;

/** Bytes a second over the last ten seconds. */
export class Rate {
  readonly #now_ms: () => number;
  readonly #began_ms: number;
  /** Start of a slot and its bytes, oldest first. */
  readonly #slots: { at_ms: number; bytes: number }[] = [];

  constructor(now_ms: () => number) {
    this.#now_ms = now_ms;
    this.#began_ms = now_ms();
  }

  add(bytes: number): void {
    const now = this.#now_ms();
    const last = this.#slots.at(-1);
    if (last !== undefined && now - last.at_ms < kSlot_ms) last.bytes += bytes;
    else this.#slots.push({ at_ms: now, bytes });
    while ((this.#slots[0]?.at_ms ?? now) < now - kWindow_ms) this.#slots.shift();
  }

  perSecond(): number {
    const now = this.#now_ms();
    const recent = this.#slots.filter((slot) => slot.at_ms >= now - kWindow_ms);
    const since = Math.max(kSlot_ms, now - (recent[0]?.at_ms ?? now));
    return (recent.reduce((sum, slot) => sum + slot.bytes, 0) * 1000) / since;
  }

  elapsed_s(): number {
    return (this.#now_ms() - this.#began_ms) / 1000;
  }
}

import cliProgress, { type MultiBar, type SingleBar } from 'cli-progress';
import { formatBytes, type Output } from '../cli/output.js';
import type { RecordKey } from '../model/square.js';
import { printableLine } from '../util/printable.js';
import { Rate } from './rate.js';
import type { Reporter } from './reporter.js';
import {
  ignoredLine,
  orthophotosLine,
  outcomeLine,
  skippedLine,
  summaryLine,
  warningLines,
} from './text-reporter.js';

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
  const stop = (): void => {
    // Lines are written with the next picture of the bars, which stop() does not make.
    if (bars.isActive) bars.update();
    bars.stop();
  };
  return {
    plan(plan) {
      wanted = plan.files;
      expected = plan.unknown_sizes === 0 ? plan.known_bytes : 0;
      total.setTotal(plan.files);
    },
    begin: () => undefined,
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
      const { text, good } = outcomeLine(outcome);
      if (!good) line(text);
      for (const warning of warningLines(outcome)) line(warning);
      show();
    },
    retry: (key, { error, retry, wait_ms }) =>
      line(`retry ${retry} of ${key.name} in ${(wait_ms / 1000).toFixed(1)} s: ${error.message}`),
    ignored: (path, source) => line(ignoredLine(path, source)),
    skipped: (source, count, why) => line(skippedLine(source, count, why)),
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

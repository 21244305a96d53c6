import cliProgress, { type MultiBar, type SingleBar } from 'cli-progress';
import { formatBytes, type Output } from '../cli/output.js';
import type { RecordKey } from '../model/square.js';
import { Rate } from './rate.js';
import type { Reporter } from './reporter.js';
import { ignoredLine, orthophotosLine, outcomeLine, skippedLine, summaryLine, warningLines } from './text-reporter.js';

const kTotalFormat = '{name} [{bar}] {value}/{total} files  {bytes}  {rate}/s  {left}';
const kFileFormat = '{name} [{bar}] {bytes} of {size}';
const kNameWidth = 14;

/**
 * Bars on a terminal: one for the run, one for each file under way. What went well is told by the bars; holes, errors
 * and warnings stay above them as lines.
 */
export function barReporter(output: Output, stream: NodeJS.WritableStream, now_ms: () => number = () => performance.now()): Reporter {
  const bars: MultiBar = new cliProgress.MultiBar(
    { stream, clearOnComplete: true, hideCursor: true, barsize: 24, fps: 5, format: kFileFormat, gracefulExit: false },
    cliProgress.Presets.legacy,
  );
  const total = bars.create(1, 0, totalFields('', 0, undefined), { format: kTotalFormat });
  const files = new Map<string, SingleBar>();
  const rate = new Rate(now_ms);
  let [done, wanted, received, expected] = [0, 0, 0, 0];

  const show = (): void => total.update(done, totalFields(formatBytes(rate.perSecond()), received, leftText(rate, received, expected, done, wanted)));
  const line = (text: string): void => bars.log(`${text}\n`);
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
      let bar = files.get(shown(key));
      if (bar === undefined) {
        bar = bars.create(total_bytes ?? 0, 0, { name: key.name.padEnd(kNameWidth), bytes: '', size: '' });
        files.set(shown(key), bar);
      }
      bar.update(done_bytes, { bytes: formatBytes(done_bytes), size: total_bytes === undefined ? '?' : formatBytes(total_bytes) });
      show();
    },
    outcome(outcome) {
      ++done;
      const bar = files.get(shown(outcome.key));
      if (bar !== undefined) bars.remove(bar);
      files.delete(shown(outcome.key));
      const { text, good } = outcomeLine(outcome);
      if (!good) line(text);
      for (const warning of warningLines(outcome)) line(warning);
      show();
    },
    retry: (key, { error, retry, wait_ms }) => line(`retry ${retry} of ${key.name} in ${(wait_ms / 1000).toFixed(1)} s: ${error.message}`),
    ignored: (path, source) => line(ignoredLine(path, source)),
    skipped: (source, count, why) => line(skippedLine(source, count, why)),
    orthophotosLeft: (source, grid, count) => output.err(`${orthophotosLine(source, grid, count)}\n`),
    summary(sum) {
      bars.stop();
      output.out(`${summaryLine(sum)}\n`);
    },
    close: () => bars.stop(),
  };
}

function totalFields(rate: string, received: number, left: string | undefined): Record<string, string> {
  return { name: 'all'.padEnd(kNameWidth), bytes: formatBytes(received), rate, left: left ?? '' };
}

/** By bytes where all sizes are known, else by files. */
function leftText(rate: Rate, received: number, expected: number, done: number, wanted: number): string {
  const seconds =
    expected > received && rate.perSecond() > 0
      ? (expected - received) / rate.perSecond()
      : done > 0
        ? (rate.elapsed_s() / done) * (wanted - done)
        : undefined;
  if (seconds === undefined || !Number.isFinite(seconds)) return '';
  const whole = Math.round(seconds);
  const [hours, minutes] = [Math.floor(whole / 3600), Math.floor((whole % 3600) / 60)];
  return `${hours > 0 ? `${hours} h ` : ''}${minutes > 0 ? `${minutes} min ` : ''}${hours > 0 ? '' : `${whole % 60} s `}left`;
}

function shown(key: RecordKey): string {
  return `${key.source}/${key.grid}/${key.name}`;
}

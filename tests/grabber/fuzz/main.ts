import { constants } from 'node:os';
import { FuzzUsageError, kUsage, parseFuzzOptions, type FuzzOptions } from './options.js';
import { TargetProcesses } from './target-process.js';
import { allTargets } from './targets.js';

// Looks for inputs that a reader neither accepts nor refuses as its contract demands. Prints a line
// for each target. Exit codes: 0 nothing was found, 1 something was found, 2 wrong usage.

function readOptions(): FuzzOptions {
  const names = allTargets().map(({ name }) => name);
  try {
    return parseFuzzOptions(process.argv.slice(2), names);
  } catch (error) {
    if (!(error instanceof FuzzUsageError)) throw error;
    process.stderr.write(`error: ${error.message}\n${kUsage}`);
    process.exit(2);
  }
}

const { seconds, jobs, seed, names } = readOptions();
const processes = new TargetProcesses();
process.on('exit', () => processes.close());
for (const signal of ['SIGINT', 'SIGTERM'] as const) {
  process.once(signal, () => process.exit(128 + constants.signals[signal]));
}

process.stdout.write(
  `seed ${seed}, ${seconds} s for each of ${names.length} targets, ${jobs} at a time\n`,
);
const finds: string[] = [];
const waiting = [...names];

/** Runs one waiting target after another. */
async function runWaiting(): Promise<void> {
  for (let name = waiting.shift(); name !== undefined; name = waiting.shift()) {
    const { runs, find } = await processes.run(name, { seconds, seed });
    const mark = find === undefined ? '' : '  FIND';
    process.stdout.write(`${name.padEnd(26)} ${String(runs).padStart(9)} runs${mark}\n`);
    if (find !== undefined) finds.push(`\n${name}: ${find}\n`);
  }
}

await Promise.all(Array.from({ length: jobs }, runWaiting));
for (const find of finds) process.stdout.write(find);
process.exitCode = finds.length === 0 ? 0 : 1;

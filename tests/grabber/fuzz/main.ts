import * as fc from 'fast-check';
import { allTargets, type Target } from './targets.js';

// Looks for inputs that a reader neither takes nor refuses as it should: npm run fuzz -- [--seconds N] [--seed N] [NAME...]
const kUsage = 'usage: npm run fuzz -- [--seconds N] [--seed N] [NAME...]   (N a whole number above 0; seconds for all names together)';
/** A series ends before its target's time is looked at; each has a seed of its own, that a find is printed with. */
const kLongestSeries = 100;
/** One input that takes longer is a find: its reader could be kept busy. */
const kSlow_ms = 20_000;

type Wish = { readonly seconds: number; readonly seed: number; readonly targets: readonly Target[] };

function usage(why: string): never {
  process.stderr.write(`error: ${why}\n${kUsage}\n`);
  process.exit(2);
}

function readArguments(words: readonly string[], targets: readonly Target[]): Wish {
  const numbers = { '--seconds': 60, '--seed': Date.now() % 2 ** 31 };
  const names: string[] = [];
  for (let index = 0; index < words.length; ++index) {
    const word = words[index] ?? '';
    if (word !== '--seconds' && word !== '--seed') {
      names.push(word);
      continue;
    }
    const value = words[++index] ?? '';
    if (!/^[1-9]\d{0,8}$/.test(value)) usage(`${word} is "${value}"`);
    numbers[word] = Number(value);
  }
  const unknown = names.find((name) => !targets.some((one) => one.name === name));
  if (unknown !== undefined) usage(`no target is called "${unknown}"; allowed: ${targets.map(({ name }) => name).join(', ')}`);
  const chosen = names.length === 0 ? targets : targets.filter(({ name }) => names.includes(name));
  return { seconds: numbers['--seconds'], seed: numbers['--seed'], targets: chosen };
}

type Turn = { readonly runs: number; readonly find: string | undefined };

/** Runs one target for a while, and at least one series. */
async function turn({ property, runs: most }: Target, seed: number, ms: number): Promise<Turn> {
  const end = Date.now() + ms;
  let runs = 0;
  let series = seed;
  do {
    const limits = { numRuns: Math.min(most, kLongestSeries), timeout: kSlow_ms, includeErrorInReport: true };
    const details = await fc.check(property, { seed: series++, ...limits });
    runs += details.numRuns;
    if (details.failed) return { runs, find: fc.defaultReportMessage(details) ?? 'failed' };
  } while (Date.now() < end);
  return { runs, find: undefined };
}

const { seconds, seed, targets } = readArguments(process.argv.slice(2), allTargets());
process.stdout.write(`seed ${seed}, ${seconds} s, ${targets.length} targets\n`);
const finds: string[] = [];
for (const one of targets) {
  const { runs, find } = await turn(one, seed, (seconds * 1000) / targets.length);
  process.stdout.write(`${one.name.padEnd(26)} ${String(runs).padStart(9)} runs${find === undefined ? '' : '  FIND'}\n`);
  if (find !== undefined) finds.push(`\n${one.name}: ${find}\n`);
}
for (const find of finds) process.stdout.write(find);
process.exitCode = finds.length === 0 ? 0 : 1;

// Runs every *.test.js below dist-test/tests:
//   npm test -- [--tier default|all] [OPTION OF NODE...] [PART OF A PATH...]
// With --tier all those that are called *.all.test.js, with --tier default the others.
// Node.js 20 expands no patterns itself, and what a shell makes of ** depends on the shell.
import { spawnSync } from 'node:child_process';
import { readdirSync } from 'node:fs';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';

import { kReporters } from '../tests/skips.mjs';

const kFolder = fileURLToPath(new URL('dist-test/tests', import.meta.url));
/** Files of tests that run at a time: each starts programs of its own. */
const kConcurrency = 2;

const words = process.argv.slice(2);
const tier = words[0] === '--tier' ? words.splice(0, 2)[1] : undefined;
const options = words.filter((word) => word.startsWith('-'));
const parts = words.filter((word) => !word.startsWith('-'));

const files = readdirSync(kFolder, { recursive: true, encoding: 'utf8' })
  .filter((name) => name.endsWith('.test.js'))
  .filter((name) => tier === undefined || name.endsWith('.all.test.js') === (tier === 'all'))
  .filter((name) => parts.length === 0 || parts.some((part) => name.includes(part)))
  .map((name) => join(kFolder, name))
  .sort();
if (files.length === 0) {
  process.stderr.write(`error: run tests: no file below ${kFolder} matches ${words.join(' ')}\n`);
  process.exit(2);
}
const run = spawnSync(
  process.execPath,
  ['--test', ...kReporters, `--test-concurrency=${kConcurrency}`, ...options, ...files],
  { stdio: 'inherit' },
);
if (run.error !== undefined) throw run.error;
process.exit(run.status ?? 1);

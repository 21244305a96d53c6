// Runs every *.test.js below dist-test/tests:
//   npm test -- [--tier default|all] [OPTION OF NODE...] [PART OF A PATH...]
// With --tier all those that are called *.all.test.js, with --tier default the others.
// Node.js 20 expands no patterns itself, and what a shell makes of ** depends on the shell.
import { spawnSync } from 'node:child_process';
import { readdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';

import { kReporters } from '../tests/skips.mjs';

const kFolder = fileURLToPath(new URL('dist-test/tests', import.meta.url));
/**
 * Node.js runs each file that it is given in a process of its own, whose start takes longer than
 * most of its tests; so it is given this many, which import the others. Reports name the file of
 * each test that fails.
 */
const kProcesses = 2;

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
const shares = Array.from({ length: Math.min(kProcesses, files.length) }, (_, share) => {
  const path = join(kFolder, `../share-${share}.mjs`);
  const own = files.filter((_, index) => index % kProcesses === share);
  const lines = own.map((file) => `import '${pathToFileURL(file).href}';\n`);
  writeFileSync(path, lines.join(''));
  return path;
});
const run = spawnSync(
  process.execPath,
  ['--test', ...kReporters, `--test-concurrency=${kProcesses}`, ...options, ...shares],
  { stdio: 'inherit' },
);
if (run.error !== undefined) throw run.error;
process.exit(run.status ?? 1);

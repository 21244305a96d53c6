import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { FuzzUsageError, parseFuzzOptions } from './options.js';
import { TargetProcesses } from './target-process.js';

const kTargets = ['las', 'zip', 'toml'];
const kMain = fileURLToPath(new URL('main.js', import.meta.url));

test('fuzz targets are chosen by name, and options may stand anywhere', () => {
  const { seconds, jobs, names } = parseFuzzOptions([], kTargets);
  assert.deepEqual({ seconds, jobs, names }, { seconds: 3, jobs: 1, names: kTargets });
  const words = ['toml', '--seconds', '600', 'las', '--jobs=64', 'toml', '--seed', '7'];
  const expected = { seconds: 600, jobs: 64, seed: 7, names: ['las', 'toml'] };
  assert.deepEqual(parseFuzzOptions(words, kTargets), expected);
});

test('fuzz options are refused with what is allowed', () => {
  for (const [line, message] of [
    ['--seconds 0', /^--seconds is "0"; allowed: 1 to 999999$/],
    ['--seconds 1000000', /^--seconds is "1000000"/],
    ['--jobs two', /^--jobs is "two"; allowed: 1 to 64$/],
    ['--seed 1.5', /^--seed is "1.5"; allowed: 1 to 999999999$/],
    ['--seconds', /--seconds/],
    ['--minutes 1', /--minutes/],
    ['laz', /^no target is called "laz"; allowed: las, zip, toml$/],
  ] as const) {
    assert.throws(
      () => parseFuzzOptions(line.split(' '), kTargets),
      (error) => error instanceof FuzzUsageError && message.test(error.message),
      line,
    );
  }
});

test('fuzz targets run side by side, each in its own process, and report their runs', () => {
  const words = `${kMain} --seconds 1 --jobs 2 --seed 1 retry-after toml-nesting`.split(' ');
  const run = spawnSync(process.execPath, words, { encoding: 'utf8' });
  assert.equal(run.status, 0, run.stderr + run.stdout);
  const [first, ...lines] = run.stdout.trimEnd().split('\n');
  assert.equal(first, 'seed 1, 1 s for each of 2 targets, 2 at a time');
  assert.equal(lines.length, 2);
  for (const name of ['retry-after', 'toml-nesting']) {
    const line = lines.find((one) => one.startsWith(`${name} `));
    assert.match(line ?? '', / [1-9]\d* runs$/, run.stdout);
  }
});

test('a wrong fuzz option ends the command with exit code 2 and its usage', () => {
  const run = spawnSync(process.execPath, [kMain, '--jobs', '0'], { encoding: 'utf8' });
  assert.equal(run.status, 2);
  assert.match(run.stderr, /^error: --jobs is "0"; allowed: 1 to 64\nUsage: npm run fuzz/);
});

const kEndings = [
  {
    name: 'reports a find',
    script: "process.send({ kind: 'find', runs: 3, report: 'a report' }, () => process.exit(0));",
    runs: 3,
    find: /^a report$/,
  },
  {
    name: 'ends after a series of inputs began',
    script: "process.send({ kind: 'series', runs: 200, seed: 9 }, () => process.exit(7));",
    runs: 200,
    find: /^the process ended early with exit code 7; repeat with: npm run fuzz -- --seed 9 one\n/,
  },
  {
    name: 'takes more memory than a target may',
    script: 'for (const all = []; ; ) all.push(new Array(1_000_000).fill(0.5));',
    runs: 0,
    find: /^the process ended early with SIG(ABRT|TRAP|KILL).*--seed 1 one\n.*heap/s,
  },
];
for (const { name, script, runs, find } of kEndings) {
  test(`a fuzz target whose process ${name} is a find`, async (t) => {
    const folder = mkdtempSync(join(tmpdir(), 'terravox-fuzz-test-'));
    t.after(() => rmSync(folder, { recursive: true }));
    const worker = join(folder, 'worker.mjs');
    writeFileSync(worker, script);
    const processes = new TargetProcesses(worker);
    t.after(() => processes.close());
    const result = await processes.run('one', { seconds: 1, seed: 1 });
    assert.equal(result.runs, runs);
    assert.match(result.find ?? '', find);
  });
}

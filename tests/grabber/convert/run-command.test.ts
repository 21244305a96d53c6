import assert from 'node:assert/strict';
import { mkdir, readdir, readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { setTimeout as delay } from 'node:timers/promises';
import { fillArguments, runCommand } from '../../../grabber/src/convert/run-command.js';
import { removeStaleWork, withWorkFolder } from '../../../grabber/src/convert/work-folder.js';
import { script } from '../support/cli.js';
import { kNever, temporaryFolder } from '../support/store-fixture.js';

const kLimits = { time_limit_s: 20, disk_bytes: 1 << 20 };

test('placeholders stand alone or inside words, and an unknown one is refused', () => {
  const values = { input: '/a b/c', output: '/o' };
  assert.deepEqual(fillArguments(['x', '{input}', '-o={output}', '{input}{output}'], values), [
    'x',
    '/a b/c',
    '-o=/o',
    '/a b/c/o',
  ]);
  assert.throws(
    () => fillArguments(['{folder}'], values),
    /\{folder\}; allowed: \{input\} \{output\}/,
  );
});

test('a program gets its arguments unchanged, its folder and a clean environment', async (t) => {
  const folder = await temporaryFolder(t);
  process.env['TERRAVOX_SECRET'] = 'x';
  t.after(() => delete process.env['TERRAVOX_SECRET']);
  const program = await script(
    folder,
    'show',
    'console.log(JSON.stringify([process.argv.slice(2), process.cwd(), ' +
      'Object.keys(process.env).sort()]))',
  );
  const { out } = await runCommand(
    {
      what: 'show',
      argv: [program, '{input}', '$(id)', ';', '*'],
      values: { input: '/a b' },
      folder,
      limits: kLimits,
    },
    kNever,
  );
  assert.deepEqual(JSON.parse(out), [
    ['/a b', '$(id)', ';', '*'],
    folder,
    ['HOME', 'LANG', 'LC_ALL', 'PATH', 'TMPDIR'],
  ]);
});

test('what a program may not do ends it with the reason', async (t) => {
  const files =
    'const fs = require("fs"); let i = 0; ' +
    'setInterval(() => fs.writeFileSync("f" + i++, Buffer.alloc(100000)), 5)';
  const deaf = 'process.on("SIGTERM", () => 0); setInterval(() => 0, 1000)';
  const endless = 'const s = "x".repeat(65536); (function f() { process.stdout.write(s, f) })()';
  const large = 'require("fs").writeFileSync("big", Buffer.alloc(3 << 20))';
  const falls = 'process.kill(process.pid, "SIGSEGV"); setInterval(() => 0, 1000)';
  const fails = 'console.error("one\\ntwo\\nbad thing"); process.exit(7)';
  const cases: [name: string, body: string, message: RegExp, time_limit_s?: number][] = [
    ['fails', fails, /ended with exit code 7: one \| two \| bad thing/],
    ['hangs and ignores SIGTERM', deaf, /ran longer than 0\.5 s/, 0.5],
    ['fills its folder with many files', files, /filled its folder with \d+ bytes/],
    ['writes one great file', large, /SIGXFSZ|EFBIG|exit code/],
    ['writes without end', endless, /characters to standard output/],
    ['kills itself', falls, /SIGSEGV/],
  ];
  for (const [name, body, message, time_limit_s = kLimits.time_limit_s] of cases) {
    await t.test(name, async (t) => {
      const folder = await temporaryFolder(t);
      const program = await script(await temporaryFolder(t), 'bad', body);
      await assert.rejects(
        runCommand(
          { what: 'try', argv: [program], folder, limits: { ...kLimits, time_limit_s } },
          kNever,
        ),
        message,
      );
    });
  }
});

test('a program that is not there is named', async (t) => {
  const folder = await temporaryFolder(t);
  await assert.rejects(
    runCommand({ what: 'try it', argv: ['/no/such/program'], folder, limits: kLimits }, kNever),
    /^GrabberError: try it: program /,
  );
});

test('a stop ends the whole group, and what the program started does not outlive it', async (t) => {
  const folder = await temporaryFolder(t);
  const child = 'setInterval(() => require("fs").appendFileSync("alive", "x"), 20)';
  const body =
    `require("child_process").spawn(process.execPath, ["-e", ${JSON.stringify(child)}], { ` +
    'stdio: "inherit" }); ';
  const stop = new AbortController();
  const hanging = await script(folder, 'hang', `${body} setInterval(() => 0, 1000)`);
  const running = runCommand(
    { what: 'try', argv: [hanging], folder, limits: kLimits },
    stop.signal,
  );
  while (!(await readdir(folder)).includes('alive')) await delay(10);
  stop.abort(new Error('stopped by a test'));
  await assert.rejects(running, /stopped by a test/);
  await assertStill(join(folder, 'alive'));
  const leaving = await script(folder, 'leave', `${body} setTimeout(() => process.exit(0), 300)`);
  await runCommand({ what: 'try', argv: [leaving], folder, limits: kLimits }, kNever);
  await assertStill(join(folder, 'alive'));
});

/** The file grows no more, sooner or later: a writer adds a byte every 20 ms while it lives. */
async function assertStill(path: string): Promise<void> {
  let before = -1;
  for (let tries = 0; tries < 1000; ++tries) {
    const now = (await readFile(path)).length;
    if (now === before) return;
    before = now;
    await delay(300);
  }
  assert.fail(`${path} still grows`);
}

test('work folders are removed after their work, and before the next run', async (t) => {
  const root = await temporaryFolder(t);
  await assert.rejects(
    withWorkFolder(root, async (folder) => Promise.reject(new Error(folder))),
    /\.work-/,
  );
  assert.deepEqual(await readdir(root), []);
  await mkdir(join(root, '.work-abc', 'deep'), { recursive: true });
  await mkdir(join(root, 'lidar'));
  await removeStaleWork(root);
  assert.deepEqual(await readdir(root), ['lidar']);
});

// Compiles the grabber and its tests, and runs them:
//   node run.js [what grabber/run-tests.js takes]
import { spawnSync } from 'node:child_process';
import { existsSync, readdirSync, rmSync } from 'node:fs';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';

const kGrabber = fileURLToPath(new URL('../../grabber', import.meta.url));
const kCompiler = join(kGrabber, 'node_modules/typescript/bin/tsc');
const kTests = join(kGrabber, 'dist-test/tests');
if (!existsSync(kCompiler)) {
  process.stderr.write('The packages of the grabber are missing: run ./terravox deps\n');
  process.exit(1);
}

// Those whose source is gone would still run. All else stays: other programs may be reading it, and
// the compiler makes only what has changed.
for (const name of existsSync(kTests) ? readdirSync(kTests, { recursive: true }) : []) {
  const source = join(kGrabber, '../tests', name.replace(/js$/, 'ts'));
  if (name.endsWith('.test.js') && !existsSync(source)) rmSync(join(kTests, name));
}

for (const words of [
  [kCompiler, '-p', 'tsconfig.test.json'],
  ['run-tests.js', ...process.argv.slice(2)],
]) {
  const run = spawnSync(process.execPath, words, { cwd: kGrabber, stdio: 'inherit' });
  if (run.error !== undefined) throw run.error;
  if (run.status !== 0) process.exit(run.status ?? 1);
}

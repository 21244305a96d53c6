// Checks the types of the page and of its tests, bundles both, and runs the tests: node run.mjs [arguments of node --test]
import { spawnSync } from 'node:child_process';
import { createRequire } from 'node:module';
import { existsSync, readdirSync, rmSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));
const page = join(here, '../../voxelserver/page');
const modules = join(page, 'node_modules');
if (!existsSync(modules)) {
  console.error('The packages of the page are missing: run ./terravox deps');
  process.exit(1);
}

function run(...args) {
  const { status, error } = spawnSync(process.execPath, args, { stdio: 'inherit' });
  if (error) throw error;
  if (status !== 0) process.exit(status ?? 1);
}

run(join(modules, 'typescript/bin/tsc'), '-p', join(page, 'tsconfig.json'));
run(join(modules, 'typescript/bin/tsc'), '-p', join(here, 'tsconfig.json'));
run(join(page, 'build.mjs'), join(page, 'dist'));

// Beside node_modules, so that what is not bundled is found.
const out = join(page, 'dist-test');
rmSync(out, { recursive: true, force: true });
const { build } = createRequire(join(page, 'package.json'))('esbuild');
const tests = readdirSync(here).filter((name) => name.endsWith('.test.ts'));
await build({
  entryPoints: tests.map((name) => join(here, name)),
  outdir: out,
  outExtension: { '.js': '.mjs' },
  bundle: true,
  platform: 'node',
  format: 'esm',
  target: 'node20',
  sourcemap: 'inline',
  nodePaths: [modules],
  external: ['playwright-core'],
  define: { TERRAVOX_PAGE_DIST: JSON.stringify(join(page, 'dist')) },
  logLevel: 'warning',
});
run('--enable-source-maps', '--test', ...process.argv.slice(2), ...tests.map((name) => join(out, name.replace(/ts$/, 'mjs'))));

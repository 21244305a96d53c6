// Checks the types of the page and of its tests, bundles both, and runs the tests:
//   node run.mjs [--tier default|all] [arguments of node --test]
// With --tier all those that are called *.all.test.ts, with --tier default the others.
// With TERRAVOX_URL or TERRAVOX_VIEWED, a server's address, or TERRAVOX_SITE, TERRAVOX_SITE_DRAWING
// or TERRAVOX_SITE_TOOLS, that of a published site, it runs what depends on these alone.
import { spawn } from 'node:child_process';
import { createRequire } from 'node:module';
import { existsSync, readdirSync, rmSync } from 'node:fs';
import { availableParallelism } from 'node:os';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

import { kReporters } from '../skips.mjs';

const here = dirname(fileURLToPath(import.meta.url));
const page = join(here, '../../voxelserver/serve/page');
const modules = join(page, 'node_modules');
const words = process.argv.slice(2);
const tier = words[0] === '--tier' ? words.splice(0, 2)[1] : undefined;
if (!existsSync(modules)) {
  console.error('The packages of the page are missing: run ./terravox deps');
  process.exit(1);
}

/** Runs node with these arguments. Resolves to its exit code; ended by a signal: 1. */
function run(...args) {
  return new Promise((resolve, reject) => {
    const child = spawn(process.execPath, args, { stdio: 'inherit' });
    child.on('error', reject);
    child.on('exit', (code) => resolve(code ?? 1));
  });
}

// The type checks compute while the tests mostly wait for a browser: they run side by side.
const given = {
  TERRAVOX_URL: ['page.all.test.ts'],
  TERRAVOX_SITE: ['site.test.ts'],
  TERRAVOX_SITE_DRAWING: ['site-drawing.test.ts'],
  TERRAVOX_SITE_TOOLS: ['site-tools.test.ts'],
  TERRAVOX_VIEWED: ['server-view.test.ts'],
};
const forPrograms = Object.entries(given).flatMap(([name, files]) =>
  name === 'TERRAVOX_URL' ? [] : files,
);
const alone = Object.keys(given).find((name) => process.env[name] !== undefined);
const checks = (alone !== undefined || tier === 'all' ? [] : [page, here]).map((folder) =>
  run(join(modules, 'typescript/bin/tsc'), '-p', join(folder, 'tsconfig.json')),
);
const built = await run(join(page, 'build.mjs'), join(page, 'dist'));
if (built !== 0) process.exit(built);

// Next to node_modules, so that packages that are not bundled are found.
const out = join(page, 'dist-test');
rmSync(out, { recursive: true, force: true });
const { build } = createRequire(join(page, 'package.json'))('esbuild');
const isOfTier = (name) => tier === undefined || name.endsWith('.all.test.ts') === (tier === 'all');
const isForAll = (name) =>
  name.endsWith('.test.ts') && !forPrograms.includes(name) && isOfTier(name);
const tests = alone !== undefined ? given[alone] : readdirSync(here).filter(isForAll);
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
  define: {
    TERRAVOX_PAGE_DIST: JSON.stringify(join(page, 'dist')),
    TERRAVOX_ROOT: JSON.stringify(join(here, '../..')),
  },
  logLevel: 'warning',
});
const files = tests.map((name) => join(out, name.replace(/ts$/, 'mjs')));
const tested = await run(
  '--enable-source-maps',
  '--test',
  ...kReporters,
  `--test-concurrency=${availableParallelism()}`,
  ...words,
  ...files,
);
process.exit(Math.max(tested, ...(await Promise.all(checks))));

// Bundles the pages: node build.mjs FOLDER writes there
// - of the voxel server's page: index.html, app.js, app.css
// - of the viewer: viewer.html, viewer.js, worker.js, viewer.css
// - licences.txt of the packages in both
import { build } from 'esbuild';
import { copyFile, mkdir, writeFile } from 'node:fs/promises';
import { basename, dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { licencesOf, packagesOf } from './licences.mjs';

const root = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2];
if (out === undefined || process.argv.length > 3) {
  console.error('usage: node build.mjs FOLDER');
  process.exit(2);
}

await mkdir(out, { recursive: true });
const result = await build({
  absWorkingDir: root,
  entryPoints: {
    'app': 'src/app.ts',
    'style': 'src/app.css',
    'viewer': 'src/viewer/viewer.ts',
    'worker': 'src/viewer/data/worker.ts',
    'viewer-style': 'src/viewer/viewer.css',
  },
  loader: { '.glsl': 'text' },
  outdir: out,
  write: false,
  bundle: true,
  minify: true,
  format: 'esm',
  target: ['es2022', 'chrome111', 'firefox115', 'safari16.4'],
  charset: 'utf8',
  legalComments: 'none',
  metafile: true,
  logLevel: 'warning',
});
const renamed = { 'style.css': 'app.css', 'viewer-style.css': 'viewer.css' };
for (const file of result.outputFiles) {
  const name = basename(file.path);
  await writeFile(join(out, renamed[name] ?? name), file.contents);
}
for (const name of ['index.html', 'viewer.html']) await copyFile(join(root, name), join(out, name));
const about = 'This page holds parts of these packages.';
const licences = await licencesOf(packagesOf(result.metafile), root, about);
await writeFile(join(out, 'licences.txt'), licences);

// Bundles the pages: node build.mjs FOLDER writes there
// - of the voxel server's page: index.html, app.js, app.css
// - of the viewer: viewer.html, viewer.js, worker.js, viewer.css
// - licences.txt of the packages in both
import { build } from 'esbuild';
import { copyFile, mkdir, readFile, readdir, writeFile } from 'node:fs/promises';
import { basename, dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const root = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2];
if (out === undefined || process.argv.length > 3) {
  console.error('usage: node build.mjs FOLDER');
  process.exit(2);
}

// Which packages a bundle is made of, from the files that went into it.
function packagesOf(metafile) {
  const used = new Set();
  for (const [, output] of Object.entries(metafile.outputs))
    for (const [file, { bytesInOutput }] of Object.entries(output.inputs)) {
      const found = /node_modules\/((?:@[^/]+\/)?[^/]+)\//.exec(file);
      if (found && bytesInOutput > 0) used.add(found[1]);
    }
  return [...used].sort();
}

async function licenceOf(name) {
  const folder = join(root, 'node_modules', name);
  const about = JSON.parse(await readFile(join(folder, 'package.json'), 'utf8'));
  const file = (await readdir(folder)).find((entry) => /^licen[cs]e(\.(md|txt))?$/i.test(entry));
  if (file === undefined) throw new Error(`${name}: its package has no licence file`);
  return `${name} ${about.version} (${about.license})\n\n${(await readFile(join(folder, file), 'utf8')).trim()}\n`;
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
const rule = `\n${'-'.repeat(100)}\n\n`;
const licences = await Promise.all(packagesOf(result.metafile).map(licenceOf));
await writeFile(join(out, 'licences.txt'), `This page holds parts of these packages.\n${rule}${licences.join(rule)}`);

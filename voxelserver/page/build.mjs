// Bundles the page: node build.mjs FOLDER writes index.html, app.js, app.css and licences.txt there.
import { build } from 'esbuild';
import { copyFile, mkdir, readFile, readdir, writeFile } from 'node:fs/promises';
import { dirname, join } from 'node:path';
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
  entryPoints: { app: 'src/app.ts', style: 'src/app.css' },
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
for (const file of result.outputFiles) await writeFile(join(out, file.path.endsWith('.css') ? 'app.css' : 'app.js'), file.contents);
await copyFile(join(root, 'index.html'), join(out, 'index.html'));
const rule = `\n${'-'.repeat(100)}\n\n`;
const licences = await Promise.all(packagesOf(result.metafile).map(licenceOf));
await writeFile(join(out, 'licences.txt'), `This page holds parts of these packages.\n${rule}${licences.join(rule)}`);

// Bundles the pages: node build.mjs FOLDER writes there
// - of the voxel server's page: index.html, app.js, app.css
// - of the viewer: viewer.html, viewer.js, worker.js, viewer.css
// - licences.txt of the packages in both
import { copyFile, mkdir, writeFile } from 'node:fs/promises';
import { basename, dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { readLicences, listPackages } from './licences.mjs';

const root = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2];
if (out === undefined || process.argv.length > 3) {
  console.error('usage: node build.mjs FOLDER');
  process.exit(2);
}

const { build } = await import('esbuild').catch(() => {
  const missing = 'the packages in voxelserver/serve/page/node_modules are missing';
  console.error(`Bundle the web page: ${missing}; run ./terravox deps`);
  process.exit(1);
});
await mkdir(out, { recursive: true });
// Rasters of analyses are packed by DEFLATE: other decoders would be most of what is bundled.
const deflateAlone = {
  name: 'deflate-alone',
  setup({ onLoad }) {
    const filter = /geotiff.*compression.(jpeg|lerc|lzw|packbits|webimage|zstd)\.js$/;
    const contents = 'throw new Error("the raster is not packed by DEFLATE")';
    onLoad({ filter }, () => ({ contents }));
  },
};
const common = {
  absWorkingDir: root,
  plugins: [deflateAlone],
  loader: { '.glsl': 'text' },
  outdir: out,
  write: false,
  bundle: true,
  minify: true,
  target: ['es2022', 'chrome111', 'firefox115', 'safari16.4'],
  charset: 'utf8',
  legalComments: 'none',
  metafile: true,
  logLevel: 'warning',
};
const modules = {
  app: 'src/app.ts',
  style: 'src/app.css',
  worker: 'src/viewer/data/worker.ts',
  'viewer-style': 'src/viewer/viewer.css',
};
// Browsers load no module from a disk: the viewer's script is none, so that it can say so there.
const built = await Promise.all([
  build({ ...common, format: 'esm', entryPoints: modules }),
  build({ ...common, format: 'iife', entryPoints: { viewer: 'src/viewer/viewer.ts' } }),
]);
const renamed = { 'style.css': 'app.css', 'viewer-style.css': 'viewer.css' };
for (const { outputFiles } of built) {
  for (const file of outputFiles) {
    const name = basename(file.path);
    await writeFile(join(out, renamed[name] ?? name), file.contents);
  }
}
for (const name of ['index.html', 'viewer.html']) await copyFile(join(root, name), join(out, name));
const about = 'This page holds parts of these packages.';
const licences = await readLicences(listPackages(built), root, about);
await writeFile(join(out, 'licences.txt'), licences);

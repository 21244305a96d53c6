// Makes the grabber ready to be installed: node bundle.js FOLDER ARCHITECTURE writes there
// - dist/main.js and its parts, of what `npm run build` made and of most packages
// - node_modules: packages that are loaded by name while it runs, compiled for Linux on that
//   processor (x64 or arm64, as Node.js names them)
// - migrations, package.json, licences.txt
import { cp, mkdir, readFile, rm, writeFile } from 'node:fs/promises';
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { readLicences, listPackages } from '../voxelserver/serve/page/licences.mjs';

const root = fileURLToPath(new URL('.', import.meta.url));
// The page's build has the bundler.
const { build } = createRequire(join(root, '../voxelserver/serve/page/package.json'))('esbuild');
const [out, architecture, more] = process.argv.slice(2);
if (!['x64', 'arm64'].includes(architecture) || more !== undefined) {
  process.stderr.write('usage: node bundle.js FOLDER x64|arm64\n');
  process.exit(2);
}

/** What is copied of each package that is not bundled. */
const kCopied = {
  // Its compiled part is found by its place in the package.
  '@photostructure/sqlite': ['dist', `prebuilds/linux-${architecture}`],
  'node-gyp-build': ['index.js', 'node-gyp-build.js'],
  // A file for each coordinate system.
  'epsg-index': ['s'],
  // Loaded when the first place is projected.
  proj4: ['dist/proj4-src.js'],
};
/** Forms of packages that nothing loads: for another C library, another import, for compilers. */
const kUnused = /\.musl\.node$|\.(?:map|cjs|[cm]?ts)$/;
/** Packages in the older form call require(), which modules lack. */
const kRequire =
  "import { createRequire as makeRequire } from 'node:module';\n" +
  'globalThis.require ??= makeRequire(import.meta.url);';

async function copyPackage(name) {
  const from = join(root, 'node_modules', name);
  const to = join(out, 'node_modules', name);
  await mkdir(to, { recursive: true });
  const filter = (path) => !kUnused.test(path);
  for (const part of kCopied[name]) {
    await cp(join(from, part), join(to, part), { recursive: true, filter });
  }
  const about = JSON.parse(await readFile(join(from, 'package.json'), 'utf8'));
  const { version, license, main, exports } = about;
  const manifest = { name, version, license, main, exports };
  await writeFile(join(to, 'package.json'), `${JSON.stringify(manifest, null, 2)}\n`);
}

await rm(out, { recursive: true, force: true });
await mkdir(out, { recursive: true });
const result = await build({
  absWorkingDir: root,
  entryPoints: ['dist/main.js'],
  outdir: join(out, 'dist'),
  bundle: true,
  splitting: true,
  platform: 'node',
  format: 'esm',
  target: 'node20',
  charset: 'utf8',
  legalComments: 'none',
  external: Object.keys(kCopied),
  banner: { js: kRequire },
  metafile: true,
  logLevel: 'warning',
});
for (const name of Object.keys(kCopied)) await copyPackage(name);
for (const name of ['migrations', 'package.json']) {
  await cp(join(root, name), join(out, name), { recursive: true });
}
const packages = [...listPackages([result]), ...Object.keys(kCopied)].sort();
const about = 'The grabber holds these packages, or parts of them.';
await writeFile(join(out, 'licences.txt'), await readLicences(packages, root, about));

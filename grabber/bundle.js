// Makes the grabber ready to be installed: node bundle.js FOLDER writes there
// - dist/main.js and its parts, of what `npm run build` made and of most packages
// - node_modules: packages that are loaded by name while it runs
// - migrations, package.json, licences.txt, and node-abi, which the compiled package was built for
import { cp, mkdir, readFile, rm, writeFile } from 'node:fs/promises';
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { licencesOf, packagesOf } from '../voxelserver/page/licences.mjs';

const root = fileURLToPath(new URL('.', import.meta.url));
// The page's build has the bundler.
const { build } = createRequire(join(root, '../voxelserver/page/package.json'))('esbuild');
const out = process.argv[2];
if (out === undefined || process.argv.length > 3) {
  process.stderr.write('usage: node bundle.js FOLDER\n');
  process.exit(2);
}

/** What is copied of each package that is not bundled. */
const kCopied = {
  // Its compiled part is found by its place in the package.
  'better-sqlite3': ['lib', 'build/Release/better_sqlite3.node'],
  bindings: ['bindings.js'],
  'file-uri-to-path': ['index.js'],
  // A file for each coordinate system.
  'epsg-index': ['s'],
  // Loaded when the first place is projected.
  proj4: ['dist/proj4-src.js'],
};
/** Packages in the older form call require(), which modules lack. */
const kRequire =
  "import { createRequire as requireOf } from 'node:module';\n" +
  'globalThis.require ??= requireOf(import.meta.url);';

async function copyPackage(name) {
  const from = join(root, 'node_modules', name);
  const to = join(out, 'node_modules', name);
  await mkdir(to, { recursive: true });
  for (const part of kCopied[name]) await cp(join(from, part), join(to, part), { recursive: true });
  const { version, license, main } = JSON.parse(await readFile(join(from, 'package.json'), 'utf8'));
  const manifest = { name, version, license, main };
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
const packages = [...packagesOf(result.metafile), ...Object.keys(kCopied)].sort();
const about = 'The grabber holds these packages, or parts of them.';
await writeFile(join(out, 'licences.txt'), await licencesOf(packages, root, about));
await writeFile(join(out, 'node-abi'), `${process.versions.modules}\n`);

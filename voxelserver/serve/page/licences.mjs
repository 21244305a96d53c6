// The licences of the packages that esbuild has put into a bundle.
import { readFile, readdir } from 'node:fs/promises';
import { join } from 'node:path';

const kRule = `\n${'-'.repeat(100)}\n\n`;

/** Which packages the bundles of builds are made of, from the files that went into them. */
export function listPackages(builds) {
  const used = new Set();
  for (const output of builds.flatMap(({ metafile }) => Object.values(metafile.outputs))) {
    for (const [file, { bytesInOutput }] of Object.entries(output.inputs)) {
      const found = /node_modules\/((?:@[^/]+\/)?[^/]+)\//.exec(file);
      if (found && bytesInOutput > 0) used.add(found[1]);
    }
  }
  return [...used].sort();
}

/**
 * @param root  folder of the node_modules with these packages
 * @param about the first line
 */
export async function readLicences(packages, root, about) {
  const texts = await Promise.all(packages.map((name) => readLicence(name, root)));
  return `${about}\n${kRule}${texts.join(kRule)}`;
}

async function readLicence(name, root) {
  const folder = join(root, 'node_modules', name);
  const about = JSON.parse(await readFile(join(folder, 'package.json'), 'utf8'));
  const file = (await readdir(folder)).find((entry) => /^licen[cs]e(\.(md|txt))?$/i.test(entry));
  const text =
    file === undefined
      ? 'The package names its licence, and holds no text of it.'
      : (await readFile(join(folder, file), 'utf8')).trim();
  return `${name} ${about.version} (${about.license})\n\n${text}\n`;
}

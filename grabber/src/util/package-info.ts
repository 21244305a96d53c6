import { existsSync, readFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { systemCode } from './errors.js';

const kPackageName = 'terravox-grabber';

export type PackageInfo = {
  readonly version: string;
  /** Folder that holds package.json. */
  readonly root: string;
};

/** Walks up from this module, since its depth below package.json differs between build outputs. */
export function readPackageInfo(): PackageInfo {
  let folder = dirname(fileURLToPath(import.meta.url));
  for (;;) {
    const found = readManifest(join(folder, 'package.json'));
    if (found?.name === kPackageName && found.version !== undefined) {
      return { version: found.version, root: folder };
    }
    const parent = dirname(folder);
    if (parent === folder) {
      throw new Error(`find package.json of ${kPackageName} above ${import.meta.url}: none found`);
    }
    folder = parent;
  }
}

function readManifest(path: string): { name?: string; version?: string } | undefined {
  try {
    return JSON.parse(readFileSync(path, 'utf8')) as { name?: string; version?: string };
  } catch (error) {
    if (systemCode(error) === 'ENOENT') return undefined;
    throw error;
  }
}

/**
 * The folder of the data files that ship with the programs: TERRAVOX_CONFIG when set, else that of
 * the checkout, or of the prefix where the grabber is installed (lib/terravox/grabber).
 */
export function shippedConfig(info: PackageInfo): string {
  const given = process.env['TERRAVOX_CONFIG'];
  if (given !== undefined && given !== '') return given;
  const checkout = join(info.root, '..', 'config');
  const installed = join(info.root, '..', '..', '..', 'share', 'terravox', 'config');
  return existsSync(join(checkout, 'materials.toml')) ? checkout : installed;
}

/** Portals ask robots to identify themselves. */
export function userAgent(info: PackageInfo): string {
  return `${kPackageName}/${info.version}`;
}

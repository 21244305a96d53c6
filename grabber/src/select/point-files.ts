import { readdir } from 'node:fs/promises';
import { join } from 'node:path';
import { describeError } from '../util/errors.js';
import { usage } from './usage.js';

/** Best first: of one square's files the one that can be used as it is and is smallest. */
const kExtensions = ['laz', 'las', 'zlas'] as const;
type Extension = (typeof kExtensions)[number];

const kPointFile = /^(.+?)(?:\.copc)?\.(laz|las|zlas)$/i;

export type PointFile = {
  readonly path: string;
  readonly stem: string;
  readonly extension: Extension;
};

/**
 * Every LAZ, LAS and zLAS file below a folder, sorted by path; files and folders whose name starts
 * with a dot are none.
 */
export async function findPointFiles(folder: string, signal: AbortSignal): Promise<PointFile[]> {
  const files: PointFile[] = [];
  const waiting = [folder];
  for (let next = waiting.pop(); next !== undefined; next = waiting.pop()) {
    signal.throwIfAborted();
    for (const entry of await listFolder(next)) {
      if (entry.name.startsWith('.')) continue;
      const path = join(next, entry.name);
      if (entry.isDirectory()) waiting.push(path);
      const match = entry.isDirectory() ? null : kPointFile.exec(entry.name);
      if (match?.[1] === undefined || match[2] === undefined) continue;
      files.push({ path, stem: match[1], extension: match[2].toLowerCase() as Extension });
    }
  }
  return files.sort((a, b) => (a.path < b.path ? -1 : 1));
}

async function listFolder(folder: string) {
  try {
    return await readdir(folder, { withFileTypes: true });
  } catch (error) {
    throw usage(
      `read folder ${folder}: ${describeError(error)}; allowed: a folder that can be read`,
      error,
    );
  }
}

/**
 * Those of the best kind there is.
 * @param files of one square
 */
export function chooseBest(files: readonly PointFile[]): readonly PointFile[] {
  const extension = kExtensions.find((wanted) => files.some((file) => file.extension === wanted));
  return files.filter((file) => file.extension === extension);
}

import { mkdtemp, open, readdir, rm } from 'node:fs/promises';
import { join } from 'node:path';

const kPrefix = '.work-';

/**
 * A folder inside the store for one piece of work, so that its result can be renamed into place. It
 * is removed when the work ends; after a crash removeStaleWork does it.
 */
export async function withWorkFolder<T>(
  storeRoot: string,
  work: (folder: string) => Promise<T>,
): Promise<T> {
  const folder = await mkdtemp(join(storeRoot, kPrefix));
  try {
    return await work(folder);
  } finally {
    await rm(folder, { recursive: true, force: true });
  }
}

/**
 * Removes the work folders that interrupted runs have left. The caller holds the store's lock, and
 * has started no work yet.
 */
export async function removeStaleWork(storeRoot: string): Promise<void> {
  for (const name of await readdir(storeRoot).catch(() => [])) {
    if (name.startsWith(kPrefix)) await rm(join(storeRoot, name), { recursive: true, force: true });
  }
}

/**
 * Writes a file's data to the disk. Without this, a power cut after a rename may leave a name
 * without content.
 */
export async function flushFile(path: string): Promise<void> {
  const file = await open(path, 'r+');
  try {
    await file.datasync();
  } finally {
    await file.close();
  }
}

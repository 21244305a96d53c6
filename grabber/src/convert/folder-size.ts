import { lstat, readdir } from 'node:fs/promises';
import { join } from 'node:path';

const kPollInterval_ms = 250;

/**
 * Sums the bytes of all files below `folder`. Links are not followed, and files that vanish
 * meanwhile count as 0.
 */
export async function folderBytes(folder: string): Promise<number> {
  let bytes = 0;
  for (const entry of await readdir(folder, { withFileTypes: true }).catch(() => [])) {
    const path = join(folder, entry.name);
    if (entry.isDirectory()) bytes += await folderBytes(path);
    else {
      bytes += await lstat(path).then(
        (found) => found.size,
        () => 0,
      );
    }
  }
  return bytes;
}

/**
 * Calls `stop` once when the folder holds more than `max_bytes`.
 * @return ends the watch
 */
export function watchFolder(
  folder: string,
  max_bytes: number,
  stop: (why: string) => void,
): () => void {
  let looking = false;
  const timer = setInterval(() => {
    if (looking) return;
    looking = true;
    void folderBytes(folder).then((bytes) => {
      looking = false;
      if (bytes > max_bytes) stop(`it filled its folder with ${bytes} bytes`);
    });
  }, kPollInterval_ms);
  return () => clearInterval(timer);
}

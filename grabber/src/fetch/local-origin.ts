import { createHash } from 'node:crypto';
import { createReadStream } from 'node:fs';
import { open, readdir } from 'node:fs/promises';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import type { Square } from '../sources/square.js';
import { GrabberError, describeError } from '../util/errors.js';
import type { Origin, TransferResult } from './origin.js';

/** Best first: of one square's files the one that can be used as it is and is smallest. */
const kExtensions = ['laz', 'las', 'zlas'] as const;
type Extension = (typeof kExtensions)[number];

const kPointFile = /^(.+?)(?:\.copc)?\.(laz|las|zlas)$/i;

export type LocalFile = { readonly path: string; readonly stem: string; readonly extension: Extension };

/** Every LAZ, LAS and zLAS file below a folder, sorted by path. */
export async function findPointFiles(folder: string, signal: AbortSignal): Promise<LocalFile[]> {
  const files: LocalFile[] = [];
  const waiting = [folder];
  for (let next = waiting.pop(); next !== undefined; next = waiting.pop()) {
    signal.throwIfAborted();
    for (const entry of await listFolder(next)) {
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
    throw new GrabberError(
      'USAGE',
      `read folder ${folder}: ${describeError(error)}; allowed: a folder that can be read`,
      { cause: error },
    );
  }
}

/** @param files by square name, each list not empty */
export function localOrigin(folder: string, files: ReadonlyMap<string, readonly LocalFile[]>): Origin {
  const best = (square: Square): readonly LocalFile[] => {
    const all = files.get(square.name) ?? [];
    const extension = kExtensions.find((wanted) => all.some((file) => file.extension === wanted));
    return all.filter((file) => file.extension === extension);
  };
  return {
    urlOf: (square) => pathToFileURL(best(square)[0]?.path ?? folder).href,
    transfer: async (square, partial, signal) => {
      const [file, second] = best(square);
      if (file === undefined) return { kind: 'missing', reason: 'no such file in the folder' };
      if (second !== undefined) {
        throw new GrabberError(
          'AMBIGUOUS_FILE',
          `copy square ${square.name}: ${file.path} and ${second.path} both claim it; allowed: one file`,
        );
      }
      return copyFile(file.path, partial, signal);
    },
  };
}

async function copyFile(path: string, partial: string, signal: AbortSignal): Promise<TransferResult> {
  const hash = createHash('sha256');
  let bytes = 0;
  try {
    const target = await open(partial, 'w');
    try {
      for await (const chunk of createReadStream(path, { signal })) {
        await target.writeFile(chunk as Buffer);
        hash.update(chunk as Buffer);
        bytes += (chunk as Buffer).length;
      }
      await target.sync();
    } finally {
      await target.close();
    }
  } catch (error) {
    signal.throwIfAborted();
    throw new GrabberError('STORE_IO', `copy ${path} to ${partial}: ${describeError(error)}`, { cause: error });
  }
  return { kind: 'complete', bytes, sha256: hash.digest('hex') };
}

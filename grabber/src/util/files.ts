import { mkdir, open, readdir, rename, rm, stat } from 'node:fs/promises';
import { createHash, type Hash } from 'node:crypto';
import { createReadStream } from 'node:fs';
import { dirname } from 'node:path';
import { systemCode } from './errors.js';

/** Replaces `path` in one step: a reader sees the old text or the new text, never a part of it. */
export async function writeFileAtomically(
  path: string,
  text: string,
  signal: AbortSignal,
): Promise<void> {
  signal.throwIfAborted();
  const temporary = `${path}.tmp`;
  const file = await open(temporary, 'w');
  try {
    await file.writeFile(text);
    // Without the sync a power cut may leave the new name with no content.
    await file.sync();
  } finally {
    await file.close();
  }
  await rename(temporary, path);
}

/** @return size in bytes, or undefined when there is no such file */
export async function fileSize(path: string): Promise<number | undefined> {
  try {
    const found = await stat(path);
    return found.isFile() ? found.size : undefined;
  } catch (error) {
    if (systemCode(error) === 'ENOENT' || systemCode(error) === 'ENOTDIR') return undefined;
    throw error;
  }
}

/** Adds the bytes of a file to a running hash. */
export async function hashFileInto(hash: Hash, path: string, signal: AbortSignal): Promise<void> {
  for await (const chunk of createReadStream(path, { signal })) hash.update(chunk as Buffer);
}

export async function sha256OfFile(path: string, signal: AbortSignal): Promise<string> {
  const hash = createHash('sha256');
  await hashFileInto(hash, path, signal);
  return hash.digest('hex');
}

/**
 * With all that is missing above it. Node's own recursive way never ends where the system refuses a
 * name with ENOENT, as in /proc.
 */
export async function makeFolder(path: string): Promise<void> {
  const makeOne = async (): Promise<void> => {
    try {
      await mkdir(path);
    } catch (error) {
      if (systemCode(error) !== 'EEXIST' || !(await stat(path)).isDirectory()) throw error;
    }
  };
  try {
    await makeOne();
  } catch (error) {
    if (systemCode(error) !== 'ENOENT' || dirname(path) === path) throw error;
    await makeFolder(dirname(path));
    await makeOne();
  }
}

export async function removeIfThere(path: string): Promise<void> {
  await rm(path, { force: true });
}

/** File names directly in `folder` that end in `extension`, sorted. */
export async function namesInFolder(folder: string, extension: string): Promise<string[]> {
  const entries = await readdir(folder, { withFileTypes: true });
  return entries
    .filter((entry) => entry.isFile() && entry.name.endsWith(extension))
    .map((entry) => entry.name)
    .sort();
}

/** The first bytes of a file; all, where it has no more than these. */
export async function readStart(path: string, max_bytes: number): Promise<Buffer> {
  const file = await open(path, 'r');
  try {
    const length = Math.min((await file.stat()).size, max_bytes);
    const { buffer, bytesRead } = await file.read(Buffer.alloc(length), 0, length, 0);
    return buffer.subarray(0, bytesRead);
  } finally {
    await file.close();
  }
}

/** The text of a file or a reply, without the mark of its byte order. */
export function decodeText(pieces: readonly Uint8Array[]): string {
  return Buffer.concat(pieces)
    .toString('utf8')
    .replace(/^\uFEFF/, '');
}

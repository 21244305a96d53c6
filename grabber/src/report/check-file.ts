import { open } from 'node:fs/promises';
import { join } from 'node:path';
import { verifyLasFile } from '../las/verify.js';
import type { StoredFile } from '../model/square.js';
import type { FileKind } from '../store/layout.js';
import { describeError } from '../util/errors.js';
import { fileSize, sha256OfFile } from '../util/files.js';

/**
 * Reads all of a file of the store again: length, hash, and whether it opens as what it is.
 * @return what is wrong with it, undefined when nothing is
 * @throws the signal's reason when it aborts
 */
export async function findProblem(
  root: string,
  file: StoredFile,
  kind: FileKind,
  signal: AbortSignal,
): Promise<string | undefined> {
  const path = join(root, file.path);
  try {
    const wrong = await wrongBytes(root, file, signal);
    // zLAS is Esri's own format, and its header is not published.
    if (wrong !== undefined || file.path.endsWith('.zlas')) return wrong;
    return await (kind === 'lidar'
      ? lasProblem(path, file.path, signal)
      : tiffProblem(path, file.bytes));
  } catch (error) {
    signal.throwIfAborted();
    return describeError(error);
  }
}

/** @return in what way its bytes are not those that are recorded */
export async function wrongBytes(
  root: string,
  file: StoredFile,
  signal: AbortSignal,
): Promise<string | undefined> {
  const path = join(root, file.path);
  const bytes = await fileSize(path);
  if (bytes === undefined) return 'it is not there';
  if (bytes !== file.bytes) return `it has ${bytes} bytes; recorded: ${file.bytes}`;
  const sha256 = await sha256OfFile(path, signal);
  return sha256 === file.sha256 ? undefined : `its SHA-256 is ${sha256}; recorded: ${file.sha256}`;
}

async function lasProblem(path: string, shown: string, signal: AbortSignal): Promise<undefined> {
  await verifyLasFile(path, shown, signal);
}

/** Ref: Adobe, "TIFF Revision 6.0", 1992, section 2; BigTIFF has version 43 and 8-byte offsets. */
async function tiffProblem(path: string, bytes: number): Promise<string | undefined> {
  const file = await open(path, 'r');
  try {
    const { buffer, bytesRead } = await file.read(Buffer.alloc(16), 0, 16, 0);
    const order = buffer.toString('latin1', 0, 2);
    if (bytesRead < 16 || (order !== 'II' && order !== 'MM')) return 'it is no TIFF file';
    const little = order === 'II';
    const version = little ? buffer.readUInt16LE(2) : buffer.readUInt16BE(2);
    if (version !== 42 && version !== 43) return `its TIFF version is ${version}; allowed: 42, 43`;
    const offset = version === 43 ? bigTiffOffset(buffer, little) : tiffOffset(buffer, little);
    return offset < 8 || offset >= bytes
      ? `its directory is at ${offset}; allowed: 8 to ${bytes - 1}`
      : undefined;
  } finally {
    await file.close();
  }
}

/** @return the position of the first directory of a plain TIFF file */
function tiffOffset(header: Buffer, little: boolean): number {
  return little ? header.readUInt32LE(4) : header.readUInt32BE(4);
}

/** @return the position of the first directory of a BigTIFF file */
function bigTiffOffset(header: Buffer, little: boolean): number {
  return Number(little ? header.readBigUInt64LE(8) : header.readBigUInt64BE(8));
}

import { constants } from 'node:fs';
import { copyFile, stat } from 'node:fs/promises';
import { fileURLToPath } from 'node:url';
import { GrabberError, describeError, systemCode } from '../util/errors.js';
import { sha256OfFile } from '../util/files.js';
import { tooLarge } from './body-writer.js';
import { withStoreErrors } from './disk-space.js';
import { removePartial } from './partial.js';
import type { TransferContext, TransferResult } from './transfer.js';

/** Takes a file of this machine. File systems that can share blocks copy nothing (reflink). */
export async function copyLocal(
  url: string,
  partial: string,
  context: TransferContext,
  signal: AbortSignal,
): Promise<TransferResult> {
  const path = fileURLToPath(url);
  let bytes: number;
  try {
    const found = await stat(path);
    if (!found.isFile()) throw new Error('not a file');
    bytes = found.size;
  } catch (error) {
    if (systemCode(error) === 'ENOENT') {
      return { kind: 'missing', reason: 'no such file in the folder' };
    }
    throw new GrabberError(
      'LOCAL_FILE',
      `copy ${path}: ${describeError(error)}; allowed: a file that can be read`,
      { cause: error },
    );
  }
  if (bytes > context.max_bytes) throw tooLarge(path, bytes, context.max_bytes);
  const release = context.disk.reserve(bytes, path);
  try {
    signal.throwIfAborted();
    removePartial(partial);
    await withStoreErrors(partial, () =>
      copyFile(path, partial, constants.COPYFILE_FICLONE | constants.COPYFILE_EXCL),
    );
    context.onBytes(bytes, bytes, bytes);
    return { kind: 'complete', bytes, sha256: await sha256OfFile(partial, signal) };
  } finally {
    release();
  }
}

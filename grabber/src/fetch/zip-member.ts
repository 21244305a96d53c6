import { createHash } from 'node:crypto';
import { closeSync } from 'node:fs';
import { crc32 } from 'node:zlib';
import { openPromise, type Entry, type ZipFile } from 'yauzl';
import type { Clock } from '../util/clock.js';
import { GrabberError, describeError } from '../util/errors.js';
import { tooLarge, writeBody, checkGrowth } from './body-writer.js';
import type { DiskSpace } from './disk-space.js';
import { openPartial } from './partial.js';

const kPointFile = /\.(laz|las)$/i;
/** Archives of portals hold one file to a few; a directory of millions is an attack. */
const kMaxMembers = 10_000;

export type UnzipContext = {
  readonly disk: DiskSpace;
  readonly clock: Clock;
  readonly max_bytes: number;
};

/**
 * Unpacks one member of an archive. Names in the archive are compared, never used as a path.
 * @param member its name, with or without its folders; "*" = the only point cloud
 * @return length and hash of what was unpacked
 * @throws GrabberError ARCHIVE
 */
export async function unzipMember(
  archive: string,
  member: string,
  target: string,
  shown: string,
  context: UnzipContext,
  signal: AbortSignal,
): Promise<{ bytes: number; sha256: string }> {
  let zip: ZipFile;
  try {
    zip = await openPromise(archive, {
      lazyEntries: true,
      autoClose: false,
      validateEntrySizes: true,
    });
  } catch (error) {
    throw archiveError(shown, describeError(error), true);
  }
  try {
    const entry = await findMember(zip, member, shown, signal);
    checkEntry(entry, shown, context.max_bytes);
    const release = context.disk.reserve(entry.uncompressedSize, `member of ${shown}`);
    try {
      return await unpack(zip, entry, target, shown, context);
    } finally {
      release();
    }
  } finally {
    zip.close();
  }
}

async function findMember(
  zip: ZipFile,
  member: string,
  shown: string,
  signal: AbortSignal,
): Promise<Entry> {
  const wanted = member.toLowerCase();
  const fits: Entry[] = [];
  let seen = 0;
  try {
    for await (const entry of zip.eachEntry()) {
      signal.throwIfAborted();
      seen += 1;
      if (seen > kMaxMembers) {
        throw archiveError(shown, `more than ${kMaxMembers} members`, false);
      }
      const name = entry.fileName.toLowerCase();
      const same =
        wanted === '*' ? kPointFile.test(name) : name === wanted || name.endsWith(`/${wanted}`);
      if (same) fits.push(entry);
    }
  } catch (error) {
    signal.throwIfAborted();
    if (error instanceof GrabberError) throw error;
    throw archiveError(shown, describeError(error), true);
  }
  const [entry] = fits;
  if (entry !== undefined && fits.length === 1) return entry;
  const what = member === '*' ? 'point clouds' : `members named "${member}"`;
  throw archiveError(
    shown,
    `${fits.length} ${what} among ${seen} members; allowed: exactly one`,
    false,
  );
}

function checkEntry(entry: Entry, shown: string, max_bytes: number): void {
  if (entry.isEncrypted()) {
    throw archiveError(shown, 'its member is encrypted; allowed: without a password', false);
  }
  if (!entry.canDecodeFileData()) {
    throw archiveError(
      shown,
      `its member has compression method ${entry.compressionMethod}; allowed: 0 (stored), ` +
        '8 (deflate)',
      false,
    );
  }
  if (entry.uncompressedSize > max_bytes) {
    throw tooLarge(`member of ${shown}`, entry.uncompressedSize, max_bytes);
  }
  checkGrowth(`member of ${shown}`, entry.compressedSize, entry.uncompressedSize);
}

async function unpack(
  zip: ZipFile,
  entry: Entry,
  target: string,
  shown: string,
  context: UnzipContext,
): Promise<{ bytes: number; sha256: string }> {
  const hash = createHash('sha256');
  let sum = 0;
  const fd = openPartial(target, 0);
  try {
    const body = (await zip.openReadStreamPromise(entry)) as AsyncIterable<Buffer>;
    const onPiece = (piece: Uint8Array): void => {
      sum = crc32(piece, sum);
    };
    const sink = {
      path: target,
      fd,
      hash,
      offset_bytes: 0,
      max_bytes: context.max_bytes,
      shown: `member of ${shown}`,
      onPiece,
    };
    const bytes = await writeBody(body, sink, context.clock);
    if (sum !== entry.crc32) {
      throw archiveError(
        shown,
        `CRC is ${sum.toString(16)}; allowed: ${entry.crc32.toString(16)}`,
        true,
      );
    }
    return { bytes, sha256: hash.digest('hex') };
  } catch (error) {
    if (error instanceof GrabberError) throw error;
    throw archiveError(shown, describeError(error), true);
  } finally {
    closeSync(fd);
  }
}

/** @param retryable a damaged archive may come whole the next time; one that is made so may not */
function archiveError(shown: string, what: string, retryable: boolean): GrabberError {
  return new GrabberError('ARCHIVE', `unpack ${shown}: ${what}`, { retryable });
}

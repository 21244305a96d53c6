import { open, type FileHandle } from 'node:fs/promises';
import { GrabberError } from '../util/errors.js';
import { kHeaderReadBytes, readLasHeader, truncated, type LasHeader } from './header.js';

const kVlrHeaderBytes = 54;
const kHeadBytes = 32 * 1024;
const kLaszipUser = 'laszip encoded';
const kLaszipRecord = 22204;
/** LASzip's compressor 1 writes one unbroken stream without a chunk table; 2 and 3 write chunks. */
const kPointwise = 1;
/** A header names its VLRs by count; a broken one must not make us walk the file forever. */
const kMaxVlrs = 10_000;

/**
 * Checks that a file on disk is a LAS or LAZ file and whole, as far as that can be told without decoding points:
 * plain records fit the file, and a LAZ file holds its chunk table, which is written last.
 */
export async function verifyLasFile(path: string, shown: string, signal: AbortSignal): Promise<LasHeader> {
  const handle = await open(path, 'r');
  try {
    const fileBytes = (await handle.stat()).size;
    const head = await readFrom(handle, 0, Math.min(kHeadBytes, fileBytes));
    const file: Reader = { handle, head };
    const header = readLasHeader(head.subarray(0, kHeaderReadBytes), fileBytes, shown);
    if (header.compressed) await checkChunkTable(file, fileBytes, header, shown, signal);
    return header;
  } finally {
    await handle.close();
  }
}

/** An open file with its beginning, where all but the chunk table mostly lies: one read instead of several. */
type Reader = { readonly handle: FileHandle; readonly head: Buffer };

async function checkChunkTable(
  file: Reader,
  fileBytes: number,
  header: LasHeader,
  shown: string,
  signal: AbortSignal,
): Promise<void> {
  const compressor = await readCompressor(file, header, shown, signal);
  if (compressor === kPointwise) return;
  if (header.pointOffset_bytes + 8 > fileBytes)
    throw truncated(shown, 'the chunk table pointer', header.pointOffset_bytes + 8, fileBytes);
  let table = (await readAt(file, header.pointOffset_bytes, 8)).readBigInt64LE(0);
  // A writer that could not seek back leaves -1 and appends the position at the very end.
  if (table === -1n) table = (await readAt(file, fileBytes - 8, 8)).readBigInt64LE(0);
  if (table < BigInt(header.pointOffset_bytes + 8)) {
    throw new GrabberError(
      'LAS_HEADER',
      `read ${shown}: chunk table position is ${table}; allowed: after the start of the points, ${header.pointOffset_bytes + 8}`,
    );
  }
  const position = Number(table);
  if (position + 8 > fileBytes) throw truncated(shown, 'the chunk table', position + 8, fileBytes);
  const chunks = (await readAt(file, position, 8)).readUInt32LE(4);
  if (chunks < 1 || chunks > header.pointCount) {
    throw new GrabberError(
      'LAS_HEADER',
      `read ${shown}: chunk count is ${chunks}; allowed: 1 to the point count, ${header.pointCount}`,
    );
  }
}

async function readCompressor(
  file: Reader,
  header: LasHeader,
  shown: string,
  signal: AbortSignal,
): Promise<number> {
  let position = header.headerSize_bytes;
  for (let index = 0; index < Math.min(header.vlrCount, kMaxVlrs); ++index) {
    signal.throwIfAborted();
    if (position + kVlrHeaderBytes + 2 > header.pointOffset_bytes) break;
    const vlr = await readAt(file, position, kVlrHeaderBytes + 2);
    const user = vlr.toString('latin1', 2, 18).replace(/\0.*$/s, '');
    if (user === kLaszipUser && vlr.readUInt16LE(18) === kLaszipRecord) return vlr.readUInt16LE(kVlrHeaderBytes);
    position += kVlrHeaderBytes + vlr.readUInt16LE(20);
  }
  throw new GrabberError(
    'LAS_HEADER',
    `read ${shown}: compressed point format without its LASzip record; allowed: one VLR "${kLaszipUser}" ${kLaszipRecord}`,
  );
}

/** The caller has checked that the bytes are there, so a short read is an error of the disk. */
async function readAt({ handle, head }: Reader, position: number, length: number): Promise<Buffer> {
  if (position + length <= head.length) return head.subarray(position, position + length);
  return readFrom(handle, position, length);
}

async function readFrom(handle: FileHandle, position: number, length: number): Promise<Buffer> {
  const buffer = Buffer.alloc(length);
  const { bytesRead } = await handle.read(buffer, 0, length, position);
  if (bytesRead !== length) {
    throw new GrabberError('STORE_IO', `read ${length} bytes at ${position}: got ${bytesRead}; allowed: all of them`);
  }
  return buffer;
}

import { closeSync, fstatSync, openSync, readSync } from 'node:fs';
import { GrabberError } from '../util/errors.js';
import { kHeaderReadBytes, readLasHeader, truncated, type LasHeader } from './header.js';

const kVlrHeaderBytes = 54;
const kExtendedHeaderBytes = 60;
const kLongestText_bytes = 65_535;
const kHeadBytes = 32 * 1024;
const kLaszipUser = 'laszip encoded';
const kLaszipRecord = 22204;
/** LASzip's compressor 1 writes one unbroken stream without a chunk table; 2 and 3 write chunks. */
const kPointwise = 1;
/** A header names its VLRs by count; a wrong count must not cause an endless walk. */
const kMaxVlrs = 10_000;

/** What a whole file says of itself. */
export type LasFile = LasHeader & {
  /** `EPSG:n`; undefined where the file has no CRS, or one without a code. */
  readonly crs: string | undefined;
};

/**
 * Checks that a file on disk is a LAS or LAZ file and whole, as far as is possible without decoding
 * points: plain records fit the file, and a LAZ file holds its chunk table, which is written last.
 * The three small reads are synchronous: passing one to a worker thread and back would cost a
 * hundred times the read itself.
 */
export async function verifyLasFile(
  path: string,
  shown: string,
  signal: AbortSignal,
): Promise<LasFile> {
  const fd = openSync(path, 'r');
  try {
    const fileBytes = fstatSync(fd).size;
    const head = readFrom(fd, 0, Math.min(kHeadBytes, fileBytes));
    const file: Reader = { fd, head };
    const header = readLasHeader(head.subarray(0, kHeaderReadBytes), fileBytes, shown);
    if (header.compressed) checkChunkTable(file, fileBytes, header, shown, signal);
    return { ...header, crs: readCrs(readRecords(file, header, fileBytes, signal)) };
  } finally {
    closeSync(fd);
  }
}

/**
 * An open file with its beginning, where all but the chunk table mostly lies: one read instead of
 * several.
 */
type Reader = { readonly fd: number; readonly head: Buffer };

function checkChunkTable(
  file: Reader,
  fileBytes: number,
  header: LasHeader,
  shown: string,
  signal: AbortSignal,
): void {
  const compressor = readCompressor(file, header, shown, signal);
  if (compressor === kPointwise) return;
  if (header.pointOffset_bytes + 8 > fileBytes) {
    throw truncated(shown, 'the chunk table pointer', header.pointOffset_bytes + 8, fileBytes);
  }
  let table = readAt(file, header.pointOffset_bytes, 8).readBigInt64LE(0);
  // A writer that could not seek back leaves -1 and appends the position at the very end.
  if (table === -1n) table = readAt(file, fileBytes - 8, 8).readBigInt64LE(0);
  if (table < BigInt(header.pointOffset_bytes + 8)) {
    throw new GrabberError(
      'LAS_HEADER',
      `read ${shown}: chunk table position is ${table}; allowed: after the start of the ` +
        `points, ${header.pointOffset_bytes + 8}`,
    );
  }
  const position = Number(table);
  if (position + 8 > fileBytes) throw truncated(shown, 'the chunk table', position + 8, fileBytes);
  const chunks = readAt(file, position, 8).readUInt32LE(4);
  if (chunks < 1 || chunks > header.pointCount) {
    throw new GrabberError(
      'LAS_HEADER',
      `read ${shown}: chunk count is ${chunks}; allowed: 1 to the point count, ` +
        `${header.pointCount}`,
    );
  }
}

function readCompressor(
  file: Reader,
  header: LasHeader,
  shown: string,
  signal: AbortSignal,
): number {
  for (const { user, record, data } of readVlrs(file, header, signal)) {
    if (user === kLaszipUser && record === kLaszipRecord && data.length >= 2) {
      return data.readUInt16LE(0);
    }
  }
  throw new GrabberError(
    'LAS_HEADER',
    `read ${shown}: compressed point format without its LASzip record; allowed: one VLR ` +
      `"${kLaszipUser}" ${kLaszipRecord}`,
  );
}

/** The variable length records; one that would reach into the points ends the list. */
function* readVlrs(file: Reader, header: LasHeader, signal: AbortSignal): Generator<Vlr> {
  let position = header.headerSize_bytes;
  for (let index = 0; index < Math.min(header.vlrCount, kMaxVlrs); ++index) {
    signal.throwIfAborted();
    if (position + kVlrHeaderBytes > header.pointOffset_bytes) return;
    const head = readAt(file, position, kVlrHeaderBytes);
    position += kVlrHeaderBytes;
    const length = head.readUInt16LE(20);
    if (position + length > header.pointOffset_bytes) return;
    yield toVlr(head, readAt(file, position, length));
    position += length;
  }
}

/** All records that may tell the CRS: those behind the points, from LAS 1.4 on, are the last. */
function* readRecords(
  file: Reader,
  header: LasHeader,
  fileBytes: number,
  signal: AbortSignal,
): Generator<Vlr> {
  yield* readVlrs(file, header, signal);
  let position = header.extended.at;
  for (let index = 0; index < Math.min(header.extended.count, kMaxVlrs); ++index) {
    signal.throwIfAborted();
    if (position + kExtendedHeaderBytes > fileBytes) return;
    const head = readAt(file, position, kExtendedHeaderBytes);
    position += kExtendedHeaderBytes;
    const length = Number(head.readBigUInt64LE(20));
    if (position + length > fileBytes) return;
    // Texts of a CRS are no longer than that; others may be as long as the points.
    if (length <= kLongestText_bytes) yield toVlr(head, readAt(file, position, length));
    position += length;
  }
}

function toVlr(head: Buffer, data: Buffer): Vlr {
  const user = head.toString('latin1', 2, 18).replace(/\0.*$/s, '');
  return { user, record: head.readUInt16LE(18), data };
}

/** The caller has checked that the bytes are there, so a short read is an error of the disk. */
function readAt({ fd, head }: Reader, position: number, length: number): Buffer {
  if (position + length <= head.length) return head.subarray(position, position + length);
  return readFrom(fd, position, length);
}

function readFrom(fd: number, position: number, length: number): Buffer {
  const buffer = Buffer.alloc(length);
  const bytesRead = readSync(fd, buffer, 0, length, position);
  if (bytesRead !== length) {
    throw new GrabberError(
      'STORE_IO',
      `read ${length} bytes at ${position}: got ${bytesRead}; allowed: all of them`,
    );
  }
  return buffer;
}

/** Ref: ASPRS, "LAS Specification 1.4 - R15", 2019, section 3.2: records of the CRS. */
const kUser = 'LASF_Projection';
const kWktRecord = 2112;
const kKeysRecord = 34735;
/** Ref: OGC 19-008r4, "OGC GeoTIFF Standard", 2019, section 7: ids of keys. */
const kGeographicKey = 2048;
const kProjectedKey = 3072;
/** Codes outside this range are private, or mean "user-defined". */
const kCodes = { first: 1024, last: 32766 };

/** A variable length record of a LAS file. */
export type Vlr = { readonly user: string; readonly record: number; readonly data: Buffer };

/**
 * The CRS of a LAS file, as voxelserver/data/lidar reads it: its WKT, else its GeoTIFF keys.
 * @return `EPSG:n` without its vertical part; undefined where the file has none, or one without a
 * code
 */
export function readCrs(vlrs: Iterable<Vlr>): string | undefined {
  let wkt = '';
  let keys: Buffer | undefined;
  for (const { user, record, data } of vlrs) {
    if (user !== kUser) continue;
    if (record === kWktRecord) wkt ||= usableWkt(data);
    if (record === kKeysRecord) keys ??= data;
  }
  const code = wkt === '' ? keys && readKeyCode(keys) : parseWktCode(wkt);
  return code === undefined ? undefined : `EPSG:${code}`;
}

/** @return the text of a record; '' for one that is no WKT: then the next record counts */
function usableWkt(data: Buffer): string {
  const text = data.toString('latin1').replace(/\0[^]*$/, '');
  return parseWktCode(text) === undefined && !/^\s*\w+\s*[[(]/.test(text) ? '' : text;
}

function readKeyCode(keys: Buffer): number | undefined {
  const found = new Map<number, number>();
  // Four numbers a key, after four of the directory: id, where its value lies, count, value.
  for (let at = 8; at + 8 <= keys.length; at += 8) {
    const isHere = keys.readUInt16LE(at + 2) === 0;
    if (isHere) found.set(keys.readUInt16LE(at), keys.readUInt16LE(at + 6));
  }
  const code = found.get(kProjectedKey) ?? found.get(kGeographicKey);
  return code !== undefined && code >= kCodes.first && code <= kCodes.last ? code : undefined;
}

/**
 * The code of the horizontal system of WKT 1 or 2: that of the projected system, or of the
 * geographic one where there is no projected one.
 */
export function parseWktCode(wkt: string): number | undefined {
  const start =
    /\b(?:PROJCS|PROJCRS|PROJECTEDCRS)\s*[[(]/i.exec(wkt) ??
    /\b(?:GEOGCS|GEOGCRS|GEODCRS|GEOGRAPHICCRS|GEODETICCRS)\s*[[(]/i.exec(wkt);
  if (start === null) return undefined;
  // Text in quotes first, since it may hold brackets.
  const token = /"(?:[^"]|"")*"|(?:AUTHORITY|ID)\s*[[(]\s*"EPSG"\s*,\s*"?(\d{4,5})"?|[[(]|[\])]/gi;
  token.lastIndex = start.index + start[0].length;
  let depth = 1;
  for (let match = token.exec(wkt); match !== null && depth > 0; match = token.exec(wkt)) {
    const [text, code] = match;
    if (code !== undefined && depth === 1) return Number(code);
    if (code !== undefined || /^[[(]/.test(text)) ++depth;
    else if (/^[\])]/.test(text)) --depth;
  }
  return undefined;
}

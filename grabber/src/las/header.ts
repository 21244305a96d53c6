import { GrabberError } from '../util/errors.js';

/**
 * The public header block of a LAS 1.0 - 1.4 file.
 * Ref: ASPRS, "LAS Specification 1.4 - R15", 2019, section 2.4.
 */
export type LasHeader = {
  readonly version: string;
  readonly headerSize_bytes: number;
  readonly pointOffset_bytes: number;
  readonly vlrCount: number;
  /** 0 to 10, without the bit that marks compression. */
  readonly pointFormat: number;
  readonly compressed: boolean;
  readonly recordLength_bytes: number;
  readonly pointCount: number;
  /** In the file's CRS and units, as [x, y, z]. */
  readonly min: readonly [number, number, number];
  readonly max: readonly [number, number, number];
};

/** Enough bytes for the header of every version. */
export const kHeaderReadBytes = 375;
const kShortestHeaderBytes = 227;
const kSignature = 'LASF';

/** Header length by minor version. */
const kHeaderBytes = [227, 227, 227, 235, 375] as const;
/** Shortest point record by point format. */
const kRecordBytes = [20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67] as const;
/** LASzip marks its files with the highest bit of the point format. */
const kCompressedBit = 0x80;

export function looksLikeLas(start: Uint8Array): boolean {
  return Buffer.from(start.subarray(0, 4)).toString('latin1') === kSignature;
}

/**
 * @param start     the first bytes of the file, kHeaderReadBytes where the file has them
 * @param fileBytes length of the whole file
 * @param shown     what to call the file in messages
 * @throws GrabberError NOT_LAS, LAS_HEADER or LAS_TRUNCATED
 */
export function readLasHeader(start: Uint8Array, fileBytes: number, shown: string): LasHeader {
  const view = Buffer.from(start.buffer, start.byteOffset, start.byteLength);
  if (!looksLikeLas(view)) {
    throw new GrabberError(
      'NOT_LAS',
      `read LAS header of ${shown}: it starts with ${printable(view)}; allowed: "${kSignature}"`,
    );
  }
  if (view.length < kShortestHeaderBytes) throw truncated(shown, 'the header', kShortestHeaderBytes, fileBytes);
  const fail = (field: string, value: unknown, allowed: string): never => {
    throw new GrabberError(
      'LAS_HEADER',
      `read LAS header of ${shown}: ${field} is ${String(value)}; allowed: ${allowed}`,
    );
  };

  const major = view.readUInt8(24);
  const minor = view.readUInt8(25);
  const version = `${major}.${minor}`;
  const versionHeaderBytes = major === 1 ? kHeaderBytes[minor] : undefined;
  if (versionHeaderBytes === undefined) return fail('version', version, '1.0 to 1.4');

  const headerSize_bytes = view.readUInt16LE(94);
  if (headerSize_bytes < versionHeaderBytes)
    fail('header size', headerSize_bytes, `at least ${versionHeaderBytes} bytes`);
  if (view.length < versionHeaderBytes) throw truncated(shown, 'the header', versionHeaderBytes, fileBytes);

  const pointOffset_bytes = view.readUInt32LE(96);
  if (pointOffset_bytes < headerSize_bytes)
    fail('offset to points', pointOffset_bytes, `at least the header size, ${headerSize_bytes} bytes`);

  const formatByte = view.readUInt8(104);
  const compressed = (formatByte & kCompressedBit) !== 0;
  const pointFormat = formatByte & ~kCompressedBit;
  const shortestRecord = kRecordBytes[pointFormat];
  if (shortestRecord === undefined) return fail('point format', pointFormat, '0 to 10');
  if (pointFormat >= 6 && minor < 4)
    fail('point format', `${pointFormat} in version ${version}`, '0 to 5 before version 1.4');
  const recordLength_bytes = view.readUInt16LE(105);
  if (recordLength_bytes < shortestRecord) {
    fail('point record length', recordLength_bytes, `at least ${shortestRecord} bytes in point format ${pointFormat}`);
  }

  const pointCount = readPointCount(view, minor);
  if (!Number.isSafeInteger(pointCount) || pointCount < 1) fail('point count', pointCount, '1 to 2^53 - 1');
  if (pointOffset_bytes >= fileBytes)
    throw truncated(shown, 'the start of the points', pointOffset_bytes + 1, fileBytes);

  const { min, max } = readBounds(view, fail);
  if (!compressed) {
    const needed = pointOffset_bytes + pointCount * recordLength_bytes;
    if (needed > fileBytes)
      throw truncated(shown, `${pointCount} point records of ${recordLength_bytes} bytes`, needed, fileBytes);
  }
  return {
    version,
    headerSize_bytes,
    pointOffset_bytes,
    vlrCount: view.readUInt32LE(100),
    pointFormat,
    compressed,
    recordLength_bytes,
    pointCount,
    min,
    max,
  };
}

/** LAS 1.4 keeps the old 32-bit count only where it fits, and writes 0 otherwise. */
function readPointCount(view: Buffer, minor: number): number {
  const legacy = view.readUInt32LE(107);
  if (minor < 4) return legacy;
  const count = Number(view.readBigUInt64LE(247));
  return count === 0 ? legacy : count;
}

function readBounds(
  view: Buffer,
  fail: (field: string, value: unknown, allowed: string) => never,
): { min: [number, number, number]; max: [number, number, number] } {
  const min: [number, number, number] = [0, 0, 0];
  const max: [number, number, number] = [0, 0, 0];
  for (const axis of [0, 1, 2] as const) {
    const name = 'xyz'.charAt(axis);
    const scale = view.readDoubleLE(131 + 8 * axis);
    if (!Number.isFinite(scale) || scale <= 0) fail(`${name} scale`, scale, 'a finite number above 0');
    // The header stores the pairs as max x, min x, max y, min y, max z, min z.
    max[axis] = view.readDoubleLE(179 + 16 * axis);
    min[axis] = view.readDoubleLE(187 + 16 * axis);
    if (!Number.isFinite(min[axis]) || !Number.isFinite(max[axis]) || min[axis] > max[axis]) {
      fail(`${name} range`, `${min[axis]} to ${max[axis]}`, 'finite numbers, min <= max');
    }
  }
  return { min, max };
}

export function truncated(shown: string, part: string, needed: number, fileBytes: number): GrabberError {
  return new GrabberError(
    'LAS_TRUNCATED',
    `read ${shown}: the file has ${fileBytes} bytes, but ${part} needs ${needed}; allowed: the whole file`,
    { retryable: true },
  );
}

function printable(start: Buffer): string {
  return start.length === 0 ? 'nothing (0 bytes)' : JSON.stringify(start.subarray(0, 12).toString('latin1'));
}

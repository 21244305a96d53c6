import type { PointFacts } from '../model/store.js';
import { GrabberError } from '../util/errors.js';

/**
 * The public header block of a LAS 1.0 - 1.5 file.
 * Ref: ASPRS, "LAS Specification 1.4 - R15", 2019, section 2.4; "LAS Specification 1.5", 2025.
 */
export type LasHeader = {
  readonly version: string;
  readonly headerSize_bytes: number;
  readonly pointOffset_bytes: number;
  readonly vlrCount: number;
  /** Of the records behind the points, from LAS 1.4 on; as the file says, which may be wrong. */
  readonly extended: { readonly at: number; readonly count: number };
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
export const kHeaderReadBytes = 393;
const kMinHeaderBytes = 227;
const kSignature = 'LASF';

/** Header length by minor version. */
const kHeaderBytes = [227, 227, 227, 235, 375, 393] as const;
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
  if (view.length < kMinHeaderBytes) {
    throw truncated(shown, 'the header', kMinHeaderBytes, fileBytes);
  }
  const fail: Fail = (field, value, allowed) => {
    throw new GrabberError(
      'LAS_HEADER',
      `read LAS header of ${shown}: ${field} is ${String(value)}; allowed: ${allowed}`,
    );
  };
  const { minor, neededBytes } = readVersion(view, fail);
  const sizes = readSizes(view, neededBytes, fail);
  if (view.length < neededBytes) throw truncated(shown, 'the header', neededBytes, fileBytes);
  checkPointOffset(sizes, fail);
  const points = readPointFormat(view, minor, fail);
  const pointCount = readPointCount(view, minor);
  if (!Number.isSafeInteger(pointCount) || pointCount < 1) {
    fail('point count', pointCount, '1 to 2^53 - 1');
  }
  if (sizes.pointOffset_bytes >= fileBytes) {
    throw truncated(shown, 'the start of the points', sizes.pointOffset_bytes + 1, fileBytes);
  }
  const { min, max } = readBounds(view, fail);
  const { recordLength_bytes } = points;
  const needed = sizes.pointOffset_bytes + pointCount * recordLength_bytes;
  if (!points.compressed && needed > fileBytes) {
    const records = `${pointCount} point records of ${recordLength_bytes} bytes`;
    throw truncated(shown, records, needed, fileBytes);
  }
  return {
    version: `1.${minor}`,
    ...sizes,
    vlrCount: view.readUInt32LE(100),
    extended: readExtended(view, minor),
    ...points,
    pointCount,
    min,
    max,
  };
}

type Fail = (field: string, value: unknown, allowed: string) => never;

/** @return the minor version, and the shortest header that it has */
function readVersion(view: Buffer, fail: Fail): { minor: number; neededBytes: number } {
  const major = view.readUInt8(24);
  const minor = view.readUInt8(25);
  const neededBytes = major === 1 ? kHeaderBytes[minor] : undefined;
  return neededBytes === undefined
    ? fail('version', `${major}.${minor}`, '1.0 to 1.5')
    : { minor, neededBytes };
}

type Sizes = Pick<LasHeader, 'headerSize_bytes' | 'pointOffset_bytes'>;

function readSizes(view: Buffer, neededBytes: number, fail: Fail): Sizes {
  const headerSize_bytes = view.readUInt16LE(94);
  if (headerSize_bytes < neededBytes) {
    fail('header size', headerSize_bytes, `at least ${neededBytes} bytes`);
  }
  return { headerSize_bytes, pointOffset_bytes: view.readUInt32LE(96) };
}

function checkPointOffset({ headerSize_bytes, pointOffset_bytes }: Sizes, fail: Fail): void {
  if (pointOffset_bytes >= headerSize_bytes) return;
  const allowed = `at least the header size, ${headerSize_bytes} bytes`;
  fail('offset to points', pointOffset_bytes, allowed);
}

function readPointFormat(
  view: Buffer,
  minor: number,
  fail: Fail,
): Pick<LasHeader, 'pointFormat' | 'compressed' | 'recordLength_bytes'> {
  const formatByte = view.readUInt8(104);
  const compressed = (formatByte & kCompressedBit) !== 0;
  const pointFormat = formatByte & ~kCompressedBit;
  const minRecord = kRecordBytes[pointFormat];
  if (minRecord === undefined) return fail('point format', pointFormat, '0 to 10');
  if (pointFormat < 6 && minor > 4) {
    fail('point format', `${pointFormat} in version 1.${minor}`, '6 to 10 from version 1.5 on');
  }
  if (pointFormat >= 6 && minor < 4) {
    const found = `${pointFormat} in version 1.${minor}`;
    fail('point format', found, '0 to 5 before version 1.4');
  }
  const recordLength_bytes = view.readUInt16LE(105);
  if (recordLength_bytes < minRecord) {
    const allowed = `at least ${minRecord} bytes in point format ${pointFormat}`;
    fail('point record length', recordLength_bytes, allowed);
  }
  return { pointFormat, compressed, recordLength_bytes };
}

function readExtended(view: Buffer, minor: number): LasHeader['extended'] {
  if (minor < 4) return { at: 0, count: 0 };
  return { at: Number(view.readBigUInt64LE(235)), count: view.readUInt32LE(243) };
}

/** LAS 1.4 keeps the old 32-bit count only where it fits, and writes 0 otherwise; 1.5 has none. */
function readPointCount(view: Buffer, minor: number): number {
  const legacy = minor > 4 ? 0 : view.readUInt32LE(107);
  if (minor < 4) return legacy;
  const count = Number(view.readBigUInt64LE(247));
  return count === 0 ? legacy : count;
}

function readBounds(
  view: Buffer,
  fail: Fail,
): { min: [number, number, number]; max: [number, number, number] } {
  const min: [number, number, number] = [0, 0, 0];
  const max: [number, number, number] = [0, 0, 0];
  for (const axis of [0, 1, 2] as const) {
    const name = 'xyz'.charAt(axis);
    const scale = view.readDoubleLE(131 + 8 * axis);
    if (!Number.isFinite(scale) || scale <= 0) {
      fail(`${name} scale`, scale, 'a finite number above 0');
    }
    // The header stores the pairs as max x, min x, max y, min y, max z, min z.
    max[axis] = view.readDoubleLE(179 + 16 * axis);
    min[axis] = view.readDoubleLE(187 + 16 * axis);
    if (!Number.isFinite(min[axis]) || !Number.isFinite(max[axis]) || min[axis] > max[axis]) {
      fail(`${name} range`, `${min[axis]} to ${max[axis]}`, 'finite numbers, min <= max');
    }
  }
  return { min, max };
}

export function truncated(
  shown: string,
  part: string,
  needed: number,
  fileBytes: number,
): GrabberError {
  return new GrabberError(
    'LAS_TRUNCATED',
    `read ${shown}: the file has ${fileBytes} bytes, but ${part} needs ${needed}; allowed: ` +
      'the whole file',
    { retryable: true },
  );
}

function printable(start: Buffer): string {
  return start.length === 0
    ? 'nothing (0 bytes)'
    : JSON.stringify(start.subarray(0, 12).toString('latin1'));
}

/** What a store records of a header. */
export function toPointFacts(header: LasHeader): PointFacts {
  const { pointCount, version, pointFormat, min, max } = header;
  return { pointCount, lasVersion: version, pointFormat, min, max };
}

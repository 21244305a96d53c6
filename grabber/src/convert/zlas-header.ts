import { open } from 'node:fs/promises';

/** What can be read of a zLAS file without its decoder: the format is not published. */
export type ZlasFacts = {
  /** Undefined where the file has no readable LAS header. */
  readonly pointCount: number | undefined;
};

const kHeaderBytes = 375;
const kMinHeaderBytes = 227;

/**
 * Some zLAS files begin with a plain LAS header, which then states the number of points.
 * Nothing is concluded from a file that begins with anything else, or whose header makes no sense
 * as one of LAS. Ref: ASPRS, "LAS Specification 1.4 - R15", 2019, section 2.4.
 */
export async function readZlasFacts(path: string): Promise<ZlasFacts> {
  const file = await open(path, 'r');
  try {
    const { buffer, bytesRead } = await file.read(Buffer.alloc(kHeaderBytes), 0, kHeaderBytes, 0);
    return { pointCount: parsePointCount(buffer.subarray(0, bytesRead)) };
  } finally {
    await file.close();
  }
}

export function parsePointCount(start: Buffer): number | undefined {
  if (start.length < kMinHeaderBytes || start.toString('latin1', 0, 4) !== 'LASF') {
    return undefined;
  }
  const minor = start.readUInt8(25);
  if (start.readUInt8(24) !== 1 || minor > 4 || start.readUInt16LE(94) < kMinHeaderBytes) {
    return undefined;
  }
  const legacy = start.readUInt32LE(107);
  const wide = minor === 4 && start.length >= kHeaderBytes ? Number(start.readBigUInt64LE(247)) : 0;
  const count = wide === 0 ? legacy : wide;
  return Number.isSafeInteger(count) && count > 0 ? count : undefined;
}

/** Builds LAS files byte by byte, with every field open to being wrong. */
export type LasFixture = {
  minor?: number;
  major?: number;
  format?: number;
  points?: number;
  /** Point count to write, when it should differ from the points that follow. */
  claimedPoints?: number;
  recordLength?: number;
  headerSize?: number;
  pointOffset?: number;
  signature?: string;
  scale?: number;
  min?: [number, number, number];
  max?: [number, number, number];
  /** Records of a CRS. */
  vlrs?: readonly Buffer[];
};

const kHeaderBytes = [227, 227, 227, 235, 375];
const kRecordBytes = [20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67];

export function makeLas(fixture: LasFixture = {}): Buffer {
  const points = fixture.points ?? 10;
  const recordLength = fixture.recordLength ?? kRecordBytes[fixture.format ?? 1] ?? 30;
  const records = Buffer.alloc(points * recordLength, 7);
  const vlrs = Buffer.concat(fixture.vlrs ?? []);
  const header = makeHeader(fixture, 0, vlrs.length);
  header.writeUInt32LE(fixture.vlrs?.length ?? 0, 100);
  return Buffer.concat([header, vlrs, records]);
}

function makeVlr(user: string, record: number, data: Buffer): Buffer {
  const head = Buffer.alloc(54);
  head.write(user, 2, 'latin1');
  head.writeUInt16LE(record, 18);
  head.writeUInt16LE(data.length, 20);
  return Buffer.concat([head, data]);
}

/** The CRS of a file as GeoTIFF keys: pairs of id and value. */
export function makeKeys(...keys: readonly (readonly [id: number, value: number])[]): Buffer {
  const numbers = [1, 1, 0, keys.length, ...keys.flatMap(([id, value]) => [id, 0, 1, value])];
  const data = Buffer.alloc(2 * numbers.length);
  numbers.forEach((value, index) => data.writeUInt16LE(value, 2 * index));
  return makeVlr('LASF_Projection', 34735, data);
}

/** The CRS of a file as WKT. */
export function makeWkt(text: string): Buffer {
  return makeVlr('LASF_Projection', 2112, Buffer.from(`${text}\0`, 'latin1'));
}

/**
 * Compressed in form only: header, LASzip record, chunk table pointer, `dataBytes` of filling,
 * chunk table.
 */
export function makeLaz(
  fixture: LasFixture & {
    dataBytes?: number;
    compressor?: number;
    chunks?: number;
    streamed?: boolean;
  } = {},
): Buffer {
  const about = Buffer.alloc(34);
  about.writeUInt16LE(fixture.compressor ?? 2, 0);
  const records = [...(fixture.vlrs ?? []), makeVlr('laszip encoded', 22204, about)];
  const vlrs = Buffer.concat(records);
  const header = makeHeader(fixture, 0x80, vlrs.length);
  header.writeUInt32LE(records.length, 100);
  const data = Buffer.alloc(fixture.dataBytes ?? 1000, 9);
  const tableAt = BigInt(header.length + vlrs.length + 8 + data.length);
  const pointer = Buffer.alloc(8);
  pointer.writeBigInt64LE(fixture.streamed === true ? -1n : tableAt);
  const table = Buffer.alloc(8);
  table.writeUInt32LE(fixture.chunks ?? 1, 4);
  const tail = Buffer.alloc(fixture.streamed === true ? 8 : 0);
  if (fixture.streamed === true) tail.writeBigInt64LE(tableAt);
  return Buffer.concat([header, vlrs, pointer, data, table, tail]);
}

function makeHeader(fixture: LasFixture, formatBits: number, vlrBytes = 0): Buffer {
  const minor = fixture.minor ?? 2;
  const format = fixture.format ?? 1;
  const size = kHeaderBytes[minor] ?? 375;
  const count = fixture.claimedPoints ?? fixture.points ?? 10;
  const header = Buffer.alloc(size);
  header.write(fixture.signature ?? 'LASF', 0, 'latin1');
  header.writeUInt8(fixture.major ?? 1, 24);
  header.writeUInt8(minor, 25);
  header.writeUInt16LE(fixture.headerSize ?? size, 94);
  header.writeUInt32LE(fixture.pointOffset ?? size + vlrBytes, 96);
  header.writeUInt8(format | formatBits, 104);
  header.writeUInt16LE(fixture.recordLength ?? kRecordBytes[format] ?? 30, 105);
  header.writeUInt32LE(minor < 4 ? count : 0, 107);
  if (minor === 4) header.writeBigUInt64LE(BigInt(count), 247);
  const min = fixture.min ?? [462_000, 101_000, 280];
  const max = fixture.max ?? [463_000, 102_000, 540.5];
  for (const axis of [0, 1, 2] as const) {
    header.writeDoubleLE(fixture.scale ?? 0.01, 131 + 8 * axis);
    header.writeDoubleLE(max[axis], 179 + 16 * axis);
    header.writeDoubleLE(min[axis], 187 + 16 * axis);
  }
  return header;
}

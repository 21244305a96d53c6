import { crc32, deflateRawSync } from 'node:zlib';

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
  /** The same, behind the points. */
  extended?: readonly Buffer[];
};

const kHeaderBytes = [227, 227, 227, 235, 375, 393];
const kRecordBytes = [20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67];

export function makeLas(fixture: LasFixture = {}): Buffer {
  const points = fixture.points ?? 10;
  const recordLength = fixture.recordLength ?? kRecordBytes[fixture.format ?? 1] ?? 30;
  const records = Buffer.alloc(points * recordLength, 7);
  const vlrs = Buffer.concat(fixture.vlrs ?? []);
  const header = makeHeader(fixture, 0, vlrs.length);
  header.writeUInt32LE(fixture.vlrs?.length ?? 0, 100);
  const extended = (fixture.extended ?? []).map(extendRecord);
  if (extended.length > 0) {
    header.writeBigUInt64LE(BigInt(header.length + vlrs.length + records.length), 235);
    header.writeUInt32LE(extended.length, 243);
  }
  return Buffer.concat([header, vlrs, records, ...extended]);
}

/** A record as it stands behind the points: its length has eight bytes. */
function extendRecord(record: Buffer): Buffer {
  const length = Buffer.alloc(8);
  length.writeUInt16LE(record.readUInt16LE(20));
  return Buffer.concat([record.subarray(0, 20), length, record.subarray(22)]);
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
  const size = kHeaderBytes[minor] ?? 393;
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
  if (minor >= 4) header.writeBigUInt64LE(BigInt(count), 247);
  const min = fixture.min ?? [462_000, 101_000, 280];
  const max = fixture.max ?? [463_000, 102_000, 540.5];
  for (const axis of [0, 1, 2] as const) {
    header.writeDoubleLE(fixture.scale ?? 0.01, 131 + 8 * axis);
    header.writeDoubleLE(max[axis], 179 + 16 * axis);
    header.writeDoubleLE(min[axis], 187 + 16 * axis);
  }
  return header;
}

export type ZipMember = {
  name: string;
  data: Buffer;
  stored?: boolean;
  /** Field values that differ from the truth. */
  crc?: number;
  claimedBytes?: number;
  flags?: number;
  method?: number;
};

/** Builds an archive byte by byte, with every field open to being wrong. */
export function makeZip(members: readonly ZipMember[]): Buffer {
  const locals: Buffer[] = [];
  const directory: Buffer[] = [];
  let offset = 0;
  for (const member of members) {
    const packed = member.stored === true ? member.data : deflateRawSync(member.data);
    const name = Buffer.from(member.name);
    const fields = Buffer.alloc(26);
    fields.writeUInt16LE(20, 0);
    fields.writeUInt16LE(member.flags ?? 0, 2);
    fields.writeUInt16LE(member.method ?? (member.stored === true ? 0 : 8), 4);
    fields.writeUInt32LE(member.crc ?? crc32(member.data), 10);
    fields.writeUInt32LE(packed.length, 14);
    fields.writeUInt32LE(member.claimedBytes ?? member.data.length, 18);
    fields.writeUInt16LE(name.length, 22);
    const local = Buffer.concat([Buffer.from('PK\x03\x04'), fields, name, packed]);
    const rest = Buffer.alloc(14);
    rest.writeUInt32LE(offset, 10);
    directory.push(
      Buffer.concat([Buffer.from('PK\x01\x02'), Buffer.from([20, 0]), fields, rest, name]),
    );
    locals.push(local);
    offset += local.length;
  }
  const central = Buffer.concat(directory);
  const end = Buffer.alloc(22);
  end.write('PK\x05\x06', 0, 'latin1');
  end.writeUInt16LE(members.length, 8);
  end.writeUInt16LE(members.length, 10);
  end.writeUInt32LE(central.length, 12);
  end.writeUInt32LE(offset, 16);
  return Buffer.concat([...locals, central, end]);
}

import assert from 'node:assert/strict';
import { writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { readLasHeader } from '../../../grabber/src/las/header.js';
import { verifyLasFile } from '../../../grabber/src/las/verify.js';
import { makeLas, makeLaz, type LasFixture } from '../support/las-fixture.js';
import { kNever, temporaryFolder } from '../support/store-fixture.js';

test('a header gives version, format, point count and bounds', async (t) => {
  const cases: { name: string; fixture: LasFixture; version: string }[] = [
    { name: 'LAS 1.0', fixture: { minor: 0, format: 0 }, version: '1.0' },
    { name: 'LAS 1.2', fixture: { minor: 2, format: 3 }, version: '1.2' },
    { name: 'LAS 1.3', fixture: { minor: 3, format: 5 }, version: '1.3' },
    { name: 'LAS 1.4 with the long point count', fixture: { minor: 4, format: 8 }, version: '1.4' },
    {
      name: 'extra bytes in each record',
      fixture: { minor: 4, format: 6, recordLength: 45 },
      version: '1.4',
    },
  ];
  for (const { name, fixture, version } of cases) {
    await t.test(name, () => {
      const file = makeLas({ ...fixture, points: 12 });
      const header = readLasHeader(file.subarray(0, 375), file.length, 'a.las');
      assert.equal(header.version, version);
      assert.equal(header.pointFormat, fixture.format);
      assert.equal(header.pointCount, 12);
      assert.equal(header.compressed, false);
      assert.deepEqual(header.min, [462_000, 101_000, 280]);
      assert.deepEqual(header.max, [463_000, 102_000, 540.5]);
    });
  }
});

test('a header that cannot be right is refused with field, value and allowed range', async (t) => {
  const cases: { name: string; fixture: LasFixture; code: string; message: RegExp }[] = [
    {
      name: 'other magic',
      fixture: { signature: 'PK\u0003\u0004' },
      code: 'NOT_LAS',
      message: /starts with "PK.*allowed: "LASF"/,
    },
    {
      name: 'version 2.0',
      fixture: { major: 2 },
      code: 'LAS_HEADER',
      message: /version is 2\.2; allowed: 1\.0 to 1\.4/,
    },
    { name: 'version 1.9', fixture: { minor: 9 }, code: 'LAS_HEADER', message: /version is 1\.9/ },
    {
      name: 'short header size',
      fixture: { headerSize: 100 },
      code: 'LAS_HEADER',
      message: /header size is 100; allowed: at least 227/,
    },
    {
      name: 'points inside the header',
      fixture: { pointOffset: 200 },
      code: 'LAS_HEADER',
      message: /offset to points is 200/,
    },
    {
      name: 'points after the end',
      fixture: { pointOffset: 9_999_999 },
      code: 'LAS_TRUNCATED',
      message: /start of the points needs 10000000/,
    },
    {
      name: 'point format 11',
      fixture: { minor: 4, format: 11 },
      code: 'LAS_HEADER',
      message: /point format is 11; allowed: 0 to 10/,
    },
    {
      name: 'new format in an old version',
      fixture: { minor: 2, format: 6 },
      code: 'LAS_HEADER',
      message: /6 in version 1\.2/,
    },
    {
      name: 'short records',
      fixture: { format: 1, recordLength: 20 },
      code: 'LAS_HEADER',
      message: /record length is 20; allowed: at least 28/,
    },
    {
      name: 'no points',
      fixture: { points: 0 },
      code: 'LAS_HEADER',
      message: /point count is 0; allowed: 1 to/,
    },
    {
      name: 'a count of no points',
      fixture: { claimedPoints: 0 },
      code: 'LAS_HEADER',
      message: /point count is 0/,
    },
    {
      name: 'more points than bytes',
      fixture: { claimedPoints: 11 },
      code: 'LAS_TRUNCATED',
      message: /11 point records of 28 bytes needs 535/,
    },
    { name: 'no scale', fixture: { scale: 0 }, code: 'LAS_HEADER', message: /x scale is 0/ },
    {
      name: 'bounds upside down',
      fixture: { min: [0, 0, 9], max: [1, 1, 3] },
      code: 'LAS_HEADER',
      message: /z range is 9 to 3/,
    },
    {
      name: 'bounds that are no numbers',
      fixture: { min: [NaN, 0, 0] },
      code: 'LAS_HEADER',
      message: /x range is NaN/,
    },
  ];
  for (const { name, fixture, code, message } of cases) {
    await t.test(name, () => {
      const file = makeLas(fixture);
      assert.throws(() => readLasHeader(file.subarray(0, 375), file.length, 'a.las'), {
        code,
        message,
      });
    });
  }
});

test('a file shorter than its header is truncated, whatever the length', () => {
  const file = makeLas({ minor: 4, format: 6 });
  for (const length of [4, 100, 226, 227, 374]) {
    assert.throws(
      () => readLasHeader(file.subarray(0, length), length, 'a.las'),
      { code: 'LAS_TRUNCATED', retryable: true },
      `${length} bytes`,
    );
  }
  assert.throws(() => readLasHeader(new Uint8Array(0), 0, 'a.las'), {
    code: 'NOT_LAS',
    message: /0 bytes/,
  });
});

test('a LAZ file is whole when its chunk table is there', async (t) => {
  const whole = makeLaz({ minor: 4, format: 6 });
  const noRecord = Buffer.from(whole);
  noRecord.writeUInt32LE(0, 100);
  const cases: { name: string; file: Buffer; code?: string; message?: RegExp }[] = [
    { name: 'whole', file: whole },
    {
      name: 'chunk table position at the end, as streaming writers leave it',
      file: makeLaz({ streamed: true }),
    },
    {
      name: 'one stream without chunks',
      file: makeLaz({ compressor: 1, chunks: 0 }).subarray(0, 600),
    },
    {
      name: 'cut inside the points',
      file: whole.subarray(0, 900),
      code: 'LAS_TRUNCATED',
      message: /chunk table needs/,
    },
    {
      name: 'cut by one byte',
      file: whole.subarray(0, whole.length - 1),
      code: 'LAS_TRUNCATED',
      message: /chunk table needs/,
    },
    {
      name: 'cut before the chunk table pointer',
      file: whole.subarray(0, 375 + 88 + 3),
      code: 'LAS_TRUNCATED',
      message: /pointer/,
    },
    {
      name: 'more chunks than points',
      file: makeLaz({ chunks: 11 }),
      code: 'LAS_HEADER',
      message: /chunk count is 11; allowed: 1 to the point count, 10/,
    },
    {
      name: 'no LASzip record',
      file: noRecord,
      code: 'LAS_HEADER',
      message: /without its LASzip record/,
    },
  ];
  const folder = await temporaryFolder(t);
  for (const { name, file, code, message } of cases) {
    await t.test(name, async () => {
      const path = join(folder, 'a.laz');
      await writeFile(path, file);
      const verified = verifyLasFile(path, 'a.laz', kNever);
      if (code === undefined) assert.equal((await verified).compressed, true);
      else await assert.rejects(verified, { code, message });
    });
  }
});

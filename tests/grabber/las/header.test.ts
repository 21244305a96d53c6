import assert from 'node:assert/strict';
import { writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { readLasHeader } from '../../../grabber/src/las/header.js';
import { verifyLasFile } from '../../../grabber/src/las/verify.js';
import { makeLas, makeLaz, type LasFixture } from '../support/las-fixture.js';
import { kNever, temporaryFolder } from '../support/store-fixture.js';

test('a header gives version, format, point count and bounds', async (t) => {
  const cases: [name: string, fixture: LasFixture, version: string][] = [
    ['LAS 1.0', { minor: 0, format: 0 }, '1.0'],
    ['LAS 1.2', { minor: 2, format: 3 }, '1.2'],
    ['LAS 1.3', { minor: 3, format: 5 }, '1.3'],
    ['LAS 1.4 with the long point count', { minor: 4, format: 8 }, '1.4'],
    ['extra bytes in each record', { minor: 4, format: 6, recordLength: 45 }, '1.4'],
  ];
  for (const [name, fixture, version] of cases) {
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
  const cases: [name: string, fixture: LasFixture, code: string, message: RegExp][] = [
    ['other magic', { signature: 'PK\u0003\u0004' }, 'NOT_LAS', /starts with "PK.*allowed: "LASF"/],
    ['version 2.0', { major: 2 }, 'LAS_HEADER', /version is 2\.2; allowed: 1\.0 to 1\.4/],
    ['version 1.9', { minor: 9 }, 'LAS_HEADER', /version is 1\.9/],
    ['short header size', { headerSize: 100 }, 'LAS_HEADER', /is 100; allowed: at least 227/],
    ['points inside the header', { pointOffset: 200 }, 'LAS_HEADER', /offset to points is 200/],
    ['points after the end', { pointOffset: 9_999_999 }, 'LAS_TRUNCATED', /needs 10000000/],
    ['point format 11', { minor: 4, format: 11 }, 'LAS_HEADER', /is 11; allowed: 0 to 10/],
    ['new format, old version', { minor: 2, format: 6 }, 'LAS_HEADER', /6 in version 1\.2/],
    ['short records', { format: 1, recordLength: 20 }, 'LAS_HEADER', /is 20; allowed: at least 28/],
    ['no points', { points: 0 }, 'LAS_HEADER', /point count is 0; allowed: 1 to/],
    ['more points than bytes', { claimedPoints: 11 }, 'LAS_TRUNCATED', /28 bytes needs 535/],
    ['no scale', { scale: 0 }, 'LAS_HEADER', /x scale is 0/],
    ['upside down', { min: [0, 0, 9], max: [1, 1, 3] }, 'LAS_HEADER', /z range is 9 to 3/],
    ['bounds that are no numbers', { min: [NaN, 0, 0] }, 'LAS_HEADER', /x range is NaN/],
  ];
  for (const [name, fixture, code, message] of cases) {
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
  const cases: [name: string, file: Buffer, code?: string, message?: RegExp][] = [
    ['whole', whole],
    ['its table last, as streaming writers leave it', makeLaz({ streamed: true })],
    ['one stream without chunks', makeLaz({ compressor: 1, chunks: 0 }).subarray(0, 600)],
    ['cut inside the points', whole.subarray(0, 900), 'LAS_TRUNCATED', /chunk table needs/],
    ['cut by one byte', whole.subarray(0, -1), 'LAS_TRUNCATED', /chunk table needs/],
    ['cut before the pointer', whole.subarray(0, 375 + 88 + 3), 'LAS_TRUNCATED', /pointer/],
    ['more chunks than points', makeLaz({ chunks: 11 }), 'LAS_HEADER', /is 11; allowed: 1 to the/],
    ['no LASzip record', noRecord, 'LAS_HEADER', /without its LASzip record/],
  ];
  const folder = await temporaryFolder(t);
  for (const [name, file, code, message] of cases) {
    await t.test(name, async () => {
      const path = join(folder, 'a.laz');
      await writeFile(path, file);
      const verified = verifyLasFile(path, 'a.laz', kNever);
      if (code === undefined) assert.equal((await verified).compressed, true);
      else await assert.rejects(verified, { code, message: message ?? /./ });
    });
  }
});

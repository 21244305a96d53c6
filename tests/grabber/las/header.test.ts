import assert from 'node:assert/strict';
import { writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { readLasHeader } from '../../../grabber/src/las/header.js';
import { verifyLasFile, parseWktCode } from '../../../grabber/src/las/verify.js';
import { makeLas, makeLaz, type LasFixture, makeKeys, makeWkt } from '../support/las-fixture.js';
import { kNever, temporaryFolder } from '../support/store-fixture.js';

test('a header gives version, format, point count and bounds', async (t) => {
  const cases: [name: string, fixture: LasFixture, version: string][] = [
    ['LAS 1.0', { minor: 0, format: 0 }, '1.0'],
    ['LAS 1.2', { minor: 2, format: 3 }, '1.2'],
    ['LAS 1.3', { minor: 3, format: 5 }, '1.3'],
    ['LAS 1.4 with the long point count', { minor: 4, format: 8 }, '1.4'],
    ['LAS 1.5', { minor: 5, format: 6 }, '1.5'],
    ['extra bytes in each record', { minor: 4, format: 6, recordLength: 45 }, '1.4'],
  ];
  for (const [name, fixture, version] of cases) {
    await t.test(name, () => {
      const file = makeLas({ ...fixture, points: 12 });
      const header = readLasHeader(file.subarray(0, 393), file.length, 'a.las');
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
    ['version 2.0', { major: 2 }, 'LAS_HEADER', /version is 2\.2; allowed: 1\.0 to 1\.5/],
    ['version 1.9', { minor: 9 }, 'LAS_HEADER', /version is 1\.9/],
    ['short header size', { headerSize: 100 }, 'LAS_HEADER', /is 100; allowed: at least 227/],
    ['points inside the header', { pointOffset: 200 }, 'LAS_HEADER', /offset to points is 200/],
    ['points after the end', { pointOffset: 9_999_999 }, 'LAS_TRUNCATED', /needs 10000000/],
    ['point format 11', { minor: 4, format: 11 }, 'LAS_HEADER', /is 11; allowed: 0 to 10/],
    ['new format, old version', { minor: 2, format: 6 }, 'LAS_HEADER', /6 in version 1\.2/],
    ['old format, new version', { minor: 5, format: 3 }, 'LAS_HEADER', /3 in version 1\.5/],
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
      assert.throws(() => readLasHeader(file.subarray(0, 393), file.length, 'a.las'), {
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

const kEllipsoid = 'SPHEROID["GRS 1980",6378137,298.257222101,AUTHORITY["EPSG","7019"]]';
const kGeographic =
  `GEOGCS["Slovenia 1996",DATUM["D 96 ['a']",${kEllipsoid},AUTHORITY["EPSG","6765"]],` +
  'UNIT["degree",0.0174532925199433],AUTHORITY["EPSG","4765"]]';
const kProjected =
  `PROJCS["Slovenia 1996 / ""Grid]""",${kGeographic},PROJECTION["Transverse_Mercator"],` +
  'UNIT["metre",1,AUTHORITY["EPSG","9001"]],AUTHORITY["EPSG","3794"]]';

test('the code of WKT is that of its horizontal system', () => {
  const cases: { name: string; wkt: string; code: number | undefined }[] = [
    { name: 'projected', wkt: kProjected, code: 3794 },
    {
      name: 'with heights',
      wkt:
        `COMPD_CS["a",${kProjected},VERT_CS["h",VERT_DATUM["d",2005,AUTHORITY["EPSG","5177"]],` +
        'AUTHORITY["EPSG","5778"]],AUTHORITY["EPSG","8690"]]',
      code: 3794,
    },
    { name: 'geographic', wkt: kGeographic, code: 4765 },
    {
      name: 'WKT 2',
      wkt:
        'COMPOUNDCRS["a",PROJCRS["b",BASEGEOGCRS["c",DATUM["d",ELLIPSOID["e",1,2]],' +
        'ID["EPSG",4765]],CONVERSION["f",METHOD["g",ID["EPSG",9807]]],CS[Cartesian,2],' +
        'ID["EPSG",3794]],VERTCRS["h",ID["EPSG",5778]]]',
      code: 3794,
    },
    { name: 'no code', wkt: kProjected.replace(',AUTHORITY["EPSG","3794"]', ''), code: undefined },
    {
      name: 'another authority',
      wkt: kProjected.replace('"EPSG","3794"', '"X","3794"'),
      code: undefined,
    },
    { name: 'cut off', wkt: kProjected.slice(0, 100), code: undefined },
    {
      name: 'a name that looks like a code',
      wkt: 'PROJCS["AUTHORITY[""EPSG"",""3794""]"]',
      code: undefined,
    },
    { name: 'nothing', wkt: 'here', code: undefined },
  ];
  for (const { name, wkt, code } of cases) assert.equal(parseWktCode(wkt), code, name);
});

test('a file says in which CRS its points are', async (t) => {
  const wkt = makeWkt(kProjected);
  const keys = (...pairs: [number, number][]): Buffer => makeLas({ vlrs: [makeKeys(...pairs)] });
  const other = makeKeys([3072, 3912]);
  const cutOff = makeLas({ vlrs: [other], pointOffset: 227 + 54 + 15 });
  const las14 = (fixture: LasFixture): Buffer => makeLas({ minor: 4, format: 6, ...fixture });
  const cases: [name: string, file: Buffer, crs: string | undefined][] = [
    ['no records', makeLas(), undefined],
    ['WKT', makeLas({ minor: 4, format: 6, vlrs: [wkt] }), 'EPSG:3794'],
    ['compressed', makeLaz({ vlrs: [other] }), 'EPSG:3912'],
    ['keys', keys([1024, 1], [2048, 4258], [3072, 25832], [4096, 7837]), 'EPSG:25832'],
    ['keys of a geographic system', keys([1024, 2], [2048, 4326]), 'EPSG:4326'],
    ['user-defined keys', keys([1024, 1], [2048, 4258], [3072, 32767]), undefined],
    ['WKT counts before keys', makeLas({ vlrs: [other, wkt] }), 'EPSG:3794'],
    ['keys that are cut off', cutOff, undefined],
    ['WKT behind the points', las14({ extended: [wkt] }), 'EPSG:3794'],
    ['keys behind the points of LAS 1.5', las14({ minor: 5, extended: [other] }), 'EPSG:3912'],
    [
      'no WKT in the first record',
      las14({ vlrs: [makeWkt('none')], extended: [wkt] }),
      'EPSG:3794',
    ],
    ['a record that is cut off', las14({ extended: [wkt] }).subarray(0, -9), undefined],
  ];
  const folder = await temporaryFolder(t);
  for (const [name, file, crs] of cases) {
    const path = join(folder, 'a.las');
    await writeFile(path, file);
    assert.equal((await verifyLasFile(path, 'a.las', kNever)).crs, crs, name);
  }
});

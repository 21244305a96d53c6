import assert from 'node:assert/strict';
import { writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { parseWktCode, verifyLasFile } from '../../../grabber/src/las/verify.js';
import { makeKeys, makeLas, makeLaz, makeWkt } from '../support/las-fixture.js';
import { kNever, temporaryFolder } from '../support/store-fixture.js';

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
  const cases: [name: string, file: Buffer, crs: string | undefined][] = [
    ['no records', makeLas(), undefined],
    ['WKT', makeLas({ minor: 4, format: 6, vlrs: [wkt] }), 'EPSG:3794'],
    ['compressed', makeLaz({ vlrs: [other] }), 'EPSG:3912'],
    ['keys', keys([1024, 1], [2048, 4258], [3072, 25832], [4096, 7837]), 'EPSG:25832'],
    ['keys of a geographic system', keys([1024, 2], [2048, 4326]), 'EPSG:4326'],
    ['user-defined keys', keys([1024, 1], [2048, 4258], [3072, 32767]), undefined],
    ['WKT counts before keys', makeLas({ vlrs: [other, wkt] }), 'EPSG:3794'],
    ['keys that are cut off', cutOff, undefined],
  ];
  const folder = await temporaryFolder(t);
  for (const [name, file, crs] of cases) {
    const path = join(folder, 'a.las');
    await writeFile(path, file);
    assert.equal((await verifyLasFile(path, 'a.las', kNever)).crs, crs, name);
  }
});

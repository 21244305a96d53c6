import assert from 'node:assert/strict';
import { test } from 'node:test';
import {
  parseSquare,
  squareAt,
  type Grid,
  expandTemplate,
  stemReader,
  templateProblem,
} from '../../../grabber/src/sources/square.js';

const kGrid: Grid = { square_m: 1000, extent_m: [370_000, 25_000, 630_000, 200_000] };

test('a name that cannot be meant is a usage error', () => {
  const twoKilometres = { square_m: 2000, extent_m: undefined };
  for (const [name, grid, message] of [
    ['TM_462_101', kGrid, /"TM_462_101"; allowed: E_N in kilometres/],
    ['85_446', kGrid, /outside the source/],
    ['401_100', twoKilometres, /multiples of the square size, 2 km/],
  ] as const) {
    assert.throws(() => parseSquare(name, grid), { code: 'USAGE', message });
  }
});

test('a template expands to the address of a square', () => {
  const square = squareAt(85_000, 446_000);
  for (const [template, url] of [
    ['http://h/{E}_{N}.laz', 'http://h/85_446.laz'],
    ['http://h/{x:06}_{y:06}.laz', 'http://h/085000_446000.laz'],
    ['http://h/{block}/{name}.laz', 'http://h/..%2Fx%20y/85_446.laz'],
    ['http://h/{E}/{E}_{N}.laz', 'http://h/85/85_446.laz'],
  ] as const) {
    assert.equal(expandTemplate(template, square, { block: '../x y' }), url);
  }
  assert.throws(() => expandTemplate('http://h/{region}/{name}', square, {}), {
    code: 'TEMPLATE',
    message: /\{region\} has no value/,
  });
});

test('a template that cannot name squares is refused', () => {
  for (const [template, problem] of [
    ['http://h/{e}_{N}.laz', /placeholder \{e\}; allowed: \{E\} \{N\}/],
    ['http://h/{E}.laz', /differs by square/],
    ['http://h/{name.laz', /brace/],
    ['ftp://h/{name}.laz', /no web address/],
    ['{name}.laz', /no web address/],
    ['http://{name}.example.org/a.laz', /placeholder in the host/],
  ] as const) {
    assert.match(templateProblem(template, []) ?? 'no problem', problem, template);
  }
});

test('file names are read back with the template that makes them', () => {
  const corner = { east_m: 462_000, north_m: 101_000 };
  for (const [template, stem, expected] of [
    ['http://h/{block}/TM_{E}_{N}.laz', 'TM_462_101', corner],
    ['http://h/{block}/TM_{E}_{N}.laz', 'tm_462_101', corner],
    ['http://h/AHN5_C_{x:06}_{y:06}.COPC.LAZ', 'AHN5_C_462000_101000', corner],
    ['http://h/3dm_32_{E}_{N}_1_nw.laz', '3dm_32_462_101_1_nw', corner],
    ['http://h/{E}/{name}.laz', '462_101', corner],
    ['http://h/TM_{E}_{N}.laz', 'GKOT_462_101', undefined],
    ['http://h/TM_{E}_{N}.laz', 'TM_462_101_old', undefined],
  ] as const) {
    assert.deepEqual(stemReader(template)(stem), expected, `${stem} by ${template}`);
  }
});

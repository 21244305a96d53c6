import assert from 'node:assert/strict';
import { test } from 'node:test';
import { parseSquare, squareAt, type Grid } from '../../../grabber/src/sources/square.js';
import {
  expandTemplate,
  stemReader,
  templateProblem,
} from '../../../grabber/src/sources/url-template.js';

const kGrid: Grid = { square_m: 1000, extent_m: [370_000, 25_000, 630_000, 200_000] };

test('a name that cannot be meant is a usage error', async (t) => {
  const cases: { name: string; act: () => unknown; message: RegExp }[] = [
    {
      name: 'a name of another form',
      act: () => parseSquare('TM_462_101', kGrid),
      message: /"TM_462_101"; allowed: E_N in kilometres/,
    },
    {
      name: 'a square of another country',
      act: () => parseSquare('85_446', kGrid),
      message: /outside the source/,
    },
    {
      name: 'not on the grid',
      act: () => parseSquare('401_100', { square_m: 2000, extent_m: undefined }),
      message: /multiples of the square size, 2 km/,
    },
  ];
  for (const { name, act, message } of cases) {
    await t.test(name, () => assert.throws(act, { code: 'USAGE', message }));
  }
});

test('a template expands to the address of a square', async (t) => {
  const square = squareAt(85_000, 446_000);
  const cases: { name: string; template: string; url: string }[] = [
    { name: 'kilometres', template: 'http://h/{E}_{N}.laz', url: 'http://h/85_446.laz' },
    {
      name: 'padded metres',
      template: 'http://h/{x:06}_{y:06}.laz',
      url: 'http://h/085000_446000.laz',
    },
    {
      name: 'name and variable',
      template: 'http://h/{block}/{name}.laz',
      url: 'http://h/b_35/85_446.laz',
    },
    {
      name: 'the same placeholder twice',
      template: 'http://h/{E}/{E}_{N}.laz',
      url: 'http://h/85/85_446.laz',
    },
  ];
  for (const { name, template, url } of cases) {
    await t.test(name, () =>
      assert.equal(expandTemplate(template, square, { block: 'b_35' }), url),
    );
  }
  assert.equal(
    expandTemplate('http://h/{block}/{name}', square, { block: '../x y' }),
    'http://h/..%2Fx%20y/85_446',
  );
  assert.throws(() => expandTemplate('http://h/{region}/{name}', square, {}), {
    code: 'TEMPLATE',
    message: /\{region\} has no value/,
  });
});

test('a template that cannot name squares is refused', async (t) => {
  const cases: { template: string; problem: RegExp }[] = [
    { template: 'http://h/{e}_{N}.laz', problem: /placeholder \{e\}; allowed: \{E\} \{N\}/ },
    { template: 'http://h/{E}.laz', problem: /differs by square/ },
    { template: 'http://h/{name.laz', problem: /brace/ },
    { template: 'ftp://h/{name}.laz', problem: /no web address/ },
    { template: '{name}.laz', problem: /no web address/ },
    { template: 'http://{name}.example.org/a.laz', problem: /placeholder in the host/ },
  ];
  for (const { template, problem } of cases) {
    await t.test(template, () =>
      assert.match(templateProblem(template, []) ?? 'no problem', problem),
    );
  }
});

test('file names are read back with the template that makes them', async (t) => {
  const corner = { east_m: 462_000, north_m: 101_000 };
  const cases: { template: string; stem: string; corner: typeof corner | undefined }[] = [
    { template: 'http://h/{block}/TM_{E}_{N}.laz', stem: 'TM_462_101', corner },
    { template: 'http://h/{block}/TM_{E}_{N}.laz', stem: 'tm_462_101', corner },
    { template: 'http://h/AHN5_C_{x:06}_{y:06}.COPC.LAZ', stem: 'AHN5_C_462000_101000', corner },
    { template: 'http://h/3dm_32_{E}_{N}_1_nw.laz', stem: '3dm_32_462_101_1_nw', corner },
    { template: 'http://h/{E}/{name}.laz', stem: '462_101', corner },
    { template: 'http://h/TM_{E}_{N}.laz', stem: 'GKOT_462_101', corner: undefined },
    { template: 'http://h/TM_{E}_{N}.laz', stem: 'TM_462_101_old', corner: undefined },
  ];
  for (const { template, stem, corner: expected } of cases) {
    await t.test(`${stem} by ${template}`, () =>
      assert.deepEqual(stemReader(template)(stem), expected),
    );
  }
});

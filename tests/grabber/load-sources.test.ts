import assert from 'node:assert/strict';
import { readFile, readdir, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { loadSources, parseSource } from '../../grabber/src/sources/load-sources.js';
import { squareAt } from '../../grabber/src/sources/square.js';
import { expandTemplate } from '../../grabber/src/sources/url-template.js';
import { readPackageInfo } from '../../grabber/src/util/package-info.js';
import { kNever, temporaryFolder } from './support/store-fixture.js';

const kRoot = readPackageInfo().root;
const kShipped = join(kRoot, '..', 'config', 'sources');

const kGood = `
id = "here"
title = "Here"
licence = "CC0"
attribution = "Us"
crs = "EPSG:3794"
square_m = 1000
extent_m = [0, 0, 1000000, 1000000]
class_table = "asprs"
url = "https://example.org/{block}/{E}_{N}.laz"
max_concurrent = 4
missing_status = [404]
[variables.block]
about = "block"
pattern = "b_[0-9]+"
allowed = "b_1 and so on"
`;

test('the shipped sources are valid and expand to the published addresses', async () => {
  const sources = await loadSources(kShipped, kNever);
  const expected: Record<string, { corner: [number, number]; variables: Record<string, string>; path: string }> = {
    'de-by': { corner: [690_000, 5_336_000], variables: {}, path: '/odd_data/laser/690_5336.laz' },
    'de-nw': {
      corner: [356_000, 5_645_000],
      variables: {},
      path: '/produkte/geobasis/hm/3dm_l_las/3dm_l_las/3dm_32_356_5645_1_nw.laz',
    },
    'nl-ahn': {
      corner: [85_000, 446_000],
      variables: {},
      path: '/hwh-ahn/AHN5_KM/01_LAZ/AHN5_C_085000_446000.COPC.LAZ',
    },
    'si-clss': {
      corner: [431_000, 136_000],
      variables: { region: '04-jesenice' },
      path: '/clss/raw/04-jesenice/zls/gkot/GKOT_431_136.laz',
    },
    'si-clss-copc': {
      corner: [431_000, 136_000],
      variables: {},
      path: '/data/SI/GURS/CLSS_2023/copc/GKOT_431_136.copc.laz',
    },
    'si-lss': {
      corner: [462_000, 101_000],
      variables: { block: 'b_35' },
      path: '/lidar/gkot/laz/b_35/D96TM/TM_462_101.laz',
    },
  };
  assert.deepEqual([...sources.keys()], Object.keys(expected));
  for (const [id, { corner, variables, path }] of Object.entries(expected)) {
    const source = sources.get(id);
    assert.ok(source);
    assert.equal(new URL(expandTemplate(source.url, squareAt(...corner), variables)).pathname, path);
    assert.ok(source.max_concurrent <= 4, `${id} is asked politely`);
    for (const [name, value] of Object.entries(variables)) {
      assert.match(value, new RegExp(`^(?:${source.variables[name]?.pattern ?? ''})$`));
    }
  }
});

test('no host of a source stands in the code', async () => {
  const hosts = [...(await loadSources(kShipped, kNever)).values()].map((source) => new URL(source.url).host);
  const names = (await readdir(join(kRoot, 'src'), { recursive: true })).filter((name) => name.endsWith('.ts'));
  assert.ok(names.length > 10);
  for (const name of names) {
    const text = await readFile(join(kRoot, 'src', name), 'utf8');
    for (const host of hosts) assert.ok(!text.includes(host), `${name} names ${host}`);
  }
});

test('a bad source file is refused with file, field, value and what is allowed', async (t) => {
  const cases: { name: string; from: string; to: string; message: RegExp }[] = [
    {
      name: 'a size in kilometres',
      from: 'square_m = 1000',
      to: 'square_m = 1',
      message: /here\.toml: field square_m is 1; allowed: a multiple of 1000/,
    },
    { name: 'a size in words', from: 'square_m = 1000', to: 'square_m = "1 km"', message: /field square_m is "1 km"/ },
    {
      name: 'a field left out',
      from: 'licence = "CC0"',
      to: '',
      message: /field licence is missing; allowed: text of 1 to 200/,
    },
    {
      name: 'a field nobody knows',
      from: 'licence = "CC0"',
      to: 'licence = "CC0"\nlicense = "CC0"',
      message: /field license is "CC0"; allowed: the fields id, title/,
    },
    {
      name: 'a CRS by name',
      from: 'EPSG:3794',
      to: 'D96/TM',
      message: /field crs is "D96\/TM"; allowed: EPSG:<number>/,
    },
    {
      name: 'an extent inside out',
      from: '[0, 0, 1000000, 1000000]',
      to: '[9, 0, 1, 1]',
      message: /field extent_m is \[9,0,1,1\]; allowed: \[west/,
    },
    {
      name: 'a placeholder nobody fills',
      from: '{block}',
      to: '{blok}',
      message: /field url is .*placeholder \{blok\}; allowed: .*\{block\}/,
    },
    {
      name: 'too many at once',
      from: 'max_concurrent = 4',
      to: 'max_concurrent = 100',
      message: /field max_concurrent is 100; allowed: an integer from 1 to 32/,
    },
    {
      name: 'success as a sign of absence',
      from: '[404]',
      to: '[200]',
      message: /field missing_status\.0 is 200; allowed: a list of HTTP statuses from 400/,
    },
    {
      name: 'a pattern that is none',
      from: 'b_[0-9]+',
      to: 'b_[0-9',
      message: /field variables\.block\.pattern is "b_\[0-9"/,
    },
    {
      name: 'the id of another file',
      from: 'id = "here"',
      to: 'id = "there"',
      message: /field id is "there"; allowed: .*same as the file name/,
    },
    { name: 'not TOML', from: 'id = ', to: 'id: ', message: /here\.toml: not TOML/ },
  ];
  for (const { name, from, to, message } of cases) {
    await t.test(name, () => {
      assert.ok(kGood.includes(from));
      assert.throws(
        () => parseSource(kGood.replace(from, to), 'sources/here.toml'),
        (error: Error & { code?: string }) => {
          assert.equal(error.code, 'CONFIG');
          assert.match(error.message, message);
          assert.ok(!error.message.includes('\n'), 'one line');
          return true;
        },
      );
    });
  }
});

test('one bad file fails the folder, for a source must not vanish quietly', async (t) => {
  const folder = await temporaryFolder(t);
  await writeFile(join(folder, 'here.toml'), kGood);
  assert.deepEqual([...(await loadSources(folder, kNever)).keys()], ['here']);
  await writeFile(join(folder, 'worse.toml'), 'id = 3');
  await assert.rejects(loadSources(folder, kNever), { code: 'CONFIG', message: /worse\.toml: field id is 3/ });
  await assert.rejects(loadSources(join(folder, 'nowhere'), kNever), { code: 'CONFIG', message: /nowhere/ });
});

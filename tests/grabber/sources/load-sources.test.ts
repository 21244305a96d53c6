import assert from 'node:assert/strict';
import { access, readFile, readdir, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { openCatalogue } from '../../../grabber/src/sources/catalogue/open-catalogue.js';
import {
  listHosts,
  loadSources,
  parseSource,
  listVariables,
} from '../../../grabber/src/sources/source.js';
import { fileNameReader } from '../../../grabber/src/sources/naming.js';
import { type GrabberError, describeError } from '../../../grabber/src/util/errors.js';
import { readPackageInfo } from '../../../grabber/src/util/package-info.js';
import { regionOfSquares } from '../../../grabber/src/select/region.js';
import { squareAt } from '../../../grabber/src/sources/square.js';
import { clientFor, found } from '../support/catalogue-fixture.js';
import { kNever, temporaryFolder } from '../support/store-fixture.js';

const kRoot = readPackageInfo().root;
const kConfig = join(kRoot, '..', 'config');
const kShipped = join(kConfig, 'sources');

const kIds = [
  'ch-swisstopo',
  'de-by',
  'de-nw',
  'fr-lidarhd',
  'nl-ahn',
  'nl-ahn6',
  'si-clss',
  'si-clss-copc',
  'si-lss',
  'si-lss-d48',
  'us-3dep',
];

const shipped = loadSources(kShipped, kNever);

test('every shipped source is valid, polite, and has a class table', async () => {
  const sources = await shipped;
  assert.deepEqual([...sources.keys()], kIds);
  for (const [id, source] of sources) {
    assert.ok(source.max_concurrent <= 4, `${id} limits its requests`);
    await access(join(kConfig, 'classes', `${source.class_table}.toml`));
    assert.ok(listHosts(source).length > 0, id);
    assert.equal(source.allow_private_addresses, false, id);
  }
});

type Variables = Record<string, string>;

test('sources whose addresses follow a rule give the published addresses', async (t) => {
  const sources = await shipped;
  const lss = (folder: string, file: string): string[] =>
    ['gkot/laz', 'GKOT/laz', 'gkot'].map(
      (way) => `/lidar/${way}/${folder}/${file}.${way.endsWith('laz') ? 'laz' : 'zlas'}`,
    );
  const nrw = '/produkte/geobasis/hm/3dm_l_las/3dm_l_las/3dm_32_356_5645_1_nw.laz';
  const cases: [id: string, corner: [number, number], urls: string[], set?: Variables][] = [
    ['de-by', [690, 5336], ['/odd_data/laser/690_5336.laz']],
    ['de-nw', [356, 5645], [nrw]],
    ['nl-ahn', [85, 446], ['/hwh-ahn/AHN5_KM/01_LAZ/AHN5_C_085000_446000.COPC.LAZ']],
    [
      'nl-ahn6',
      [85, 446],
      ['/hwh-ahn/AHN6/01_LAZ/AHN6_2025_C_085000_446000.COPC.LAZ'],
      { year: '2025' },
    ],
    ['si-clss-copc', [431, 136], ['/data/SI/GURS/CLSS_2023/copc/GKOT_431_136.copc.laz']],
    ['si-lss', [462, 101], lss('b_35/D96TM', 'TM_462_101'), { block: 'b_35' }],
    ['si-lss-d48', [545, 141], lss('b_23/D48GK', 'GK_545_141'), { block: 'b_23' }],
  ];
  for (const [id, corner, urls, variables] of cases) {
    await t.test(id, async (t) => {
      const source = sources.get(id);
      assert.ok(source);
      const catalogue = openCatalogue(source, clientFor(t), { variables: variables ?? {} });
      const region = regionOfSquares([squareAt(corner[0] * 1000, corner[1] * 1000)], 1000);
      const [square] = await found(catalogue, region);
      assert.deepEqual(
        square?.urls.map((url) => new URL(url).pathname),
        urls,
      );
    });
  }
});

test('file names of every source give their square', async () => {
  const sources = await shipped;
  const cases: Record<string, [stem: string, name: string]> = {
    'ch-swisstopo': ['swisssurface3d_2020_2722-1124_2056_5728', '2722_1124'],
    'de-by': ['690_5336', '690_5336'],
    'de-nw': ['3dm_32_356_5645_1_nw', '356_5645'],
    'fr-lidarhd': ['LHD_FXX_0998_6542_PTS_LAMB93_IGN69', '998_6541'],
    'nl-ahn': ['AHN5_C_085000_446000', '85_446'],
    'nl-ahn6': ['AHN6_2025_C_085000_446000', '85_446'],
    'si-clss': ['GKOT_431_136', '431_136'],
    'si-clss-copc': ['GKOT_431_136', '431_136'],
    'si-lss': ['TM_462_101', '462_101'],
    'si-lss-d48': ['GK_462_101', '462_101'],
  };
  for (const [id, [stem, name]] of Object.entries(cases)) {
    const source = sources.get(id);
    assert.ok(source, id);
    assert.equal(fileNameReader(source)(stem)?.name, name);
    assert.equal(fileNameReader(source)('notes'), undefined);
  }
});

test('the blocks and regions of the Slovenian surveys are all there', async () => {
  const sources = await shipped;
  const values = (id: string, name: string): readonly string[] => {
    const source = sources.get(id);
    return source === undefined ? [] : (listVariables(source)[name]?.values ?? []);
  };
  assert.equal(values('si-lss', 'block').length, 27);
  assert.deepEqual(values('si-lss', 'block'), values('si-lss-d48', 'block'));
  assert.equal(values('si-clss', 'region').length, 16);
});

test('no host of a source stands in the code', async () => {
  const hosts = [...(await shipped).values()].flatMap(listHosts);
  assert.ok(hosts.length > 10);
  const names = (await readdir(join(kRoot, 'src'), { recursive: true })).filter((name) =>
    name.endsWith('.ts'),
  );
  assert.ok(names.length > 10);
  for (const name of names) {
    const text = await readFile(join(kRoot, 'src', name), 'utf8');
    for (const host of hosts) assert.ok(!text.includes(host), `${name} names ${host}`);
  }
});

const kGood = `
id = "here"
title = "Here"
licence = "CC0"
attribution = "Us"
crs = "EPSG:3794"
square_m = 1000
extent_m = [0, 0, 1000000, 1000000]
class_table = "asprs"
max_concurrent = 4
missing_status = [404]
hosts = ["cdn.example.org", "files.example.org:8443"]
[secret_headers]
x-key = "HERE_KEY"
[access]
kind = "template"
urls = [
  "https://example.org/{block}/{E}_{N}.laz",
  "http://mirror.example.org:8080/{block}/{E}_{N}.laz",
]
[access.variables.block]
about = "block"
pattern = "b_[0-9]+"
allowed = "b_1 and so on"
values = ["b_1", "b_2"]
`;

test('hosts of a source are those of its addresses and those it names', () => {
  assert.deepEqual(listHosts(parseSource(kGood, 'here.toml')), [
    'cdn.example.org',
    'example.org',
    'files.example.org:8443',
    'mirror.example.org',
  ]);
});

const kBad: [from: string, to: string, message: RegExp][] = [
  [
    'square_m = 1000',
    'square_m = 1',
    /here\.toml: field square_m is 1; allowed: a multiple of 1000/,
  ],
  ['square_m = 1000', 'square_m = "1 km"', /field square_m is "1 km"/],
  ['square_m = 1000', '', /field square_m is missing; allowed: a multiple/],
  ['licence = "CC0"', '', /field licence is missing; allowed: text of 1 to 200/],
  ['licence =', 'license = "CC0"\nlicence =', /license is "CC0"; allowed: the fields id, title/],
  ['kind = "template"', 'kind = "template"\nurl = "x"', /field access\.url is "x"; allowed: a/],
  ['kind = "template"', 'kind = "ftp"', /field access\.kind is "ftp"; allowed: "template"/],
  ['EPSG:3794', 'D96/TM', /field crs is "D96\/TM"; allowed: EPSG:<number>/],
  ['[0, 0, 1000000, 1000000]', '[9, 0, 1, 1]', /field extent_m is \[9,0,1,1\]; allowed: \[west/],
  ['//example.org/{block}/', '//example.org/{blok}/', /field access\.urls is .*\{blok\}/],
  ['https://example.org/', 'https://{block}.example.org/', /placeholder in the host/],
  ['variables.block]', 'variables.blok]', /blok/],
  ['max_concurrent = 4', 'max_concurrent = 100', /is 100; allowed: an integer from 1 to 32/],
  ['[404]', '[200]', /field missing_status\.0 is 200; allowed: a list of HTTP statuses from 400/],
  ['b_[0-9]+', 'b_[0-9', /field access\.variables\.block\.pattern is "b_\[0-9"/],
  ['"b_2"', '"c_2"', /field access\.variables\.block is /],
  ['cdn.example.org', 'cdn.example.org:65536', /field hosts\.0 is "cdn\.example\.org:65536"; allo/],
  ['"HERE_KEY"', '"sk-123-456"', /secret_headers\.x-key is .*NAME_OF_ENVIRONMENT_VARIABLE/],
  ['id = "here"', 'id = "there"', /field id is "there"; allowed: .*same as the file name/],
  ['id = ', 'id: ', /here\.toml: not TOML/],
];

test('a bad source file is refused with file, field, value and what is allowed', async (t) => {
  for (const [from, to, message] of kBad) {
    await t.test(`${from}: ${to}`, () => {
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

test('a file of one long line is refused without quoting all of it', () => {
  const nested = `a = ${'['.repeat(15_000)}`;
  const long = kGood.replace('licence = "CC0"', `licence = "${'x'.repeat(15_000)}"`);
  for (const text of [nested, long]) {
    assert.throws(
      () => parseSource(text, 'here.toml'),
      (error: GrabberError) => {
        assert.equal(error.code, 'CONFIG');
        return describeError(error).length < 5000;
      },
    );
  }
});

test('a WFS source has either a field with the address or addresses that follow a rule', () => {
  const wfs = (more: string): string =>
    `${kGood.slice(0, kGood.indexOf('[access]'))}[access]\nkind = "wfs"\nurl = ` +
    `"https://example.org/wfs"\ntype = "a:b"\nname_field = "n"\n${more}\n`;
  assert.throws(() => parseSource(wfs(`name_pattern = '(?<E>\\d+)_(?<N>\\d+)'`), 'here.toml'), {
    message: /both url_field and urls, or neither/,
  });
  assert.throws(() => parseSource(wfs('url_field = "u"'), 'here.toml'), {
    message: /field access\.name_pattern is missing/,
  });
  assert.throws(
    () => parseSource(wfs(`url_field = "u"\nname_pattern = '(?<E>\\d+)'`), 'here.toml'),
    { message: /name_pattern is .*groups/ },
  );
});

test('one bad file fails the folder, for a source must not vanish quietly', async (t) => {
  const folder = await temporaryFolder(t);
  await writeFile(join(folder, 'here.toml'), kGood);
  assert.deepEqual([...(await loadSources(folder, kNever)).keys()], ['here']);
  await writeFile(join(folder, 'worse.toml'), 'id = 3');
  await assert.rejects(loadSources(folder, kNever), {
    code: 'CONFIG',
    message: /worse\.toml: field id is 3/,
  });
  await assert.rejects(loadSources(join(folder, 'nowhere'), kNever), {
    code: 'CONFIG',
    message: /nowhere/,
  });
});

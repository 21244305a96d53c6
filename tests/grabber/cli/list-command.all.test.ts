import assert from 'node:assert/strict';
import { mkdir, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test, type TestContext } from 'node:test';
import { cli } from '../support/cli.js';
import { configFolder } from '../support/config-fixture.js';
import { sendFile, serve } from '../support/http-fixture.js';
import { makeLaz } from '../support/las-fixture.js';
import { temporaryFolder } from '../support/store-fixture.js';

test('sources and areas print tables, and JSON where requested', async () => {
  const table = await cli(['sources']);
  assert.equal(table.code, 0, table.err);
  assert.match(table.out, /^id +crs/);
  assert.match(table.out, /\nsi-lss +EPSG:3794 +1000 m/);
  assert.match(table.out, /\nus-3dep +EPSG:3857 +- /);
  const json = JSON.parse((await cli(['sources', '--json'])).out) as {
    id: string;
    hosts: string[];
  }[];
  assert.deepEqual(json.find(({ id }) => id === 'ch-swisstopo')?.hosts, ['data.geo.admin.ch']);

  const areas = await cli(['areas']);
  assert.match(areas.out, /^name +latitude +longitude +size +title\n/);
  assert.match(areas.out, /\nbled +46\.\d{3} N +14\.\d{3} E +\d\.\d x \d\.\d km +Bled, Slovenia/);
  const all = JSON.parse((await cli(['areas', '--json'])).out) as {
    name: string;
    polygon: number[][][];
  }[];
  assert.ok((all.find(({ name }) => name === 'bled')?.polygon[0]?.length ?? 0) > 3);
});

test('list computes the addresses that follow a rule, without a request', async () => {
  const list = await cli([
    'list',
    '--source',
    'si-lss',
    '--block',
    'b_35',
    '--bbox',
    '462000,101000,463000.5,102000',
  ]);
  assert.equal(list.code, 0, list.err);
  assert.match(
    list.out,
    /^462_101\thttps:\/\/[^\n]*\/b_35\/D96TM\/TM_462_101\.laz\n463_101\t[^\n]*\n$/,
  );
  const open = await cli(['list', '--source', 'si-lss', '--squares', '462_101']);
  assert.equal(open.out, '462_101\t?\n', 'the fetch finds the block by trying');
  const line = await cli([
    'list',
    '--url-template',
    'http://h/{x:06}_{y}',
    '--squares',
    '85_446',
    '--json',
  ]);
  assert.deepEqual(JSON.parse(line.out), {
    source: 'adhoc',
    name: '85_446',
    block: null,
    bounds: [85_000, 446_000, 86_000, 447_000],
    urls: ['http://h/085000_446000'],
    bytes: null,
    sha256: null,
    member: null,
    published: null,
  });
});

/** A catalogue, and an area that lies in it. */
async function catalogueFolder(t: TestContext, base: string): Promise<string> {
  const access = [
    'kind = "wfs"',
    `url = "${base}/wfs"`,
    'type = "a:b"',
    'url_field = "url"',
    'name_field = "name"',
    "name_pattern = '(?<E>\\d+)_(?<N>\\d+)'",
  ];
  const folder = await configFolder(t, access.join('\n'));
  await mkdir(join(folder, 'areas'));
  await writeFile(
    join(folder, 'areas', 'castle.toml'),
    'id = "castle"\ntitle = "Castle"\ncircle = { lon = 14.5154, lat = 46.0523, radius_m = 200 }\n',
  );
  return folder;
}

test('list reads catalogues of other sources, and a catalogue that fails ends it', async (t) => {
  const server = await serve(t, (_request, response, index) => {
    if (index > 0) return void response.writeHead(404).end();
    response.end(
      JSON.stringify({
        features: [
          { properties: { name: '462_101', url: `${server.base}/a.laz` }, geometry: null },
        ],
        numberMatched: 1,
      }),
    );
  });
  const config = await catalogueFolder(t, server.base);
  const args = ['--config', config, 'list', '--source', 'here', '--area', 'Castle'];
  assert.deepEqual(await cli(args), { code: 0, out: `462_101\t${server.base}/a.laz\n`, err: '' });
  const failed = await cli(args);
  assert.equal(failed.code, 1);
  assert.equal(failed.out, '');
  assert.match(
    failed.err,
    /^error: list here: http:\/\/127\.0\.0\.1:\d+\/wfs\?.* answers HTTP 404; allowed: 200\n$/,
  );
});

test('wrong usage ends with exit code 2 and one line that states what is allowed', async (t) => {
  const cases: { args: string[]; message: RegExp }[] = [
    {
      args: ['--source', 'de-by', '--bbox', '1,2,3'],
      message: /--bbox.*'1,2,3' is invalid.*four numbers in metres/,
    },
    { args: ['--source', 'de-by', '--bbox', '3,2,1,4'], message: /west < east and south < north/ },
    { args: ['--source', 'de-by', '--bbox-deg', '11,48,12,98'], message: /--bbox-deg.*-85 to 85/ },
    {
      args: ['--source', 'de-by', '--bbox-deg', '179,48,-179,49'],
      message: /--bbox-deg.*west < east/,
    },
    {
      args: ['--source', 'de-by', '--circle', '690000,5336000,0'],
      message: /--circle.*radius at most 200000/,
    },
    {
      args: ['--source', 'de-by', '--circle-deg', '11,48'],
      message: /--circle-deg.*longitude,latitude,radius/,
    },
    { args: ['--source', 'de-by', '--area', 'fussn'], message: /did you mean fuessen\?/ },
    {
      args: ['--source', 'de-by'],
      message: /choose squares: none given; allowed: one of --squares, --bbox, --bbox-deg/,
    },
    {
      args: ['--source', 'si-lss', '--squares', '462_101', '--block', 'b_99'],
      message: /set block: "b_99"; allowed: b_11 to b_37/,
    },
    { args: ['--url-template', 'http://h/{e}', '--squares', '1_1'], message: /placeholder \{e\}/ },
    {
      args: ['--url-template', 'http://h/{E}_{N}', '--squares', '1_1', '--crs', 'D96'],
      message: /--crs.*EPSG:<number>/,
    },
  ];
  for (const { args, message } of cases) {
    await t.test(args.join(' '), async () => {
      const { code, out, err } = await cli(['list', ...args]);
      assert.match(err, message);
      assert.match(err, /^error: [^\n]*\n$/);
      assert.equal(code, 2);
      assert.equal(out, '');
    });
  }
});

test('--retries and --max-wait-s hold for catalogues, and retries are shown', async (t) => {
  const server = await serve(
    t,
    (request, response) =>
      void response
        .writeHead(503, { 'retry-after': request.url?.startsWith('/busy') === true ? '7200' : '0' })
        .end(),
  );
  const [config, busy, store] = [
    await catalogueFolder(t, server.base),
    await catalogueFolder(t, `${server.base}/busy`),
    await temporaryFolder(t),
  ];
  const commands = [
    ['list', '--area', 'castle'],
    ['fetch', '--area', 'castle', '--store', store],
    ['fishnet', 'import', '--dry-run'],
  ];
  for (const command of commands) {
    server.seen.length = 0;
    const failed = await cli([
      '--config',
      config,
      ...command,
      '--source',
      'here',
      '--retries',
      '1',
    ]);
    assert.equal(failed.code, 1, failed.err);
    assert.match(
      failed.err,
      new RegExp(
        String.raw`^retry 1 of the catalogue in \d\.\d s: list here: .*HTTP 503[^\n]*\n` +
          String.raw`error: list here: .*HTTP 503`,
      ),
    );
    assert.equal(server.seen.length, 2);
    const late = await cli([
      '--config',
      busy,
      ...command,
      '--source',
      'here',
      '--max-wait-s',
      '60',
    ]);
    assert.match(
      late.err,
      /^error: list here: .*HTTP 503.*7200 s; allowed: at most 60 s \(--max-wait-s\)\n$/,
    );
    assert.equal(server.seen.length, 3);
  }
});

test('unreadable entries of a catalogue are reported, and the rest is fetched', async (t) => {
  const laz = makeLaz({ dataBytes: 1000 });
  const server = await serve(t, (request, response) => {
    if (request.url?.startsWith('/a.laz') === true) return sendFile(response, laz);
    const entry = (name: string): object => ({
      id: name,
      properties: { name, url: `${server.base}/a.laz` },
      geometry: null,
    });
    response.end(
      JSON.stringify({ features: [entry('462_101'), entry('castle')], numberMatched: 2 }),
    );
  });
  const config = await catalogueFolder(t, server.base);
  const store = await temporaryFolder(t);
  const selection = ['--source', 'here', '--squares', '462_101,463_101'];
  const warning = /warning: left out of the catalogue \(1\): list here: [^\n]*castle/;
  const list = await cli(['--config', config, 'list', ...selection]);
  assert.equal(list.code, 3, list.err);
  assert.equal(list.out, `462_101\t${server.base}/a.laz\n`);
  assert.match(list.err, warning);
  const fetch = await cli(['--config', config, 'fetch', ...selection, '--store', store]);
  assert.equal(fetch.code, 3, fetch.err);
  assert.match(fetch.err, warning);
  assert.match(fetch.out, /^verified 462_101[^]*1 fetched, 0 already there, 0 missing/);
  const imported = await cli([
    '--config',
    config,
    'fishnet',
    'import',
    '--source',
    'here',
    '--store',
    store,
    '--bbox',
    '462000,101000,463000,102000',
  ]);
  assert.equal(imported.code, 3, imported.err);
});

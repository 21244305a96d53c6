import assert from 'node:assert/strict';
import { mkdir, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test, type TestContext } from 'node:test';
import { cli, words, configFolder } from '../support/cli.js';
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
  const list = await cli(
    words`list --source si-lss --block b_35 --bbox 462000,101000,463000.5,102000`,
  );
  assert.equal(list.code, 0, list.err);
  assert.match(
    list.out,
    /^462_101\thttps:\/\/[^\n]*\/b_35\/D96TM\/TM_462_101\.laz\n463_101\t[^\n]*\n$/,
  );
  const open = await cli(words`list --source si-lss --squares 462_101`);
  assert.equal(open.out, '462_101\t?\n', 'the fetch finds the block by trying');
  const line = await cli(words`list --url-template http://h/{x:06}_{y} --squares 85_446 --json`);
  const { source, name, bounds, urls } = JSON.parse(line.out) as Record<string, unknown>;
  assert.deepEqual([source, name, urls], ['adhoc', '85_446', ['http://h/085000_446000']]);
  assert.deepEqual(bounds, [85_000, 446_000, 86_000, 447_000]);
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
  const args = words`--config ${config} list --source here --area Castle`;
  assert.deepEqual(await cli(args), { code: 0, out: `462_101\t${server.base}/a.laz\n`, err: '' });
  const failed = await cli(args);
  assert.equal(failed.code, 1);
  assert.equal(failed.out, '');
  assert.match(
    failed.err,
    /^error: list here: http:\/\/127\.0\.0\.1:\d+\/wfs\?.* answers HTTP 404; allowed: 200\n$/,
  );
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
    words`list --area castle`,
    words`fetch --area castle --store ${store}`,
    words`fishnet import --dry-run`,
  ];
  for (const command of commands) {
    server.seen.length = 0;
    const line = [...command, ...words`--source here`];
    const failed = await cli([...words`--config ${config}`, ...line, ...words`--retries 1`]);
    assert.equal(failed.code, 1, failed.err);
    assert.match(
      failed.err,
      new RegExp(
        String.raw`^retry 1 of the catalogue in \d\.\d s: list here: .*HTTP 503[^\n]*\n` +
          String.raw`error: list here: .*HTTP 503`,
      ),
    );
    assert.equal(server.seen.length, 2);
    const late = await cli([...words`--config ${busy}`, ...line, ...words`--max-wait-s 60`]);
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
  const selection = words`--source here --squares 462_101,463_101`;
  const warning = /warning: left out of the catalogue \(1\): list here: [^\n]*castle/;
  const list = await cli([...words`--config ${config} list`, ...selection]);
  assert.equal(list.code, 3, list.err);
  assert.equal(list.out, `462_101\t${server.base}/a.laz\n`);
  assert.match(list.err, warning);
  const fetch = await cli([...words`--config ${config} fetch --store ${store}`, ...selection]);
  assert.equal(fetch.code, 3, fetch.err);
  assert.match(fetch.err, warning);
  assert.match(fetch.out, /^verified 462_101[^]*1 fetched, 0 already there, 0 missing/);
  const imported = await cli(
    words`--config ${config} fishnet import --source here --store ${store}
      --bbox 462000,101000,463000,102000`,
  );
  assert.equal(imported.code, 3, imported.err);
});

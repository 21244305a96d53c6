import assert from 'node:assert/strict';
import { mkdir, rm, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { openStore } from '../../../grabber/src/store/open-store.js';
import { readPackageInfo } from '../../../grabber/src/util/package-info.js';
import { cli, program, words } from '../support/cli.js';
import { configFolder, templateAccess } from '../support/config-fixture.js';
import { kNever, temporaryFolder } from '../support/store-fixture.js';

test('the program writes to its streams, and ends with the exit code of its command', async () => {
  const version = await program(['--version']);
  assert.deepEqual(version, { code: 0, out: `${readPackageInfo().version}\n`, err: '' });
  const wrong = await program(['grab']);
  assert.deepEqual([wrong.code, wrong.out], [2, '']);
  assert.match(wrong.err, /^error: unknown command 'grab'\n/);
  const help = await cli(['--help']);
  for (const word of ['sources', 'list', 'fetch', 'Exit codes']) {
    assert.ok(help.out.includes(word), word);
  }
});

test('wrong usage ends with exit code 2 and one line that states what is allowed', async (t) => {
  const store = await temporaryFolder(t);
  const fetch = `fetch --source de-by --squares 690_5336`;
  const cases: [line: string, message: RegExp][] = [
    [fetch, /choose store: none given; allowed: --store FOLDER/],
    [`${fetch} --store ${store} --concurrency 0`, /'0' is invalid.*integer from 1 to 32/],
    [`fetch --store ${store} --from ${store}`, /holds no files of squares/],
    ['list --source de-by --bbox 1,2,3', /--bbox.*'1,2,3' is invalid.*four numbers in metres/],
    ['list --source de-by --bbox 3,2,1,4', /west < east and south < north/],
    ['list --source de-by --bbox-deg 11,48,12,98', /--bbox-deg.*-85 to 85/],
    ['list --source de-by --bbox-deg 179,48,-179,49', /--bbox-deg.*west < east/],
    ['list --source de-by --circle 690000,5336000,0', /--circle.*radius at most 200000/],
    ['list --source de-by --circle-deg 11,48', /--circle-deg.*longitude,latitude,radius/],
    ['list --source de-by --area fussn', /did you mean fuessen\?/],
    ['list --url-template http://h/{E}_{N} --squares 1_1 --crs D96', /--crs.*EPSG:<number>/],
    ['fishnet import --source si-lss --from nowhere', /no store; allowed: --store FOLDER/],
    ['fishnet import --source si-lss --dry-run --name-field X --area bled', /without --from/],
    ['fishnet import --source si-lss --dry-run --from x --area bled --bbox 0,0,1,1', /one of them/],
  ];
  for (const [line, message] of cases) {
    await t.test(line, async () => {
      const { code, out, err } = await cli(line.split(' '));
      assert.match(err, message);
      assert.match(err, /^error: [^\n]*\n(\(Did you mean[^\n]*\n)?$/);
      assert.deepEqual([code, out], [2, '']);
    });
  }
});

/** The message quotes the line and its number, once. */
function notTomlIn(line: number): RegExp {
  return new RegExp(`not TOML: Invalid TOML document: [^:]* ${line}: [^:]*$`);
}

test('an invalid configuration file ends with exit code 2 and one line', async (t) => {
  const folder = await configFolder(t, templateAccess('http://127.0.0.1:1'));
  for (const name of ['areas', 'sources/ortho']) {
    await mkdir(join(folder, name), { recursive: true });
  }
  const store = openStore(await temporaryFolder(t), {}, kNever);
  store.close();
  const cases: [file: string, text: string, line: string, message: RegExp][] = [
    ['sources/worse.toml', 'id = "worse"', 'sources', /field title is missing; allowed: text/],
    ['sources/worse.toml', '\n\nid = [', 'sources', notTomlIn(3)],
    ['sources/ortho/worse.toml', '\n\nid = [', 'ortho --source worse', notTomlIn(3)],
    ['areas/worse.toml', '\nid = "', 'areas', notTomlIn(2)],
    ['converters.toml', '= 1', 'convert', notTomlIn(1)],
    ['licences.toml', '\n= 1', 'attribution', /Invalid TOML document: [^:]* 2: [^:]*allowed/],
    ['licences.toml', 'licence = 1', 'attribution', /read licences/],
  ];
  for (const [file, text, line, message] of cases) {
    await t.test(`${file}: ${text}`, async (t) => {
      t.after(() => rm(join(folder, file)));
      await writeFile(join(folder, file), text);
      const into = ['sources', 'areas'].includes(line) ? [] : ['--store', store.root];
      const { code, out, err } = await cli([
        ...words`--config ${folder}`,
        ...line.split(' '),
        ...into,
      ]);
      assert.match(err, /^error: read [^\n]*\n$/);
      assert.ok(err.includes(file), err);
      assert.match(err, message);
      assert.deepEqual([code, out], [2, '']);
    });
  }
});

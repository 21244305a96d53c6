import assert from 'node:assert/strict';
import { mkdir, rm, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { openStore } from '../../../grabber/src/store/open-store.js';
import { readPackageInfo, shippedConfig } from '../../../grabber/src/util/package-info.js';
import { cli, program, words, configFolder, templateAccess } from '../support/cli.js';
import { kNever, temporaryFolder } from '../support/store-fixture.js';
import type { OptionTable } from '../../../grabber/src/cli/option-tables.js';
import { findLazTool } from '../../../grabber/src/convert/converters.js';

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

test('tables hold each option of each command that help lists', async () => {
  const printed = await cli(['--option-tables']);
  assert.equal(printed.code, 0);
  const table = JSON.parse(printed.out) as OptionTable;
  assert.ok(table.commands.length >= 12);
  for (const command of table.commands) {
    const help = (await cli([command.name, '--help'])).out;
    const listed = [...help.matchAll(/^ {2}(?:-\w, )?(--[\w-]+)/gm)].map((match) => match[1]);
    const names = command.options.flatMap((option) => option.names);
    assert.deepEqual(
      names.filter((name) => name.startsWith('--')),
      listed,
      command.name,
    );
  }
  assert.doesNotMatch(printed.out, /"default": "\//);
});

test('the configuration is found in a checkout and in a prefix, unless it is named', async (t) => {
  const folder = await temporaryFolder(t);
  const findConfig = (root: string): string => shippedConfig({ version: '1', root });
  const checkout = join(folder, 'checkout');
  await mkdir(join(checkout, 'config'), { recursive: true });
  await writeFile(join(checkout, 'config', 'materials.toml'), '');
  const before = process.env['TERRAVOX_CONFIG'];
  try {
    delete process.env['TERRAVOX_CONFIG'];
    assert.equal(findConfig(join(checkout, 'grabber')), join(checkout, 'config'));
    assert.equal(
      findConfig(join(folder, 'lib', 'terravox', 'grabber')),
      join(folder, 'share', 'terravox', 'config'),
    );
    process.env['TERRAVOX_CONFIG'] = '/own';
    assert.equal(findConfig(join(checkout, 'grabber')), '/own');
  } finally {
    delete process.env['TERRAVOX_CONFIG'];
    if (before !== undefined) process.env['TERRAVOX_CONFIG'] = before;
  }
});

test('the tool for LAZ files is found among installed programs', async (t) => {
  const programs = await temporaryFolder(t);
  const tool = join(programs, 'terravox-laz');
  await writeFile(tool, '', { mode: 0o755 });
  assert.equal(await findLazTool({ id: 'converters' }, join(programs, 'grabber')), tool);
});

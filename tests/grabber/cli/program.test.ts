import assert from 'node:assert/strict';
import { mkdir, rm, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { openStore } from '../../../grabber/src/store/open-store.js';
import { readPackageInfo } from '../../../grabber/src/util/package-info.js';
import { cli } from '../support/cli.js';
import { configFolder, templateAccess } from '../support/config-fixture.js';
import { kNever, temporaryFolder } from '../support/store-fixture.js';

test('help and version go to standard output with exit code 0', async () => {
  const help = await cli(['--help']);
  assert.equal(help.code, 0);
  for (const word of ['sources', 'list', 'fetch', 'Exit codes']) {
    assert.ok(help.out.includes(word), word);
  }
  const version = await cli(['--version']);
  assert.deepEqual(version, { code: 0, out: `${readPackageInfo().version}\n`, err: '' });
});

test('wrong usage ends with exit code 2 and one line that states what is allowed', async (t) => {
  const store = await temporaryFolder(t);
  const cases: { args: string[]; message: RegExp }[] = [
    { args: ['grab'], message: /unknown command 'grab'/ },
    {
      args: ['fetch', '--source', 'de-by', '--squares', '690_5336'],
      message: /choose store: none given; allowed: --store FOLDER/,
    },
    {
      args: [
        'fetch',
        '--store',
        store,
        '--source',
        'de-by',
        '--squares',
        '690_5336',
        '--concurrency',
        '0',
      ],
      message: /'0' is invalid.*integer from 1 to 32/,
    },
    {
      args: ['fetch', '--store', store, '--source', 'de-by', '--squares', '690_5336', '--as', 'x'],
      message: /--as with --source de-by/,
    },
    {
      args: ['fetch', '--store', store, '--from', join(store, 'nowhere')],
      message: /read folder .*nowhere/,
    },
    { args: ['fetch', '--store', store, '--from', store], message: /holds no files of squares/ },
    {
      args: ['fetch', '--store', store, '--from', store, '--bbox', '0,0,1,1'],
      message: /a place with --from but without a grid/,
    },
  ];
  for (const { args, message } of cases) {
    await t.test(args.join(' '), async () => {
      const { code, out, err } = await cli(args);
      assert.match(err, message);
      assert.match(err, /^error: [^\n]*\n(\(Did you mean[^\n]*\n)?$/);
      assert.equal(code, 2);
      assert.equal(out, '');
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
  const attribution = ['attribution', '--store', store.root];
  const cases: { file: string; text: string; args: string[]; message: RegExp }[] = [
    {
      file: 'sources/worse.toml',
      text: 'id = "worse"',
      args: ['sources'],
      message: /field title is missing; allowed: text/,
    },
    { file: 'sources/worse.toml', text: '\n\nid = [', args: ['sources'], message: notTomlIn(3) },
    {
      file: 'sources/ortho/worse.toml',
      text: '\n\nid = [',
      args: ['ortho', '--source', 'worse', '--store', store.root],
      message: notTomlIn(3),
    },
    { file: 'areas/worse.toml', text: '\nid = "', args: ['areas'], message: notTomlIn(2) },
    {
      file: 'converters.toml',
      text: '= 1',
      args: ['convert', '--store', store.root],
      message: notTomlIn(1),
    },
    {
      file: 'licences.toml',
      text: '\n= 1',
      args: attribution,
      message: /read licences [^:]*: Invalid TOML document: [^:]* 2: [^:]*allowed: [^:]*$/,
    },
    { file: 'licences.toml', text: 'licence = 1', args: attribution, message: /read licences/ },
  ];
  for (const { file, text, args, message } of cases) {
    await t.test(`${file}: ${text}`, async (t) => {
      t.after(() => rm(join(folder, file)));
      await writeFile(join(folder, file), text);
      const { code, out, err } = await cli(['--config', folder, ...args]);
      assert.match(err, /^error: read [^\n]*\n$/);
      assert.ok(err.includes(file), err);
      assert.match(err, message);
      assert.deepEqual([code, out], [2, '']);
    });
  }
});

import assert from 'node:assert/strict';
import type { ChildProcess } from 'node:child_process';
import { mkdir, readFile, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test, type TestContext } from 'node:test';
import { readPackageInfo } from '../../grabber/src/util/package-info.js';
import { cli } from './support/cli.js';
import { sendFile, sendStatus, serve } from './support/http-fixture.js';
import { makeLas, makeLaz } from './support/las-fixture.js';
import { storedFiles, temporaryFolder } from './support/store-fixture.js';

const kLaz = makeLaz();

/** A sources folder with one source that is served by this machine. */
async function configFolder(t: TestContext, base: string): Promise<string> {
  const folder = await temporaryFolder(t);
  await mkdir(join(folder, 'sources'));
  const toml = `
id = "here"
title = "Here"
licence = "CC BY 4.0"
attribution = "Us"
crs = "EPSG:3794"
square_m = 1000
extent_m = [400000, 50000, 500000, 150000]
class_table = "asprs"
url = "${base}/TM_{E}_{N}.laz"
max_concurrent = 2
missing_status = [403]
`;
  await writeFile(join(folder, 'sources', 'here.toml'), toml);
  return folder;
}

test('help and version go to standard output with exit code 0', async () => {
  const help = await cli(['--help']);
  assert.equal(help.code, 0);
  for (const word of ['sources', 'list', 'fetch', 'Exit codes']) assert.ok(help.out.includes(word), word);
  const version = await cli(['--version']);
  assert.deepEqual(version, { code: 0, out: `${readPackageInfo().version}\n`, err: '' });
});

test('wrong usage ends with exit code 2 and one line that says what is allowed', async (t) => {
  const store = await temporaryFolder(t);
  const cases: { args: string[]; message: RegExp }[] = [
    { args: ['grab'], message: /unknown command 'grab'/ },
    { args: ['list', '--source', 'xx', '--squares', '1_1'], message: /choose source: "xx"; allowed: de-by, de-nw/ },
    { args: ['list', '--source', 'de-by'], message: /choose squares: none given; allowed: --squares/ },
    { args: ['list', '--source', 'de-by', '--squares', '690'], message: /"690"; allowed: E_N/ },
    {
      args: ['list', '--source', 'de-by', '--bbox', '1,2,3'],
      message: /--bbox.*'1,2,3' is invalid.*four numbers in metres/,
    },
    { args: ['list', '--source', 'de-by', '--bbox', '11,48,12,49'], message: /outside the source/ },
    {
      args: ['list', '--source', 'de-by', '--squares', '690_5336', '--bbox', '690000,5336000,691000,5337000'],
      message: /one of them/,
    },
    { args: ['list', '--source', 'de-by', '--squares', '690_5336', '--block', 'b_35'], message: /has no \{block\}/ },
    {
      args: ['list', '--source', 'si-lss', '--squares', '462_101'],
      message: /block .* is missing; allowed: --block with b_11 to b_37/,
    },
    {
      args: ['list', '--source', 'si-lss', '--squares', '462_101', '--block', 'b_99'],
      message: /set block: "b_99"; allowed: b_11 to b_37/,
    },
    { args: ['list', '--squares', '462_101'], message: /--source ID or --url-template URL/ },
    { args: ['list', '--url-template', 'http://h/a.laz', '--squares', '1_1'], message: /tells squares apart/ },
    {
      args: ['fetch', '--source', 'de-by', '--squares', '690_5336'],
      message: /required option '--store <folder>' not specified/,
    },
    {
      args: ['fetch', '--store', store, '--source', 'de-by', '--squares', '690_5336', '--concurrency', '0'],
      message: /'0' is invalid.*integer from 1 to 32/,
    },
    {
      args: ['fetch', '--store', store, '--source', 'de-by', '--squares', '690_5336', '--as', 'x'],
      message: /--as with --source de-by/,
    },
    { args: ['fetch', '--store', store, '--from', join(store, 'nowhere')], message: /read folder .*nowhere/ },
    { args: ['fetch', '--store', store, '--from', store], message: /holds no files of squares/ },
    {
      args: ['fetch', '--store', store, '--from', store, '--bbox', '0,0,1,1'],
      message: /--bbox with --from but without --source/,
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

test('sources and list print tables, and JSON where asked', async () => {
  const table = await cli(['sources']);
  assert.equal(table.code, 0);
  assert.match(table.out, /^id +crs/);
  assert.match(table.out, /\nsi-lss +EPSG:3794 +1000 m/);
  const json = JSON.parse((await cli(['sources', '--json'])).out) as { id: string }[];
  assert.ok(json.some((source) => source.id === 'nl-ahn'));

  const list = await cli(['list', '--source', 'si-lss', '--block', 'b_35', '--bbox', '462000,101000,463000.5,102000']);
  assert.equal(list.code, 0);
  assert.match(list.out, /^462_101\thttps:\/\/[^\n]*\/b_35\/D96TM\/TM_462_101\.laz\n463_101\t[^\n]*\n$/);
  const line = await cli(['list', '--url-template', 'http://h/{x:06}_{y}', '--squares', '85_446', '--json']);
  assert.deepEqual(JSON.parse(line.out), { source: 'adhoc', square: '85_446', url: 'http://h/085000_446000' });
});

test('a broken source file ends with exit code 1 and names the file', async (t) => {
  const folder = await configFolder(t, 'http://127.0.0.1:1');
  await writeFile(join(folder, 'sources', 'worse.toml'), 'id = "worse"');
  const { code, err } = await cli(['--config', folder, 'sources']);
  assert.equal(code, 1);
  assert.match(err, /^error: read source .*worse\.toml: field title is missing; allowed: text/);
});

test('fetch fills a store, and its exit code tells holes from failures', async (t) => {
  const server = await serve(t, (request, response) => {
    if (request.url === '/TM_463_101.laz') return sendStatus(response, 403);
    if (request.url === '/TM_464_101.laz') return sendStatus(response, 401);
    sendFile(response, kLaz);
  });
  const sources = await configFolder(t, server.base);
  const store = join(await temporaryFolder(t), 'new', 'store');
  const fetch = (squares: string, ...more: string[]) =>
    cli(['fetch', '--config', sources, '--source', 'here', '--squares', squares, '--store', store, ...more]);

  const good = await fetch('462_101');
  assert.equal(good.code, 0, good.err);
  assert.equal(good.err, '');
  assert.match(
    good.out,
    /^verified 462_101 +1\.\d kB +10 points +lidar\/here\/462_101\.laz\n1 fetched, 0 already there, 0 missing, 0 failed/,
  );
  assert.equal(server.seen[0]?.headers['user-agent'], `terravox-grabber/${readPackageInfo().version}`);

  const holes = await fetch('462_101,463_101');
  assert.equal(holes.code, 3);
  assert.equal(holes.err, 'hole: here has no square 463_101 (HTTP 403)\n');
  assert.match(holes.out, /kept 462_101/);

  const failed = await fetch('462_101,463_101,464_101', '--json');
  assert.equal(failed.code, 1);
  assert.equal(failed.err, '');
  const lines = failed.out
    .trimEnd()
    .split('\n')
    .map((line) => JSON.parse(line) as Record<string, unknown>);
  assert.deepEqual(lines.map((line) => line['state'] ?? line['event']).sort(), [
    'failed',
    'kept',
    'missing',
    'summary',
  ]);
  const summary = lines.find((line) => line['event'] === 'summary');
  assert.deepEqual([summary?.['verified'], summary?.['kept'], summary?.['missing'], summary?.['failed']], [0, 1, 1, 1]);

  assert.deepEqual(await storedFiles(store), ['lidar/here/462_101.laz']);
  const manifest = JSON.parse(await readFile(join(store, 'manifest.json'), 'utf8')) as {
    version: number;
    squares: { square: string; state: string; licence: string }[];
  };
  assert.equal(manifest.version, 1);
  assert.deepEqual(
    manifest.squares.map(({ square, state, licence }) => [square, state, licence]),
    [
      ['462_101', 'verified', 'CC BY 4.0'],
      ['463_101', 'missing', 'CC BY 4.0'],
      ['464_101', 'failed', 'CC BY 4.0'],
    ],
  );
});

test('fetch takes an address typed by the user', async (t) => {
  const server = await serve(t, (_request, response) => sendFile(response, kLaz));
  const store = await temporaryFolder(t);
  const { code, err } = await cli([
    'fetch',
    '--url-template',
    `${server.base}/{name}.laz`,
    '--squares',
    'castle',
    '--as',
    'mine',
    '--licence',
    'CC0',
    '--store',
    store,
  ]);
  assert.equal(code, 0, err);
  assert.equal(server.seen[0]?.path, '/castle.laz');
  assert.deepEqual(await storedFiles(store), ['lidar/mine/castle.laz']);
});

test('fetch copies a local folder, and says which files it could not use', async (t) => {
  const folder = await temporaryFolder(t);
  await mkdir(join(folder, 'b_35'));
  await writeFile(join(folder, 'b_35', 'TM_462_101.laz'), kLaz);
  await writeFile(join(folder, 'b_35', 'TM_462_101.zlas'), 'old');
  await writeFile(join(folder, 'TM_463_101.las'), makeLas({ min: [463_000, 101_000, 0], max: [464_000, 102_000, 1] }));
  await writeFile(join(folder, 'notes.laz'), kLaz);
  await writeFile(join(folder, 'TM_464_101.zlas'), 'zlas');
  const sources = await configFolder(t, 'http://127.0.0.1:1');
  const store = await temporaryFolder(t);
  const args = ['fetch', '--config', sources, '--source', 'here', '--from', folder, '--store', store];

  const all = await cli(args);
  assert.equal(all.code, 1);
  assert.match(all.err, /warning: ignored .*notes\.laz: not a file name of source here/);
  assert.match(
    all.err,
    /error: 464_101 ZLAS_UNSUPPORTED: .*needs a converter, and none is built in; allowed: LAZ or LAS/,
  );
  assert.match(all.out, /2 fetched, 0 already there, 0 missing, 1 failed, 1 files ignored/);
  assert.deepEqual(await storedFiles(store), ['lidar/here/462_101.laz', 'lidar/here/463_101.las']);

  const some = await cli([...args, '--bbox', '462000,101000,463000,103000']);
  assert.equal(some.code, 3);
  assert.match(some.err, /\nhole: here has no square 462_102 \(no such file in the folder\)\n$/);

  const names = await cli(['fetch', '--from', folder, '--store', store, '--squares', 'notes']);
  assert.equal(names.code, 0, names.err);
  assert.ok((await storedFiles(store)).includes('lidar/local/notes.laz'));
});

test('two files that claim one square are an error, not a guess', async (t) => {
  const folder = await temporaryFolder(t);
  await mkdir(join(folder, 'copy'));
  await writeFile(join(folder, 'a.laz'), kLaz);
  await writeFile(join(folder, 'copy', 'a.laz'), kLaz);
  const { code, err } = await cli(['fetch', '--from', folder, '--store', await temporaryFolder(t)]);
  assert.equal(code, 1);
  assert.match(err, /AMBIGUOUS_FILE: copy square a: .* both claim it; allowed: one file/);
});

test(
  'SIGINT stops a fetch cleanly and the next run continues it',
  { skip: process.platform === 'win32' && 'no signals there' },
  async (t) => {
    const body = makeLaz({ dataBytes: 100_000 });
    let child: ChildProcess | undefined;
    let stopping = true;
    const server = await serve(t, (request, response) => {
      if (request.url !== '/TM_463_101.laz' || !stopping) return sendFile(response, body);
      response.writeHead(200, { 'content-length': String(body.length), etag: '"v1"' });
      response.write(body.subarray(0, 50_000), () => child?.kill('SIGINT'));
    });
    const sources = await configFolder(t, server.base);
    const store = await temporaryFolder(t);
    const args = [
      'fetch',
      '--config',
      sources,
      '--source',
      'here',
      '--squares',
      '462_101,463_101,464_101',
      '--concurrency',
      '1',
      '--store',
      store,
    ];

    const stopped = await cli(args, (started) => (child = started));
    assert.equal(stopped.code, 130);
    assert.equal(stopped.err, 'error: stopped by SIGINT\n');
    const files = await storedFiles(store);
    assert.deepEqual(
      files.filter((file) => !file.includes('.part')),
      ['lidar/here/462_101.laz'],
      'no lock and no unfinished file is left',
    );

    stopping = false;
    const next = await cli(args);
    assert.equal(next.code, 0, next.err);
    assert.match(next.out, /2 fetched, 1 already there/);
  },
);

import assert from 'node:assert/strict';
import { join } from 'node:path';
import { test } from 'node:test';
import { openStore } from '../../../grabber/src/store/open-store.js';
import { readPackageInfo } from '../../../grabber/src/util/package-info.js';
import { cli, program, words, configFolder, templateAccess } from '../support/cli.js';
import { sendFile, sendStatus, serve } from '../support/http-fixture.js';
import { makeLaz } from '../support/las-fixture.js';
import { kNever, storedFiles, temporaryFolder } from '../support/store-fixture.js';

const kLaz = makeLaz();

test('fetch fills a store, and its exit code separates holes from failures', async (t) => {
  const server = await serve(t, (request, response) => {
    if (request.url === '/TM_463_101.laz') return sendStatus(response, 403);
    if (request.url === '/TM_464_101.laz') return sendStatus(response, 401);
    sendFile(response, kLaz);
  });
  const sources = await configFolder(t, templateAccess(server.base));
  const store = join(await temporaryFolder(t), 'new', 'store');
  const line = words`fetch --config ${sources} --source here --store ${store}`;
  const fetch = (squares: string, ...more: string[]) =>
    cli([...line, '--squares', squares, ...more]);

  const good = await program([...line, '--squares', '462_101']);
  assert.equal(good.code, 0, good.err);
  assert.equal(good.err, '');
  assert.match(
    good.out,
    new RegExp(
      String.raw`^verified 462_101 +1\.\d kB +10 points +lidar\/here\/462_101\.laz\n1 ` +
        String.raw`fetched, 0 already there, 0 missing, 0 failed, 1\.\d kB`,
    ),
  );
  assert.equal(
    server.seen[0]?.headers['user-agent'],
    `terravox-grabber/${readPackageInfo().version}`,
  );

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
    'begin',
    'failed',
    'kept',
    'plan',
    'summary',
  ]);
  const counts = lines.find((line) => line['event'] === 'summary') ?? {};
  assert.deepEqual(
    ['verified', 'kept', 'missing', 'known_missing', 'failed'].map((name) => counts[name]),
    [0, 1, 0, 1, 1],
  );

  assert.equal(
    server.seen.filter(({ path }) => path === '/TM_463_101.laz').length,
    1,
    'a hole is remembered',
  );
  const known = await fetch('462_101,463_101');
  assert.equal(known.code, 3);
  assert.match(
    known.out,
    /0 missing, 1 known to be missing \(--refetch requests them again\), 0 failed/,
  );
  assert.match((await fetch('463_101', '--refetch')).err, /^hole: here has no square 463_101/);

  assert.deepEqual(await storedFiles(store), ['lidar/here/462_101.laz']);
  const opened = openStore(store, { readOnly: true }, kNever);
  assert.deepEqual(
    opened.squares.list({}).map(({ key, state, licence }) => [key.name, state, licence]),
    [
      ['462_101', 'verified', 'CC BY 4.0'],
      ['463_101', 'missing', 'CC BY 4.0'],
      ['464_101', 'failed', 'CC BY 4.0'],
    ],
  );
  opened.close();
});

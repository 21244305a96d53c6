import assert from 'node:assert/strict';
import { mkdir, readFile, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { PassThrough } from 'node:stream';
import { test, type TestContext } from 'node:test';
import { outputTo } from '../../../grabber/src/cli/context.js';
import { barReporter, type Outcome } from '../../../grabber/src/progress/reporter.js';
import { openStore } from '../../../grabber/src/store/open-store.js';
import { DatabaseSync } from '../../../grabber/src/store/sqlite.js';
import { cli, words, configFolder, templateAccess } from '../support/cli.js';
import { makeLaz } from '../support/las-fixture.js';
import { toKey, kNever, makeSquare, temporaryFolder } from '../support/store-fixture.js';

/** Sets a colour, clears the screen, forges a line, reorders what follows. */
const kHostile = 'x\u001b[31m\u009b2J\nerror: forged\u202egnol';
const kShown = 'x\\u001b[31m\\u009b2J\\u000aerror: forged\\u202egnol';

function assertHarmless(text: string): void {
  assert.doesNotMatch(text, /(?!\n)[\p{Cc}\u202e]/u);
  assert.doesNotMatch(text, /^error: forged/m);
}

/** A store that someone else has made: names and messages in it are theirs. */
async function hostileStore(t: TestContext): Promise<string> {
  const root = await temporaryFolder(t);
  const store = openStore(root, {}, kNever);
  try {
    const terms = { crs: 'EPSG:3794', classTable: null, licence: null, attribution: kHostile };
    const key = toKey('462_101');
    const square = makeSquare('462_101', [`http://x/${kHostile}`], { block: kHostile });
    store.squares.learn(key.source, key.grid, 'EPSG:3794', terms, [square]);
    store.squares.want([key]);
    store.squares.begin(key, 'http://x/a.laz');
    store.squares.failed(key, 'NETWORK', '');
  } finally {
    store.close();
  }
  // This program stores messages folded.
  const file = new DatabaseSync(join(root, 'fishnet.gpkg'));
  try {
    file.prepare('UPDATE squares SET error_message = ?').run(kHostile);
  } finally {
    file.close();
  }
  return root;
}

test('texts of a store reach the terminal without control characters', async (t) => {
  const store = await hostileStore(t);
  for (const args of [['status'], ['fishnet', 'list']]) {
    await t.test(args.join(' '), async () => {
      const { code, out, err } = await cli([...args, ...words`--store ${store}`]);
      assert.equal(code, 0, err);
      assert.ok(out.includes(kShown), out);
      assertHarmless(out + err);
      const json = await cli([...args, ...words`--store ${store} --json`]);
      assertHarmless(json.out);
      assert.ok(
        JSON.stringify(JSON.parse(json.out)).includes(JSON.stringify(kHostile).slice(1, -1)),
      );
    });
  }
});

test('names of files reach the terminal without control characters', async (t) => {
  const config = await configFolder(t, templateAccess('http://127.0.0.1:1'));
  const folder = await temporaryFolder(t);
  await writeFile(join(folder, 'TM_462_101.laz'), makeLaz());
  const file = `${kHostile.replace('\n', '')}.laz`;
  await writeFile(join(folder, file), makeLaz());
  const store = await temporaryFolder(t);
  const fetched = await cli(
    words`--config ${config} fetch --from ${folder} --source here --store ${store}`,
  );
  assert.ok(fetched.err.includes(kShown.replace('\\u000a', '')), fetched.err);
  assertHarmless(fetched.out + fetched.err);

  await mkdir(join(store, 'lidar', 'here'), { recursive: true });
  await writeFile(join(store, 'lidar', 'here', `${kHostile}.laz`), '');
  const cleaned = await cli(words`gc --store ${store} --dry-run`);
  assert.ok((cleaned.out + cleaned.err).includes(kShown), cleaned.out + cleaned.err);
  assertHarmless(cleaned.out + cleaned.err);
});

test('titles of sources reach the terminal without control characters', async (t) => {
  const config = await configFolder(t, templateAccess('http://127.0.0.1:1'));
  const text = 'title = "\\u001b[31m\\u202eereH"';
  const file = join(config, 'sources', 'here.toml');
  await writeFile(file, (await readFile(file, 'utf8')).replace('title = "Here"', text));
  const { code, out, err } = await cli(words`--config ${config} sources`);
  assert.equal(code, 0, err);
  assert.ok(out.includes('\\u001b[31m\\u202eereH'), out);
  assertHarmless(out);
});

test('lines and names among the bars of a terminal hold no control characters of others', () => {
  const stream = Object.assign(new PassThrough(), { isTTY: true, columns: 200, rows: 50 });
  const streams = { out: () => undefined, err: () => undefined };
  const reporter = barReporter(outputTo(streams), stream);
  const key = toKey(kHostile);
  const other = toKey('462_101');
  const missing: Outcome = { state: 'missing', key: other, url: null, reason: kHostile };
  reporter.bytes(key, 1, 1, 10);
  reporter.ignored(kHostile, 'here');
  reporter.outcome(missing);
  reporter.close();
  const shown = String(stream.read());
  assert.ok(shown.includes(`warning: ignored ${kShown}`), shown);
  assert.ok(shown.includes(`hole: ${kShown}`), shown);
  assert.ok(shown.includes(`${kShown} [==`), shown);
  for (const harm of ['\u001b[31m', '\u009b', '\u202e']) assert.ok(!shown.includes(harm), shown);
  assert.doesNotMatch(shown, /^error: forged/m);
});

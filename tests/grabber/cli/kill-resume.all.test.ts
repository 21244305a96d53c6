import assert from 'node:assert/strict';
import { mkdir, readFile, stat, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { kUsable, type State } from '../../../grabber/src/model/store.js';
import { openStore } from '../../../grabber/src/store/open-store.js';
import { parseFaults, type FileStats } from '../portal/faults.js';
import { startPortal, type Portal } from '../portal/portal.js';
import { seededRandom } from '../portal/pattern.js';
import { program, words, type CliResult } from '../support/cli.js';
import { makeLaz } from '../support/las-fixture.js';
import { computeSha256 } from '../support/record-fixture.js';
import { kNever, temporaryFolder } from '../support/store-fixture.js';

/** The whole measure takes minutes; the short one is the same with less of everything. */
const kLong = process.env['TERRAVOX_LONG'] === '1';
const [kSquares, kKills, kLargest_bytes] = kLong ? [1000, 20, 4_000_000] : [150, 5, 1_500_000];
const kConcurrency = 4;
/**
 * Bytes a second of each body; a server on this machine is otherwise far ahead of its clients.
 */
const kRate = process.env['TERRAVOX_RATE'];
const kSeed = Number(process.env['TERRAVOX_SEED'] ?? 11);

async function makeSurvey(root: string, random: () => number): Promise<string[]> {
  const names: string[] = [];
  await mkdir(join(root, 'laz'));
  for (let index = 0; index < kSquares; ++index) {
    const [east, north] = [400 + (index % 50), 100 + Math.floor(index / 50)];
    const [x, y] = [east * 1000, north * 1000];
    // Most squares are small, some are large: both ends of what can be lost by a kill.
    const dataBytes = Math.floor(20_000 + kLargest_bytes * random() ** 4);
    names.push(`${east}_${north}`);
    await writeFile(
      join(root, 'laz', `TM_${east}_${north}.laz`),
      makeLaz({ dataBytes, min: [x, y, 200], max: [x + 999, y + 999, 200 + index] }),
    );
  }
  return names;
}

/**
 * Runs the grabber; with `killAt`, until so many squares are reported verified, and a bit longer.
 */
function fetchSome(
  portal: Portal,
  store: string,
  names: readonly string[],
  killAt: number | undefined,
  random: () => number,
): Promise<CliResult> {
  const line = words`fetch --url-template ${portal.base}/laz/TM_{E}_{N}.laz --allow-private
    --squares ${names.join(',')} --store ${store} --concurrency ${String(kConcurrency)}
    --retries 12`;
  return program(line, (child) => {
    let seen = 0;
    child.stdout?.on('data', (text: string) => {
      seen += text.split('\n').filter((line) => line.startsWith('verified')).length;
      if (killAt !== undefined && seen >= killAt) {
        setTimeout(() => child.kill('SIGKILL'), random() * 60);
      }
    });
  });
}

function namesIn(store: string, states: readonly State[]): string[] {
  const open = openStore(store, { readOnly: true }, kNever);
  try {
    return open.squares.list({ states }).map(({ key }) => key.name);
  } finally {
    open.close();
  }
}

/** Squares of which a byte or more has come to the disk. */
async function begunNames(store: string, names: readonly string[]): Promise<string[]> {
  const recorded = new Set(namesIn(store, [...kUsable, 'fetched']));
  const begun: string[] = [];
  for (const name of names) {
    const part = await stat(join(store, 'lidar/adhoc', `.${name}.part`)).catch(() => undefined);
    if (recorded.has(name) || (part?.size ?? 0) > 0) begun.push(name);
  }
  return begun;
}

test(`after 10 % faults and ${kKills} kills ${kSquares} squares are verified`, async (t) => {
  t.diagnostic(`seed ${kSeed} (TERRAVOX_SEED)`);
  const random = seededRandom(kSeed);
  const root = await temporaryFolder(t);
  const store = await temporaryFolder(t);
  const names = await makeSurvey(root, random);
  const portal = await startPortal({
    root,
    faults: parseFaults('transient=0.1'),
    seed: kSeed,
    ...(kRate === undefined ? {} : { rate_bytes_per_s: Number(kRate) }),
  });
  t.after(() => portal.close());

  const findStats = (name: string): FileStats => portal.context.stats.of(`/laz/TM_${name}.laz`);

  const sentWhenVerified = new Map<string, number>();
  const wholeWhenBegun = new Map<string, number>();
  let kills = 0;
  for (; kills < kKills; ++kills) {
    const { code, err } = await fetchSome(
      portal,
      store,
      names,
      Math.floor(kSquares / (kKills + 1)),
      random,
    );
    // Where this process reads the lines late, the last squares may be there before the kill.
    if (code === 0) break;
    assert.equal(code, null, `ended by the kill, or with all squares: ${err}`);
    // The server notices later that the connection is gone.
    await portal.idle();
    for (const name of namesIn(store, kUsable)) {
      if (!sentWhenVerified.has(name)) sentWhenVerified.set(name, findStats(name).bytes);
    }
    for (const name of await begunNames(store, names)) {
      if (!wholeWhenBegun.has(name)) wholeWhenBegun.set(name, findStats(name).whole);
    }
  }
  assert.ok(kills > 0, 'at least one kill came before the end');
  const last = await fetchSome(portal, store, names, undefined, random);
  assert.equal(last.code, 0, last.err);

  assert.deepEqual(namesIn(store, kUsable).sort(), [...names].sort());
  const open = openStore(store, { readOnly: true }, kNever);
  for (const name of names) {
    const [there, here] = await Promise.all([
      readFile(join(root, 'laz', `TM_${name}.laz`)),
      readFile(join(store, 'lidar/adhoc', `${name}.laz`)),
    ]);
    assert.ok(there.equals(here), `bytes of ${name}`);
    const record = open.squares.get({ source: 'adhoc', grid: 'adhoc', name });
    assert.equal(record?.file?.sha256, computeSha256(here));
  }
  open.close();
  for (const [name, sent] of sentWhenVerified) {
    assert.equal(findStats(name).bytes, sent, `${name} was verified before a kill and sent again`);
  }

  // A fault may be that the rest of a file cannot be fetched.
  const again = [...wholeWhenBegun]
    .filter(([name, whole]) => findStats(name).faults === 0 && findStats(name).whole > whole)
    .map(([name]) => name);
  assert.deepEqual(again, [], 'begun before a kill, and then sent whole');
  // Bytes that the server has sent, but the process has not read when it dies, are sent again: up
  // to a file for each connection.
  const stats = Object.values(portal.context.stats.toJSON());
  const twice = stats.filter(({ whole }) => whole > 1).length;
  const sent = stats.reduce((sum, file) => sum + file.bytes, 0);
  const faults = stats.reduce((sum, file) => sum + file.faults, 0);
  t.diagnostic(`${faults} faults, ${kills} kills, ${twice} files sent whole twice, ${sent} bytes`);
  assert.ok(
    twice <= kKills * kConcurrency + stats.filter((file) => file.faults > 0).length,
    `${twice} files were sent whole twice`,
  );
  assert.ok(faults > 0);
});

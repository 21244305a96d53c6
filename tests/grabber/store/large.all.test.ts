import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { CatalogueSquare } from '../../../grabber/src/model/store.js';
import { openStore } from '../../../grabber/src/store/open-store.js';
import { program, words } from '../support/cli.js';
import { catalogueSquare, kTerms, keyOfSquare } from '../support/record-fixture.js';
import { kNever, temporaryFolder } from '../support/store-fixture.js';

const kSquares = 20_000;

function* country(): Generator<CatalogueSquare> {
  for (let index = 0; index < kSquares; ++index) {
    yield catalogueSquare(374 + (index % 200), 26 + Math.floor(index / 200));
  }
}

test('a country of 20,000 squares is learnt, wanted and listed', async (t) => {
  const root = await temporaryFolder(t);
  const store = openStore(root, {}, kNever);
  const times: string[] = [];
  const timed = <T>(what: string, work: () => T): T => {
    const before = process.cpuUsage();
    const result = work();
    times.push(`${what} ${(process.cpuUsage(before).user / 1000).toFixed(0)} ms`);
    return result;
  };
  const learn = (): unknown =>
    store.squares.learn('si-lss', 'si-lss', 'EPSG:3794', kTerms, country());
  assert.deepEqual(timed('learn', learn), { added: kSquares, changed: 0 });
  assert.deepEqual(timed('learn again', learn), { added: 0, changed: 0 });
  const half = [...country()]
    .filter((_square, index) => index % 2 === 0)
    .map(({ name }) => keyOfSquare(name));
  assert.equal(
    timed('want half', () => store.squares.want(half)),
    kSquares / 2,
  );
  assert.equal(timed('unfinished', () => store.squares.unfinished({})).length, kSquares / 2);
  assert.equal(timed('list', () => store.squares.list({})).length, kSquares);
  assert.deepEqual(
    timed('tally', () => store.squares.tally()).map(({ state, count }) => [state, count]),
    [
      ['known', kSquares / 2],
      ['wanted', kSquares / 2],
    ],
  );
  t.diagnostic(
    `user time: ${times.join(', ')}; ${(process.memoryUsage.rss() / 1e6).toFixed(0)} MB resident`,
  );
  // While this process has it open for writing:
  const status = await program(words`status --store ${root}`);
  assert.deepEqual([status.code, status.err], [0, '']);
  assert.match(
    status.out,
    new RegExp(
      String.raw`^squares +state +count +size +points\nsi-lss +known +10000 +- +-\nsi-lss` +
        String.raw` +wanted +10000 +- +-\n\nsi-lss\nw+\n`,
    ),
  );
  assert.ok(
    status.out.split('\n').every((line) => line.length < 80),
    status.out,
  );
  store.close();
});

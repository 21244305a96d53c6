import assert from 'node:assert/strict';
import { test } from 'node:test';
import { regionOfBox, regionOfSquares } from '../../../../grabber/src/select/region.js';
import { squareAt } from '../../../../grabber/src/sources/square.js';
import { makeCatalogue, found, sourceWith } from '../../support/catalogue-fixture.js';
import { kNever } from '../../support/store-fixture.js';

const kProbed = `
[access]
kind = "template"
urls = ["https://example.org/a/{block}/{E}_{N}.laz", "https://example.org/b/{block}/{E}_{N}.zlas"]
[access.variables.block]
about = "block"
pattern = "b_[0-9]+"
allowed = "b_1 to b_4"
values = ["b_1", "b_2", "b_3", "b_4"]
`;
const kOne = regionOfSquares([squareAt(462_000, 101_000)], 1000);

test('a computed grid gives the squares of a region from south to north, each once', async (t) => {
  const catalogue = makeCatalogue(t, sourceWith(kProbed), { variables: { block: 'b_2' } });
  const squares = await found(catalogue, regionOfBox([462_000, 101_000, 464_000, 103_000.5]));
  assert.deepEqual(
    squares.map(({ name }) => name),
    ['462_101', '463_101', '462_102', '463_102', '462_103', '463_103'],
  );
  assert.deepEqual(squares[1], {
    name: '463_101',
    block: 'b_2',
    bounds: [463_000, 101_000, 464_000, 102_000],
    urls: ['https://example.org/a/b_2/463_101.laz', 'https://example.org/b/b_2/463_101.zlas'],
    bytes: null,
    sha256: null,
    member: null,
    published: null,
  });
  assert.equal(catalogue.locate, undefined, 'nothing is left to find');
});

test('a grid ends where its source ends, and a country is too much for one run', async (t) => {
  const catalogue = makeCatalogue(t, sourceWith(kProbed), { maxSquares: 100 });
  const corner = await found(catalogue, regionOfBox([0, 0, 371_000, 26_000]));
  assert.deepEqual(
    corner.map(({ name }) => name),
    ['370_25'],
  );
  await assert.rejects(found(catalogue, regionOfBox([400_000, 50_000, 411_000, 60_000])), {
    code: 'CATALOGUE',
    message: /more than 100 squares; allowed: at most 100 a run/,
  });
});

test('a block that was not given is found by trying, neighbours first', async (t) => {
  const first = 'a/b_1 a/b_2 a/b_3 a/b_4';
  const all = `${first} b/b_1 b/b_2 b/b_3 b/b_4`;
  type Case = [
    name: string,
    there: string,
    near: string[],
    block: string | undefined,
    requested: string,
  ];
  const cases: Case[] = [
    ['in the block of a neighbour', 'a/b_3', ['b_3', 'b_2', 'b_3'], 'b_3', 'a/b_3'],
    ['the lesser address of a neighbour', 'b/b_3', ['b_3'], 'b_3', 'a/b_3 b/b_3'],
    ['elsewhere', 'a/b_2', ['b_3'], 'b_2', 'a/b_3 b/b_3 a/b_1 a/b_2'],
    ['without neighbours', 'b/b_1', [], 'b_1', `${first} b/b_1`],
    ['a block that the source lacks', 'a/b_9 a/b_4', ['b_9'], 'b_4', first],
    ['nowhere', '', [], undefined, all],
  ];
  for (const [name, there, near, block, requested] of cases) {
    await t.test(name, async (t) => {
      const catalogue = makeCatalogue(t, sourceWith(kProbed));
      const [square] = await found(catalogue, kOne);
      assert.ok(square);
      assert.deepEqual([square.block, square.urls], [null, []]);
      const seen: string[] = [];
      const located = await catalogue.locate?.(
        square,
        near,
        (url) => {
          const part = url.split('/').slice(3, 5).join('/');
          seen.push(part);
          return Promise.resolve(there.split(' ').includes(part));
        },
        kNever,
      );
      assert.equal(located?.block, block);
      assert.equal(seen.join(' '), requested);
      if (located !== undefined) {
        assert.equal(located.urls.length, 2);
        assert.ok(
          located.urls[0]?.includes(requested.split(' ').at(-1) ?? '?'),
          'the address that answered comes first',
        );
      }
    });
  }
});

test('a failure while trying a block does not count as "not there"', async (t) => {
  const catalogue = makeCatalogue(t, sourceWith(kProbed));
  const [square] = await found(catalogue, kOne);
  assert.ok(square);
  const there = (): Promise<boolean> => Promise.reject(new Error('the network is down'));
  await assert.rejects(
    catalogue.locate?.(square, [], there, kNever) ?? Promise.resolve(),
    /the network is down/,
  );
});

test('variables are given, fixed, found, or reported as missing', async (t) => {
  const access = (line: string): string => kProbed.replace(/values = .*/, line);
  const fixed = await found(makeCatalogue(t, sourceWith(access('value = "b_7"'))), kOne);
  assert.equal(fixed[0]?.urls[0], 'https://example.org/a/b_7/462_101.laz');
  const given = await found(
    makeCatalogue(t, sourceWith(access('value = "b_7"')), { variables: { block: 'b_8' } }),
    kOne,
  );
  assert.equal(given[0]?.urls[0], 'https://example.org/a/b_8/462_101.laz');
  const cases: [line: string, variables: Record<string, string>, message: RegExp][] = [
    ['', {}, /of here: block \(block\) is missing; allowed: --block with b_1 to b_4/],
    ['', { block: 'x' }, /set block: "x"; allowed: b_1 to b_4/],
    ['', { block: 'b_1', blok: 'b_2' }, /set blok: source here has no \{blok\}; allowed: block/],
  ];
  for (const [line, variables, message] of cases) {
    assert.throws(() => makeCatalogue(t, sourceWith(access(line)), { variables }), {
      code: 'USAGE',
      message,
    });
  }
});

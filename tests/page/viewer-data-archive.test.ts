import assert from 'node:assert/strict';
import { test } from 'node:test';
import { ArchiveSource } from '../../voxelserver/serve/page/src/viewer/data/archive-source.js';
import { readBoxArrays } from '../../voxelserver/serve/page/src/viewer/data/box-arrays.js';
import { DataError, type DataErrorKind } from '../../voxelserver/serve/page/src/http/errors.js';
import { readFacts } from '../../voxelserver/serve/page/src/viewer/data/facts.js';
import type { Column } from '../../voxelserver/serve/page/src/viewer/data/columns.js';
import { toName } from './support/columns.js';
import { kOpen } from './support/fake-host.js';
import { fullBoxFrame } from './support/full-box.js';
import { catchKind, kindOfAsync } from './support/data-errors.js';
import {
  boxBytes,
  kFacts,
  makeArchive,
  zstdBlock,
  zstdFrame,
  makeZstdFrame,
  type ArchiveOptions,
  type Key,
  type RawEntry,
  type RawLeaf,
  type TestBox,
} from './support/make-archive.js';
import { toBytes, makeRandom, skewed } from './support/test-bytes.js';
import {
  kVoxels,
  kBoxes,
  kColumns,
  makeHost,
  archiveHost,
  collect,
  readColumns,
  makeRow,
} from './support/small-archive.js';

test('an archive gives every box that it holds, its holes, and air for all else', async () => {
  for (const entriesPerLeaf of [1024, 2, 1]) {
    const host = archiveHost({ entriesPerLeaf, header: { damage: 3 } });
    const { facts } = await host.open();
    assert.equal(facts.world.title, 'small');
    assert.equal(facts.damage, 3);
    const found = await readColumns(host);
    assert.equal(found.size, new Set(kColumns.map(toName)).size);
    const column = found.get('0/0/0') as Column;
    assert.equal(column.byBegin, -1);
    const expected = kBoxes
      .slice(0, 2)
      .map(({ key: [level, bx, by, bz], voxels }) =>
        readBoxArrays(boxBytes([level, bx, by, bz], voxels!), { level, bx, by, bz }),
      );
    assert.deepEqual(column.boxes, expected.reverse());
    assert.deepEqual(found.get('0/1/1'), {
      ...{ level: 0, bx: 1, bz: 1, byBegin: 0 },
      boxes: ['hole'],
    });
    const air = found.get('0/1/0');
    assert.deepEqual(air, { level: 0, bx: 1, bz: 0, byBegin: 0, boxes: [] });
    const full = [...found.values()].filter((c) => !(c instanceof DataError) && c.boxes.length > 0);
    assert.equal(full.length, 5);
    const outside = await readColumns(host, [
      { level: 0, bx: 77, bz: 0 },
      { level: 3, bx: 0, bz: 0 },
    ]);
    assert.deepEqual((outside.get('0/77/0') as Column).boxes, []);
    assert.equal((outside.get('3/0/0') as DataError).kind, 'missing');
  }
});

test('an archive of ten million boxes opens with two requests and less than a MiB', async () => {
  const side = 4096;
  const oddBits = (number: number): number =>
    [...Array(12).keys()].reduce((sum, bit) => sum | (((number >> (2 * bit)) & 1) << bit), 0);
  const leaves = Array.from({ length: 9766 }, (_, leaf): RawLeaf => {
    const place = leaf * 1024;
    const first: Key = [0, oddBits(place), 0, oddBits(place >> 1)];
    return { first, offset: 20_000, bytes: 16_384, entries: 1024 };
  });
  const host = archiveHost({
    facts: { bounds: { min: [0, 0, 0], max: [64 * side, 256, 64 * side] }, levels: 13 },
    gapBytes: 20_000,
    changeLeaves: () => leaves,
  });
  const archive = await host.open();
  assert.equal(archive.facts.world.levels, 13);
  assert.equal(host.asked.length, 2);
  const bytes = host.asked.map(({ init }) => {
    const [, from, to] = /bytes=(\d+)-(\d+)/.exec(new Headers(init.headers).get('Range')!)!;
    return Number(to) - Number(from) + 1;
  });
  assert.ok(bytes[0]! + bytes[1]! < 1024 * 1024, String(bytes));
});

test('a small archive opens with one request, a larger one with two', async () => {
  const small = archiveHost();
  await small.open();
  assert.equal(small.asked.length, 1);
  // Boxes of 21 KiB: the last ones, and all leaves, lie in the 64 KiB before the root.
  const host = archiveHost({ gapBytes: 20_000, entriesPerLeaf: 3 });
  const source = new ArchiveSource(await host.open(), host.clock);
  assert.equal(host.asked.length, 2);
  await collect(host, source, [{ level: 2, bx: 0, bz: 0 }]);
  assert.equal(host.asked.length, 2);
});

test('boxes between those that were wanted take no further request', async () => {
  const { facts, boxes } = makeRow(32, 6);
  const host = archiveHost({ facts, gapBytes: 20_000 }, boxes);
  const source = new ArchiveSource(await host.open(), host.clock);
  const before = host.asked.length;
  const ends = [2, 4].map((bx) => ({ level: 0, bx, bz: 0 }));
  await collect(host, source, ends);
  assert.equal(host.asked.length, before + 1);
  const middle = { level: 0, bx: 3, bz: 0 };
  const found = await collect(host, source, [middle]);
  assert.equal((found.get('0/3/0') as Column).boxes.length, 1);
  assert.equal(host.asked.length, before + 1);
  // It is no reason for a request, so anything may come with it, and it with anything.
  const [first, far] = [0, 20].map((bx) => ({ level: 0, bx, bz: 0 }));
  assert.deepEqual(source.companions(first!, [far!, middle]), [middle]);
});

test('leaves that lie close to each other share a request', async () => {
  const { facts, boxes } = makeRow(32, 6);
  const columns = boxes.map(({ key }) => ({ level: 0, bx: key[1], bz: 0 }));
  const others = [...columns, { level: 77, bx: 0, bz: 0 }];
  const known = async (leafGapBytes: number): Promise<[requests: number, columns: number]> => {
    const host = archiveHost({ facts, entriesPerLeaf: 1, leafGapBytes }, boxes);
    const archive = await host.open();
    const before = host.asked.length;
    await host.clock.finish(archive.prepare(columns[5]!, others, kOpen));
    const loaded = columns.filter((column) => archive.knownColumn(column)?.length === 1);
    return [host.asked.length - before, loaded.length];
  };
  assert.deepEqual(await known(0), [0, 32]);
  // Some lie in what opening reads, the others in one request.
  assert.deepEqual(await known(20_000), [1, 32]);
  // Too far from each other: its own, and the first, which opening reads.
  assert.deepEqual(await known(70_000), [1, 2]);
});

test('of a column that has failed nothing more is fetched', async () => {
  const tall = { bounds: { min: [-128, 0, -128], max: [128, 256 * 20, 128] } };
  const boxes = Array.from({ length: 5 }, (_, by) => {
    const key: Key = [0, 0, by, 0];
    return by === 1 ? { key, frame: toBytes(1, 2, 3) } : { key, voxels: kVoxels };
  });
  const host = archiveHost({ facts: tall, gapBytes: 70_000 }, boxes);
  const source = new ArchiveSource(await host.open(), host.clock);
  await host.clock.finish(source.prepare({ level: 0, bx: 0, bz: 0 }, [], kOpen));
  const before = host.asked.length;
  const found = await collect(host, source, [{ level: 0, bx: 0, bz: 0 }]);
  assert.equal((found.get('0/0/0') as DataError).kind, 'damaged');
  // The lowest lies in what opening reads, the second is damaged, and two are left.
  assert.equal(host.asked.length, before + 1);
});

test('an archive with a changed byte gives the same columns or errors', async () => {
  const whole = makeArchive(kBoxes, { entriesPerLeaf: 3 });
  const good = await readColumns(makeHost(whole));
  const random = makeRandom(5);
  let [refused, tried] = [0, 0];
  // Each byte of the header, then every third.
  for (let at = 0; at < whole.length; at += at < 64 ? 1 : 3) {
    tried += 1;
    const changed = whole.slice();
    changed[at]! ^= 1 << random(8);
    const found = await readColumns(makeHost(changed)).catch((error: unknown) => {
      assert.ok(error instanceof DataError, `byte ${at}: ${String(error)}`);
      return undefined;
    });
    if (found === undefined) ++refused;
    for (const [name, column] of found ?? []) {
      if (column instanceof DataError) ++refused;
      else assert.deepEqual(column, good.get(name), `byte ${at}, column ${name}`);
    }
  }
  assert.ok(refused > tried * 0.6, `${refused} of ${tried}`);
});

test('an archive that is cut off or has more bytes is refused', async () => {
  const whole = makeArchive(kBoxes);
  for (const length of [1, 63, 64, 500, whole.length - 1]) {
    assert.notEqual(
      await kindOfAsync(makeHost(whole.slice(0, length)).open()),
      'none',
      `${length}`,
    );
  }
  assert.equal(await kindOfAsync(makeHost(whole.slice(0, whole.length - 1)).open()), 'cut');
  assert.equal(await kindOfAsync(makeHost(new Uint8Array([...whole, 0])).open()), 'damaged');
});

const reversed = <T>(items: T[]): T[] => [...items].reverse();

const withLeaf = (change: Partial<RawLeaf>): ArchiveOptions => ({
  changeLeaves: ([first, ...rest]) => [{ ...first!, ...change }, ...rest],
});

const withEntry = (change: Partial<RawEntry>): ArchiveOptions => ({
  changeEntries: ([first, ...rest]) => [{ ...first!, ...change }, ...rest],
});

test('an index that lies is refused', async () => {
  const far: Key = [0, 2, 0, 0];
  const cases: [string, ArchiveOptions, TestBox[]?][] = [
    ['another version', { header: { version: 2 } }],
    ['never finished', { header: { rootOffset: 0 } }],
    ['a root beyond the end', { header: { rootOffset: 2 ** 40 } }],
    ['a root of half an entry', { header: { rootBytes: 28 } }],
    ['a root without a checksum', { header: { rootBytes: 0 } }],
    ['facts of 5 MiB', { header: { infoBytes: 5 << 20 } }],
    ['another length of the file', { header: { fileBytes: 1e6 } }],
    ['leaves out of order', { entriesPerLeaf: 2, changeLeaves: reversed }],
    ['a leaf twice', { entriesPerLeaf: 2, changeLeaves: ([a, ...rest]) => [a!, a!, ...rest] }],
    ['a leaf of no entries', withLeaf({ entries: 0 })],
    ['a leaf of 1025 entries', withLeaf({ entries: 1025 })],
    ['a leaf of more entries', withLeaf({ entries: 7 })],
    ['a leaf beyond the end', withLeaf({ offset: 1e12 })],
    ['a leaf of 4 GiB', withLeaf({ bytes: 0xffffffff })],
    ['a leaf with another first box', withLeaf({ first: far })],
    ['a leaf of level 21', withLeaf({ first: [21, 0, 0, 0] })],
    ['entries out of order', { changeEntries: reversed }],
    ['an entry twice', { changeEntries: ([a, ...rest]) => [a!, a!, ...rest] }],
    ['an entry of 4 GiB', withEntry({ bytes: 0xffffffff })],
    ['an entry beyond the end', withEntry({ offset: 1e12 })],
    ['an entry beyond 2^53', withEntry({ offset: 2 ** 60 })],
    ['an entry in the header', withEntry({ offset: 60 })],
    ['an entry of another kind', withEntry({ kind: 2 })],
    ['an entry of another length', withEntry({ bytes: 10 })],
    ['an entry of another place', withEntry({ offset: 900 })],
    ['a box outside of the bounds', {}, [...kBoxes, { key: far, voxels: [] }]],
    ['a box of another level', {}, [...kBoxes, { key: [3, 0, 0, 0], voxels: [] }]],
    ['a box far away', {}, [...kBoxes, { key: [0, 1 << 20, 0, 0], voxels: [] }]],
    [
      'boxes of the next leaf',
      {
        entriesPerLeaf: 3,
        changeLeaves: ([a, b]) => [a!, { ...b!, first: [0, 0, 0, 0] }],
        changeEntries: reversed,
      },
    ],
  ];
  for (const [name, options, boxes] of cases) {
    const host = archiveHost(options, boxes);
    const found = await readColumns(host).catch((error: unknown) => error);
    const errors = found instanceof Map ? [...found.values()] : [found];
    const failed = errors.filter((error) => error instanceof Error);
    assert.ok(failed.length > 0, name);
    for (const error of failed) assert.ok(error instanceof DataError, `${name}: ${String(error)}`);
  }
  const large = archiveHost({ header: { rootBytes: 8 + 40 * 900_000, fileBytes: 1e9 } });
  assert.equal(await kindOfAsync(large.open()), 'too-large');
});

test('facts that no world has are refused', async () => {
  const bounds = (min: number[], max: number[]) => ({ bounds: { min, max } });
  const wide = 2 ** 26;
  const cases: [string, Record<string, unknown>, DataErrorKind | 'none'][] = [
    ['sound', {}, 'none'],
    ['no bounds', { bounds: undefined }, 'damaged'],
    ['another version', { version: 1 }, 'damaged'],
    ['other boxes', { box: [64, 64, 64] }, 'damaged'],
    ['a title that is none', { title: 7 }, 'damaged'],
    ['bounds upside down', bounds([0, 0, 0], [1, -1, 1]), 'damaged'],
    ['bounds of halves', bounds([0, 0, 0], [1.5, 1, 1]), 'damaged'],
    ['bounds beyond 2^30', bounds([-(2 ** 30) - 1, 0, 0], [1, 1, 1]), 'damaged'],
    ['voxels of nothing', { voxel_m: 0 }, 'damaged'],
    ['voxels of 1001 m', { voxel_m: 1001 }, 'damaged'],
    ['no levels', { levels: 0 }, 'damaged'],
    ['half levels', { levels: 3.5 }, 'damaged'],
    ['22 levels', { levels: 22 }, 'damaged'],
    ['fewer levels than the bounds need', { levels: 2 }, 'damaged'],
    ['a frame that is none', { framed: 5 }, 'damaged'],
    ['heights that are none', { typical_heights: 5 }, 'damaged'],
    ['half heights', { typical_heights: { min: 0.5, max: 9 } }, 'damaged'],
    ['millions of coarse boxes', { ...bounds([-wide, 0, -wide], [wide, 9, wide]) }, 'damaged'],
    [
      'too far from the origin',
      { ...bounds([2 ** 27, 0, 0], [2 ** 27 + 64, 9, 9]), levels: 1 },
      'damaged',
    ],
    [
      'a tower of 8192 boxes',
      { ...bounds([0, 0, 0], [64, 256 * 8192, 64]), levels: 1 },
      'too-large',
    ],
    ['as wide as it can be', { ...bounds([-wide, 0, -wide], [wide, 9, wide]), levels: 20 }, 'none'],
    ['nothing at all', { ...bounds([0, 0, 0], [0, 0, 0]), levels: 1 }, 'none'],
  ];
  for (const [name, facts, kind] of cases) {
    const found = await kindOfAsync(archiveHost({ facts }, []).open());
    assert.equal(found, kind, name);
  }
  const deep = JSON.stringify(kFacts).replace('[64,256,64]', '['.repeat(1e6) + ']'.repeat(1e6));
  const facts = new TextEncoder().encode(deep);
  assert.equal(
    catchKind(() => readFacts(facts, 'x')),
    'damaged',
  );
  const text = Buffer.from(makeArchive([])).toString('latin1');
  for (const bad of ['\xff', '{'.repeat(90), '['.repeat(90)]) {
    const bytes = new Uint8Array(
      Buffer.from(text.slice(0, 64) + bad + text.slice(64 + bad.length), 'latin1'),
    );
    assert.equal(await kindOfAsync(makeHost(bytes).open()), 'damaged');
  }
});

test('a frame that is no box, or a bomb, fails its column alone', async () => {
  const key: Key = [0, 1, 0, 0];
  const other = boxBytes([0, 1, 0, 1], kVoxels);
  const huge = Array.from({ length: 100 }, () => zstdBlock('rle', 131_072, toBytes(1)));
  const cases: [string, Uint8Array][] = [
    ['no frame', toBytes(1, 2, 3)],
    ['nothing', new Uint8Array(0)],
    ['another box', zstdFrame(other)],
    ['no box', zstdFrame(skewed(500))],
    ['more than any box', makeZstdFrame(13_107_200, huge)],
    ['a damaged box', zstdFrame(boxBytes(key, kVoxels).fill(1, 70, 71))],
  ];
  for (const [name, frame] of cases) {
    const found = await readColumns(archiveHost({}, [...kBoxes, { key, frame }]));
    const failed = [...found].filter(([, column]) => column instanceof DataError);
    assert.deepEqual(
      failed.map(([place]) => place),
      ['0/1/0'],
      name,
    );
    assert.match((failed[0]![1] as DataError).message, /http:\/\/host\/a, box 0\/1\/0\/0: /, name);
  }
});

test('a column of more memory than a page should hold is refused', async () => {
  const tall = { bounds: { min: [-128, 0, -128], max: [128, 256 * 20, 128] } };
  const boxes = Array.from({ length: 14 }, (_, by) => {
    const key: Key = [0, 0, by, 0];
    return { key, frame: fullBoxFrame(key) };
  });
  const column = { level: 0, bx: 0, bz: 0 };
  const found = await readColumns(archiveHost({ facts: tall }, boxes), [column]);
  assert.equal((found.get('0/0/0') as DataError).kind, 'too-large');
  const few = await readColumns(archiveHost({ facts: tall }, boxes.slice(0, 3)), [column]);
  assert.equal((few.get('0/0/0') as Column).boxes.length, 3);
});

test('files with random bytes give errors or columns', async () => {
  const random = makeRandom(11);
  const whole = makeArchive(kBoxes, { entriesPerLeaf: 2 });
  for (let i = 0; i < 60; ++i) {
    const bytes =
      i % 4 === 0 ? Uint8Array.from({ length: random(3000) }, () => random(256)) : whole.slice();
    if (i % 4 !== 0) {
      const from = random(bytes.length);
      const end = Math.min(bytes.length, from + 1 + random(40));
      for (let at = from; at < end; ++at) bytes[at] = random(256);
    }
    const found = await readColumns(makeHost(bytes)).catch((error: unknown) => error);
    assert.ok(found instanceof Map || found instanceof DataError, `file ${i}: ${String(found)}`);
  }
});

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { DataError, type DataErrorKind } from '../../voxelserver/serve/page/src/http/errors.js';
import { ServerSource } from '../../voxelserver/serve/page/src/viewer/data/server-source.js';
import type { Column } from '../../voxelserver/serve/page/src/viewer/data/columns.js';
import { record, serverHost } from './support/batch-host.js';
import { at } from './support/columns.js';
import { kindOfAsync } from './support/data-errors.js';
import { kOpen, type Handler, FakeHost, status } from './support/fake-host.js';
import { kFacts } from './support/make-archive.js';
import { kColumns, archiveHost, collect, readColumns } from './support/small-archive.js';
import { toBytes } from './support/test-bytes.js';

const openServer = (host: FakeHost, token?: string): Promise<ServerSource> => {
  const place = { server: 'http://host/path', ...(token === undefined ? {} : { token }) };
  return host.clock.finish(ServerSource.open(host.http, place, kOpen));
};

test('columns of a voxel server are those of an archive of it', async () => {
  const expected = await readColumns(archiveHost());
  const host = serverHost();
  const source = await openServer(host, 'secret');
  assert.equal(source.facts.world.title, 'small');
  const found = await collect(host, source, [...kColumns, { level: 0, bx: 99, bz: 0 }]);
  const hole = found.get('0/1/1') as Column;
  assert.deepEqual(hole.boxes, ['hole']);
  expected.set('0/1/1', hole);
  expected.set('0/99/0', { level: 0, bx: 99, bz: 0, byBegin: 0, boxes: [] });
  assert.deepEqual(found, expected);
  assert.deepEqual(
    host.asked.map(({ url }) => url),
    ['http://host/path/v2/world', 'http://host/path/v2/boxes'],
  );
  assert.deepEqual(host.asked[1]!.init.headers, {
    Authorization: 'Bearer secret',
    'Content-Type': 'application/json',
    'Terravox-Edition': 'e1',
  });
  // Two boxes a column, 32 boxes a batch.
  const candidates = Array.from({ length: 40 }, (_, bx) => at(bx));
  assert.equal(source.companions(at(50), candidates).length, 15);
});

test('a batch that is cut short is requested again for what is missing', async () => {
  const host = serverHost();
  const source = await openServer(host);
  const cut = serverHost({ cutAfter: 200 }).handler;
  host.next.push(cut, status(503));
  const found = await collect(host, source, kColumns);
  assert.ok([...found.values()].every((column) => !(column instanceof DataError)));
  const counts = host.asked.slice(1).map(({ init }) => {
    return (JSON.parse(init.body as string) as { boxes: unknown[] }).boxes.length;
  });
  assert.ok(counts[0]! > counts[1]! && counts[1] === counts[2]);
  host.next.push(cut, cut, cut);
  const failed = await collect(host, source, [at(1), at(0), at(-1)]);
  assert.ok([...failed.values()].some((c) => c instanceof DataError && c.kind === 'cut'));
});

test('what a busy server leaves out is requested again until it comes', async () => {
  const left = new Map<string, number>();
  const host = serverHost({
    chooseStatus: ([, bx, by]) => {
      const times = left.get(`${bx},${by}`) ?? (bx === 0 ? 7 : 0);
      left.set(`${bx},${by}`, times - 1);
      return times > 0 ? 503 : 204;
    },
  });
  const source = await openServer(host);
  const found = await collect(host, source, [at(0), at(1)]);
  assert.deepEqual((found.get('0/0/0') as Column).boxes, []);
  assert.deepEqual((found.get('0/1/0') as Column).boxes, []);
  const counts = host.asked.slice(1).map(({ init }) => {
    return (JSON.parse(init.body as string) as { boxes: unknown[] }).boxes.length;
  });
  assert.deepEqual(counts, [4, 2, 2, 2, 2, 2, 2, 2]);
});

test('a server that is away for a while makes no hole', async () => {
  const host = serverHost();
  const source = await openServer(host);
  const away: Handler = () => {
    throw new TypeError('Failed to fetch');
  };
  host.next.push(away, away, away, away, status(503), status(502), status(429), away);
  const found = await collect(host, source, kColumns);
  assert.ok([...found.values()].every((column) => !(column instanceof DataError)));
});

test('what is no longer wanted of a busy server is not requested again', async () => {
  const host = serverHost({ chooseStatus: () => 503 });
  const source = await openServer(host);
  const unwanted = new AbortController();
  const results = source.columns([at(0)], unwanted.signal).next();
  const isAskedAgain = async (): Promise<void> => {
    while (host.asked.length < 4) await new Promise((resolve) => setImmediate(resolve));
  };
  await host.clock.finish(isAskedAgain());
  unwanted.abort(new Error('not any more'));
  await assert.rejects(host.clock.finish(results), /not any more/);
  assert.equal(host.asked.length, 4);
});

test('a change of the data, or of the token, ends all', async () => {
  const host = serverHost();
  const source = await openServer(host);
  const other = { headers: { 'Terravox-Edition': 'e2' } };
  for (const handler of [status(412), status(401), () => new Response('', other)]) {
    host.next.push(handler);
    assert.equal(await kindOfAsync(collect(host, source, [at(0)])), 'changed');
  }
});

test('levels that take too long are left out, unless too many columns would remain', async () => {
  const world = { ...kFacts, bounds: { min: [0, 0, 0], max: [8192, 256, 4096] }, levels: 8 };
  const host = new FakeHost();
  host.handler = () => new Response(JSON.stringify(world));
  const open = (coarsest: number): Promise<ServerSource> =>
    host.clock.finish(ServerSource.open(host.http, { server: 'http://host/', coarsest }, kOpen));
  assert.equal((await open(2)).facts.world.levels, 3);
  assert.equal((await open(20)).facts.world.levels, 8);
  assert.equal(await kindOfAsync(open(0)), 'too-large');
});

test('replies to a batch that are none are refused', async () => {
  const last = record([-1, 2, 0, 0], 0, new Uint8Array(0));
  const air = (by: number): Buffer => record([0, 0, by, 0], 204, new Uint8Array(0));
  const cases: [string, Uint8Array, DataErrorKind][] = [
    ['nothing', new Uint8Array(0), 'cut'],
    ['a last record of other boxes', record([-1, 3, 0, 0], 0, new Uint8Array(0)), 'damaged'],
    ['a last record too early', Buffer.concat([air(0), last]), 'damaged'],
    ['more boxes', Buffer.concat([air(5), air(6), air(7)]), 'damaged'],
    ['a record of 4 GiB', record([0, 0, 0, 0], 200, toBytes(1)).fill(255, 20, 24), 'damaged'],
    ['a long reason', record([0, 0, 0, 0], 500, new Uint8Array(70_000)), 'damaged'],
    ['another status', Buffer.concat([record([0, 0, 0, 0], 404, new Uint8Array(0))]), 'damaged'],
    ['no box', record([0, 0, 0, 0], 200, toBytes(1, 2, 3)), 'damaged'],
  ];
  for (const [name, bytes, kind] of cases) {
    const host = serverHost();
    const source = await openServer(host);
    const reply: Handler = () => new Response(bytes.slice());
    host.next.push(reply, reply, reply);
    const found = await collect(host, source, [at(0)]);
    assert.equal((found.get('0/0/0') as DataError).kind, kind, name);
  }
});

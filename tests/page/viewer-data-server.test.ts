import assert from 'node:assert/strict';
import { test } from 'node:test';
import { DataError, type DataErrorKind } from '../../voxelserver/page/src/viewer/data/errors.js';
import { ServerSource } from '../../voxelserver/page/src/viewer/data/server-source.js';
import type { Column } from '../../voxelserver/page/src/viewer/data/source.js';
import { record, serverHost } from './support/batch-host.js';
import { at } from './support/columns.js';
import { kindOfAsync } from './support/data-errors.js';
import { kOpen, type Handler, FakeHost, status } from './support/fake-host.js';
import { kColumns, archiveHost, collect, columnsOf } from './support/small-archive.js';
import { bytesOf } from './support/test-bytes.js';

const openServer = (host: FakeHost, token?: string): Promise<ServerSource> => {
  const place = { url: 'http://host/path', ...(token === undefined ? {} : { token }) };
  return host.clock.finish(ServerSource.open(host.http, place, kOpen));
};

test('columns of a voxel server are those of an archive of it', async () => {
  const expected = await columnsOf(archiveHost());
  const host = serverHost();
  const source = await openServer(host, 'secret');
  assert.equal(source.facts.world.title, 'small');
  const found = await collect(host, source, [...kColumns, { level: 0, bx: 99, bz: 0 }]);
  const hole = found.get('0/1/1') as Column;
  assert.deepEqual(hole.boxes, [{ hole: 'no 500' }]);
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
    return (JSON.parse(String(init.body)) as { boxes: unknown[] }).boxes.length;
  });
  assert.ok(counts[0]! > counts[1]! && counts[1] === counts[2]);
  host.next.push(cut, cut, cut);
  const failed = await collect(host, source, [at(1), at(0), at(-1)]);
  assert.ok([...failed.values()].some((c) => c instanceof DataError && c.kind === 'cut'));
});

test('a box that a busy server leaves out fails its column, and a change ends all', async () => {
  const host = serverHost({ statusOf: ([, bx]) => (bx === 0 ? 503 : 204) });
  const source = await openServer(host);
  const found = await collect(host, source, [at(0), at(1)]);
  assert.equal((found.get('0/0/0') as DataError).kind, 'server');
  assert.deepEqual((found.get('0/1/0') as Column).boxes, []);
  const other = { headers: { 'Terravox-Edition': 'e2' } };
  for (const handler of [status(412), () => new Response('', other)]) {
    host.next.push(handler);
    assert.equal(await kindOfAsync(collect(host, source, [at(0)])), 'changed');
  }
});

test('replies to a batch that are none are refused', async () => {
  const last = record([-1, 2, 0, 0], 0, new Uint8Array(0));
  const air = (by: number): Buffer => record([0, 0, by, 0], 204, new Uint8Array(0));
  const cases: [string, Uint8Array, DataErrorKind][] = [
    ['nothing', new Uint8Array(0), 'cut'],
    ['a last record of other boxes', record([-1, 3, 0, 0], 0, new Uint8Array(0)), 'damaged'],
    ['a last record too early', Buffer.concat([air(0), last]), 'damaged'],
    ['more boxes', Buffer.concat([air(5), air(6), air(7)]), 'damaged'],
    ['a record of 4 GiB', record([0, 0, 0, 0], 200, bytesOf(1)).fill(255, 20, 24), 'damaged'],
    ['a long reason', record([0, 0, 0, 0], 500, new Uint8Array(70_000)), 'damaged'],
    ['another status', Buffer.concat([record([0, 0, 0, 0], 404, new Uint8Array(0))]), 'damaged'],
    ['no box', record([0, 0, 0, 0], 200, bytesOf(1, 2, 3)), 'damaged'],
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

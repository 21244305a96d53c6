import assert from 'node:assert/strict';
import { test } from 'node:test';
import { bytesOfColumn } from '../../voxelserver/serve/page/src/viewer/data/columns.js';
import type { FromWorker } from '../../voxelserver/serve/page/src/viewer/data/protocol.js';
import { Session } from '../../voxelserver/serve/page/src/viewer/data/session.js';
import { serverHost } from './support/batch-host.js';
import { at } from './support/columns.js';
import { FakeHost } from './support/fake-host.js';
import { kFacts, makeArchive } from './support/make-archive.js';
import { kBoxes, archiveHost } from './support/small-archive.js';

function makeSession(host: FakeHost): {
  session: Session;
  sent: FromWorker[];
  transfers: number[];
} {
  const sent: FromWorker[] = [];
  const transfers: number[] = [];
  const post = (message: FromWorker, transfer: ArrayBuffer[]): void => {
    sent.push(structuredClone(message, { transfer }));
    transfers.push(transfer.length);
  };
  return { session: new Session(post, host.environment, 'http://host/'), sent, transfers };
}

const untilSent = (host: FakeHost, sent: readonly FromWorker[], count: number): Promise<void> =>
  host.clock.finish(
    (async () => {
      while (sent.length < count) await new Promise((resolve) => setImmediate(resolve));
    })(),
  );

test('a session opens a world and sends what is wanted, whatever comes first', async () => {
  const host = archiveHost();
  const { session, sent, transfers } = makeSession(host);
  session.handle({ type: 'want', columns: [at(0), at(0, 3), at(1)] });
  session.handle({ type: 'open', place: { url: 'a' } });
  session.handle({ type: 'open', place: { url: 'b' } });
  await untilSent(host, sent, 4);
  assert.equal(sent[0]!.type, 'opened');
  const column = sent.find((message) => message.type === 'column' && message.column.bx === 0)!;
  assert.ok(column.type === 'column' && column.bytes > 0);
  assert.ok(transfers.includes(8));
  const failed = sent.find(({ type }) => type === 'failed');
  assert.ok(failed?.type === 'failed' && failed.failure.kind === 'missing');
  session.handle({ type: 'stats' });
  const stats = sent.at(-1)!;
  assert.equal(stats.type === 'stats' && stats.stats.requests, host.asked.length);
});

test('a session says why a world cannot be opened', async () => {
  const open = async (place: Parameters<Session['handle']>[0] & { type: 'open' }) => {
    const host = archiveHost();
    const { session, sent } = makeSession(host);
    session.handle(place);
    await untilSent(host, sent, 1);
    const [message] = sent;
    return message?.type === 'ended' ? message.failure.kind : message?.type;
  };
  assert.equal(await open({ type: 'open', place: { url: 'b' } }), 'missing');
  assert.equal(await open({ type: 'open', place: { url: 'file:///a' } }), 'missing');
  assert.equal(await open({ type: 'open', place: { server: 'http://[' } }), 'missing');
  assert.equal(await open({ type: 'open', place: { parts: [] } }), 'damaged');
  const bytes = makeArchive(kBoxes).length;
  assert.equal(await open({ type: 'open', place: { parts: [{ url: 'a', bytes }] } }), 'opened');
});

test('batches that take long leave connections to the host free', async () => {
  const world = { ...kFacts, bounds: { min: [0, 0, 0], max: [8192, 256, 4096] }, levels: 8 };
  const host = new FakeHost();
  host.handler = (url) =>
    url.endsWith('/v2/world') ? new Response(JSON.stringify(world)) : new Promise(() => undefined);
  const { session, sent } = makeSession(host);
  session.handle({ type: 'open', place: { server: 'http://host/' } });
  await untilSent(host, sent, 1);
  const columns = Array.from({ length: 500 }, (_, i) => ({ level: 0, bx: i % 100, bz: i % 60 }));
  session.handle({ type: 'want', columns });
  for (let i = 0; i < 50; ++i) await new Promise((resolve) => setImmediate(resolve));
  assert.equal(host.asked.filter(({ url }) => url.endsWith('/v2/boxes')).length, 4);
  session.stop();
});

test('a session pauses while the page has not taken what was sent', async () => {
  const host = serverHost();
  const { session, sent } = makeSession(host);
  session.handle({ type: 'open', place: { server: 'http://host/' } });
  await untilSent(host, sent, 1);
  // As if so much had been sent before.
  session.handle({ type: 'taken', bytes: -(2 ** 30) });
  session.handle({ type: 'want', columns: [at(0), at(1), at(-1)] });
  for (let i = 0; i < 50; ++i) await new Promise((resolve) => setImmediate(resolve));
  assert.equal(sent.length, 1);
  session.handle({ type: 'taken', bytes: 2 ** 30 });
  await untilSent(host, sent, 4);
  session.stop();
});

test('a column that the page has not taken yet is not sent again', async () => {
  const host = archiveHost();
  const { session, sent } = makeSession(host);
  session.handle({ type: 'open', place: { url: 'a' } });
  session.handle({ type: 'want', columns: [at(0)] });
  await untilSent(host, sent, 2);
  const [, column] = sent;
  assert.ok(column?.type === 'column');
  // The list was made before the column arrived at the page.
  session.handle({ type: 'want', columns: [at(0), at(0, 1)] });
  await untilSent(host, sent, 3);
  session.handle({ type: 'taken', bytes: column.bytes });
  // Taken, and dropped since then.
  session.handle({ type: 'want', columns: [at(0)] });
  await untilSent(host, sent, 4);
  const levels = sent.slice(1).map((message) => message.type === 'column' && message.column.level);
  assert.deepEqual(levels, [0, 1, 0]);
});

test('air between the boxes of a column counts as memory', () => {
  const column = {
    ...at(0),
    byBegin: 0,
    boxes: Array.from({ length: 4096 }, () => 'air' as const),
  };
  assert.equal(bytesOfColumn(column), 4096 * 64);
});

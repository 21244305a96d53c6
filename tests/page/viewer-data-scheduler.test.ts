import assert from 'node:assert/strict';
import { test } from 'node:test';
import { ArchiveSource } from '../../voxelserver/serve/page/src/viewer/data/archive-source.js';
import type {
  ColumnKey,
  BoxSource,
  Column,
} from '../../voxelserver/serve/page/src/viewer/data/columns.js';
import { DataError } from '../../voxelserver/serve/page/src/http/errors.js';
import { Scheduler } from '../../voxelserver/serve/page/src/viewer/data/scheduler.js';
import { toName, at, columnAt } from './support/columns.js';
import { kOpen } from './support/fake-host.js';
import { archiveHost, makeRow } from './support/small-archive.js';

type Job = {
  readonly names: string[];
  readonly signal: AbortSignal;
  readonly give: (result: Column | { failed: ColumnKey; error: DataError }) => void;
  readonly end: (error?: unknown) => void;
};

/** A source whose requests end when the test says so. Columns with bx / 10 in common are near. */
class FakeSource implements BoxSource {
  readonly facts = { world: {} as BoxSource['facts']['world'], damage: 0 };
  readonly jobs: Job[] = [];
  isNear = (a: ColumnKey, b: ColumnKey): boolean => Math.floor(a.bx / 10) === Math.floor(b.bx / 10);

  /** Resolves what is known of a column. */
  prepare: (column: ColumnKey) => Promise<void> = () => Promise.resolve();

  companions(column: ColumnKey, candidates: readonly ColumnKey[]): ColumnKey[] {
    return candidates.filter((candidate) => this.isNear(column, candidate));
  }

  async *columns(
    columns: readonly ColumnKey[],
    signal: AbortSignal,
  ): ReturnType<BoxSource['columns']> {
    const results: ({ column: Column } | { failed: ColumnKey; error: DataError })[] = [];
    let isOver = false;
    let failure: unknown;
    let wake = (): void => undefined;
    const stop = (error: unknown): void => {
      [isOver, failure] = [true, error];
      wake();
    };
    signal.addEventListener('abort', () => stop(signal.reason));
    this.jobs.push({
      names: columns.map(toName),
      signal,
      end: (error) => stop(error),
      give: (result) => {
        results.push('failed' in result ? result : { column: result });
        wake();
      },
    });
    for (;;) {
      const next = results.shift();
      if (next !== undefined) yield next;
      else if (isOver && failure !== undefined) throw failure as Error;
      else if (isOver) return;
      else await new Promise<void>((resolve) => (wake = resolve));
    }
  }
}

const whenReady = (): Promise<void> => Promise.resolve();

function scheduling(maxRequests?: number) {
  const source = new FakeSource();
  const got: string[] = [];
  const failed: string[] = [];
  const ended: string[] = [];
  const scheduler = new Scheduler(
    source,
    {
      whenReady,
      onColumn: (column) => void got.push(toName(column)),
      onFailed: (column, error) => failed.push(`${toName(column)} ${error.kind}`),
      onEnded: (error) => ended.push(error.kind),
    },
    maxRequests,
  );
  const turn = () => new Promise((resolve) => setImmediate(resolve));
  const names = (): string[][] => source.jobs.map((job) => job.names);
  return { source, scheduler, got, failed, ended, turn, names };
}

test('the most wanted come first, six requests at a time, each with its neighbours', async () => {
  const { source, scheduler, turn, names, got } = scheduling();
  scheduler.want([at(80), at(10), at(20), at(11), at(30), at(40), at(50), at(60), at(12), at(81)]);
  await turn();
  assert.deepEqual(
    names().map(([first]) => first),
    ['0/80/0', '0/10/0', '0/20/0', '0/30/0', '0/40/0', '0/50/0'],
  );
  assert.deepEqual(names().slice(0, 2), [
    ['0/80/0', '0/81/0'],
    ['0/10/0', '0/11/0', '0/12/0'],
  ]);
  source.jobs[1]!.give(columnAt(at(12)));
  source.jobs[1]!.give(columnAt(at(10)));
  await turn();
  assert.deepEqual(got, ['0/12/0', '0/10/0']);
  assert.equal(names().length, 6);
  source.jobs[1]!.give(columnAt(at(11)));
  source.jobs[1]!.end();
  await turn();
  assert.deepEqual(names()[6], ['0/60/0']);
  assert.deepEqual(scheduler.stats, { waiting: 7, requests: 6 });
});

test('a new list cancels what it does not name, and requests nothing twice', async () => {
  const { source, scheduler, turn, names, got } = scheduling(3);
  scheduler.want([at(10), at(60), at(20), at(30), at(40)]);
  await turn();
  assert.deepEqual(names(), [['0/10/0'], ['0/60/0'], ['0/20/0']]);
  scheduler.want([at(50), at(20), at(60), at(61), at(20)]);
  await turn();
  assert.deepEqual(
    source.jobs.map(({ signal }) => signal.aborted),
    [true, false, false, false],
  );
  assert.deepEqual(names().slice(3), [['0/50/0']]);
  source.jobs[1]!.give(columnAt(at(60)));
  source.jobs[1]!.end();
  source.jobs[2]!.give(columnAt(at(20)));
  source.jobs[2]!.end();
  await turn();
  assert.deepEqual(got, ['0/60/0', '0/20/0']);
  assert.deepEqual(names().slice(4), [['0/61/0']]);
  // What a request brings along and nothing wants any more is not sent.
  scheduler.want([at(10), at(61), at(11)]);
  await turn();
  assert.deepEqual(names().slice(5), [['0/10/0', '0/11/0']]);
  scheduler.want([at(61)]);
  source.jobs[4]!.give(columnAt(at(61)));
  await turn();
  assert.deepEqual(got, ['0/60/0', '0/20/0', '0/61/0']);
  scheduler.want([]);
  assert.ok(source.jobs.every(({ signal }, i) => signal.aborted || [1, 2].includes(i)));
  assert.deepEqual(scheduler.stats, { waiting: 0, requests: 0 });
});

test('a failing column ends no other, a failing request its own, a change all', async () => {
  const { source, scheduler, turn, failed, got, ended, names } = scheduling(1);
  scheduler.want([at(10), at(11), at(12), at(20), at(30)]);
  await turn();
  source.jobs[0]!.give({ failed: at(11), error: new DataError('damaged', 'x') });
  source.jobs[0]!.give(columnAt(at(12)));
  source.jobs[0]!.end(new DataError('server', 'x'));
  await turn();
  assert.deepEqual(failed, ['0/11/0 damaged', '0/10/0 server']);
  assert.deepEqual(got, ['0/12/0']);
  assert.deepEqual(names()[1], ['0/20/0']);
  // A source that forgets a column, or has a bug, is no endless loop.
  source.jobs[1]!.end();
  await turn();
  assert.deepEqual(failed[2], '0/20/0 damaged');
  source.jobs[2]!.end(new DataError('changed', 'x'));
  await turn();
  assert.deepEqual(ended, ['changed']);
  scheduler.want([at(70)]);
  await turn();
  assert.equal(names().length, 3);
});

test('neighbours in an archive share a request, and distant ones have their own', async () => {
  const { facts, boxes } = makeRow(64, 7);
  const requestsFor = async (gapBytes: number, wanted: ColumnKey[]): Promise<number> => {
    const host = archiveHost({ facts, gapBytes }, boxes);
    const source = new ArchiveSource(await host.open(), host.clock);
    await host.clock.finish(source.prepare(wanted[0]!, [], kOpen));
    const before = host.asked.length;
    let missing = new Set(wanted).size;
    await host.clock.finish(
      new Promise<void>((resolve, reject) => {
        const onColumn = (): void => {
          missing -= 1;
          if (missing === 0) resolve();
        };
        const events = { whenReady, onColumn, onFailed: reject, onEnded: reject };
        new Scheduler(source, events, 1).want(wanted);
      }),
    );
    return host.asked.length - before;
  };
  const all = boxes.map(({ key }) => at(key[1]));
  const air = at(5, 3);
  assert.equal(await requestsFor(0, [...all, air]), 1);
  // About 21 KiB a box: 1 MiB has 50 of them; the first and three more are read by opening.
  assert.equal(await requestsFor(20_000, all), 2);
  assert.equal(await requestsFor(20_000, [all[30]!, ...all]), 2);
  const distant = [all[0]!, all[1]!, all[10]!, all[11]!];
  assert.equal(await requestsFor(20_000, distant), 2);
  assert.equal(await requestsFor(20_000, all.slice(-3)), 0);
  assert.equal(await requestsFor(70_000, all.slice(0, 9)), 8);
});

test('a column is requested by whichever request is prepared first', async () => {
  const { source, scheduler, turn, names, got } = scheduling();
  const prepared = new Map<string, () => void>();
  source.prepare = (column) => new Promise((resolve) => void prepared.set(toName(column), resolve));
  scheduler.want([at(10), at(11), at(20), at(12)]);
  await turn();
  assert.deepEqual(names(), []);
  prepared.get('0/11/0')!();
  await turn();
  assert.deepEqual(names(), [['0/11/0', '0/10/0', '0/12/0']]);
  // Their columns have been taken, so that they end without a request.
  prepared.get('0/10/0')!();
  prepared.get('0/12/0')!();
  await turn();
  assert.equal(names().length, 1);
  assert.deepEqual(scheduler.stats, { waiting: 4, requests: 2 });
  for (const bx of [10, 11, 12]) source.jobs[0]!.give(columnAt(at(bx)));
  source.jobs[0]!.end();
  await turn();
  assert.deepEqual(got, ['0/10/0', '0/11/0', '0/12/0']);
  scheduler.want([]);
  assert.deepEqual(scheduler.stats, { waiting: 0, requests: 0 });
});

test('callers share the request of a leaf, and one caller less does not end it', async () => {
  const host = archiveHost({ entriesPerLeaf: 3, leafGapBytes: 70_000 });
  const archive = await host.open();
  const before = host.asked.length;
  const first = new AbortController();
  const places = [at(0, 1), at(0, 2), at(0, 1)];
  const waits = places.map((place, i) => archive.column(place, i === 0 ? first.signal : kOpen));
  first.abort(new Error('not any more'));
  await assert.rejects(waits[0]!, /not any more/);
  const [, one, two] = await host.clock.finish(Promise.allSettled(waits));
  assert.ok(one!.status === 'fulfilled' && one!.value.length === 1);
  assert.ok(two!.status === 'fulfilled' && two!.value.length === 1);
  assert.equal(host.asked.length, before + 1);
});

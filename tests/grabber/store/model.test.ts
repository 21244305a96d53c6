import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { State, Store } from '../../../grabber/src/model/store.js';
import { openStore } from '../../../grabber/src/store/open-store.js';
import {
  catalogueSquare,
  kTerms,
  kVerified,
  keyOfSquare,
  seeded,
  storedFile,
} from '../support/record-fixture.js';
import { kNever, temporaryFolder } from '../support/store-fixture.js';

/** What matters of a record, kept the simplest way. */
type Model = {
  state: State;
  bytes: number | undefined;
  original: number | undefined;
  good: boolean;
  converted: boolean;
  attempts: number;
  expected: number | null;
  warned: boolean;
  error: string | undefined;
};

const kCalls = [
  'learn',
  'want',
  'again',
  'begin',
  'fetched',
  'verified',
  'converted',
  'missing',
  'failed',
  'forget',
  'reopen',
] as const;

function blank(expected: number | null): Model {
  return {
    state: 'known',
    bytes: undefined,
    original: undefined,
    good: false,
    converted: false,
    attempts: 0,
    expected,
    warned: false,
    error: undefined,
  };
}

function fallBack(model: Model, to: State, code: string): void {
  const usableState = model.converted ? 'converted' : 'verified';
  model.state = model.good ? usableState : to;
  model.error = code;
}

/** A catalogue gives another length of the file. */
function relearn(model: Model, bytes: number): void {
  if (model.bytes !== undefined && model.expected !== bytes) model.warned = true;
  model.expected = bytes;
}

function usable(model: Model): boolean {
  return model.state === 'verified' || model.state === 'converted';
}

/** @return false when the call must be refused */
function apply(model: Model, call: (typeof kCalls)[number], bytes: number): boolean {
  switch (call) {
    case 'want':
    case 'again':
      if (
        ['known', 'failed'].includes(model.state) ||
        (call === 'again' && (model.state === 'missing' || usable(model)))
      ) {
        Object.assign(model, { state: 'wanted', attempts: 0, error: undefined });
      }
      return true;
    case 'begin':
      model.state = 'fetching';
      ++model.attempts;
      return true;
    case 'fetched':
      Object.assign(model, {
        state: 'fetched',
        bytes,
        original: undefined,
        good: false,
        converted: false,
        warned: false,
      });
      return true;
    case 'verified':
      if (model.bytes === undefined) return false;
      Object.assign(model, {
        state: 'verified',
        good: true,
        converted: false,
        warned: false,
        error: undefined,
      });
      return true;
    case 'converted':
      if (model.state === 'fetching') model.original = undefined;
      else if (model.state !== 'converted') model.original = model.bytes;
      Object.assign(model, {
        state: 'converted',
        bytes,
        good: true,
        converted: true,
        warned: false,
        error: undefined,
      });
      return true;
    case 'missing':
      fallBack(model, 'missing', 'MISSING');
      return true;
    case 'failed':
      fallBack(model, model.state === 'fetched' ? 'fetched' : 'failed', 'X');
      return true;
    case 'forget':
      Object.assign(model, blank(model.expected));
      return true;
    case 'learn':
    case 'reopen':
      return true;
  }
}

function checkRecord(store: Store, name: string, expected: Model, shown: string): void {
  const record = store.squares.get(keyOfSquare(name));
  assert.deepEqual(
    [
      record?.state,
      record?.file?.bytes,
      record?.original?.bytes,
      record?.attempts,
      record?.expectedBytes,
      record?.warnings.length === 1,
      record?.lastError?.code,
    ],
    [
      expected.state,
      expected.bytes,
      expected.original,
      expected.attempts,
      expected.expected,
      expected.warned,
      expected.error,
    ],
    shown,
  );
}

test('any sequence of calls has the outcome of a simple model', async (t) => {
  const names = ['462_101', '463_101', '464_101'];
  for (let seed = 1; seed <= 12; ++seed) {
    const random = seeded(seed);
    const root = await temporaryFolder(t);
    let store = openStore(root, {}, kNever);
    const models = new Map<string, Model>();
    const log: string[] = [];
    for (let step = 0; step < 120; ++step) {
      const call = kCalls[random(kCalls.length)] ?? 'learn';
      const name = names[random(names.length)] ?? '';
      const bytes = 1 + random(4);
      const key = keyOfSquare(name);
      const model = models.get(name);
      log.push(`${call} ${name} ${bytes}`);
      const shown = `seed ${seed}: ${log.join(', ')}`;
      const act: Record<(typeof kCalls)[number], () => unknown> = {
        learn: () =>
          store.squares.learn('si-lss', 'si-lss', 'EPSG:3794', kTerms, [
            catalogueSquare(Number(name.slice(0, 3)), 101, { bytes }),
          ]),
        want: () => store.squares.want([key]),
        again: () => store.squares.want([key], true),
        begin: () => store.squares.begin(key, 'http://h'),
        fetched: () => store.squares.fetched(key, storedFile(name, bytes)),
        verified: () => store.squares.verified(key, kVerified),
        converted: () => store.squares.converted(key, storedFile(name, bytes), kVerified),
        missing: () => store.squares.missing(key, 'no'),
        failed: () => store.squares.failed(key, 'X', 'no'),
        forget: () => store.squares.forget(key),
        reopen: () => {
          store.close();
          store = openStore(root, {}, kNever);
        },
      };
      if (call === 'learn') {
        assert.deepEqual(
          act.learn(),
          {
            added: model === undefined ? 1 : 0,
            changed: model !== undefined && model.expected !== bytes ? 1 : 0,
          },
          shown,
        );
        if (model === undefined) models.set(name, blank(bytes));
        else relearn(model, bytes);
      } else if (call === 'reopen') act.reopen();
      else if (model === undefined || !apply(model, call, bytes)) {
        assert.throws(act[call], { code: 'STORE_CONFLICT' }, shown);
      } else act[call]();
      for (const [one, expected] of models) checkRecord(store, one, expected, shown);
    }
    assert.equal(store.squares.count({}), models.size);
    assert.equal(
      store.squares.list({ usable: true }).length,
      [...models.values()].filter(({ good }) => good).length,
    );
    store.close();
  }
});

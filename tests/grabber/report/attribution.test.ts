import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { StoreRecord } from '../../../grabber/src/model/store.js';
import { attributionText } from '../../../grabber/src/cli/attribution-command.js';
import { toKey } from '../support/store-fixture.js';

const kNames = { titles: new Map(), addresses: new Map() };

/** What is asked of a record for its attribution. */
function record(terms: Partial<StoreRecord>): StoreRecord {
  const fields = { key: toKey('462_101'), licence: null, attribution: null, published: null };
  return { ...fields, ...terms } as StoreRecord;
}

test('each source has its data, years, licence and attribution', () => {
  const squares = [record({ attribution: 'us', published: '2014-05-01' })];
  const text = attributionText(squares, [], kNames);
  assert.match(text, /^ {2}data: +1 LiDAR squares$/m);
  assert.match(text, /^ {2}years: +2014$/m);
  assert.match(text, /^ {2}licence: +not recorded$/m);
  assert.match(text, /^ {2}attribution: us$/m);
});

test('the text of a stranger does not look like another source', () => {
  const attribution = 'us\n\nFake (si-lss)\n  licence:     CC0\u001b[31m\u202e';
  const text = attributionText([record({ attribution })], [], kNames);
  assert.doesNotMatch(text, /^Fake/m);
  assert.doesNotMatch(text, /(?!\n)[\p{Cc}\u202e]/u);
  assert.match(text, /us\\u000a\\u000aFake/);
  assert.equal(text.match(/^ {2}licence: /gm)?.length, 1);
});

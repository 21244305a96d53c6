import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { State, StoreRecord } from '../../../grabber/src/model/store.js';
import { drawSquares, type PlacedState } from '../../../grabber/src/cli/status-command.js';
import { attributionText } from '../../../grabber/src/cli/attribution-command.js';
import { toKey } from '../support/store-fixture.js';

/** Squares of 1 km from rows of letters, north first; a blank is no square. */
function makeSquares(rows: readonly string[], west = 462_000, south = 101_000): PlacedState[] {
  const states: Record<string, State> = {
    '.': 'known',
    w: 'wanted',
    f: 'fetching',
    F: 'fetched',
    V: 'verified',
    C: 'converted',
    m: 'missing',
    X: 'failed',
  };
  return rows.flatMap((row, index) =>
    [...row].flatMap((letter, column) => {
      const state = states[letter];
      const [w, s] = [west + 1000 * column, south + 1000 * (rows.length - 1 - index)];
      return state === undefined ? [] : [{ state, bounds: [w, s, w + 1000, s + 1000] as const }];
    }),
  );
}

const kWide = { columns: 79, rows: 40 };
const kLetters = { colour: false };

test('the picture has north up, two rows a line, and trouble before everything else', () => {
  const picture = drawSquares(makeSquares(['V V', 'VwX', '  .']), kWide, kLetters);
  assert.equal(picture, 'VwX\n  .\n. known  w wanted  V verified  X failed\n');
});

test('a country is drawn in the places there are, and one bad square stays visible', () => {
  const rows = Array.from({ length: 120 }, () => 'V'.repeat(300));
  rows[77] = `${'V'.repeat(200)}X${'V'.repeat(99)}`;
  const lines = drawSquares(makeSquares(rows), { columns: 60, rows: 20 }, kLetters)
    .trimEnd()
    .split('\n');
  const legend = lines.pop();
  assert.equal(legend, 'V verified  X failed');
  assert.equal(lines.length, 12, '5 squares an element, 2 elements a letter');
  assert.ok(lines.every((line) => line.length === 60));
  assert.equal(lines.join('').replaceAll('V', ''), 'X');
  assert.equal(lines[7]?.indexOf('X'), 40);
});

test('colours are half blocks, reset at the end of each line', () => {
  const picture = drawSquares(makeSquares(['VX', ' w', 'V ']), kWide, { colour: true });
  const [esc, reset] = ['\u001b[', '\u001b[0m'];
  const lines = picture.split('\n');
  assert.equal(lines[0], `${reset}${esc}38;5;34m▀${reset}${esc}38;5;160m${esc}48;5;221m▀${reset}`);
  assert.equal(lines[1], `${reset}${esc}38;5;34m▀${reset} ${reset}`);
  assert.equal(
    drawSquares(makeSquares(['  ', ' w']), kWide, { colour: true }).split('\n')[0],
    `${reset}${esc}38;5;221m▀${reset}`,
    'it begins where squares are',
  );
});

test('squares that lie far apart do not make a picture that fills the memory', () => {
  const far = [...makeSquares(['V']), ...makeSquares(['X'], 462_000 + 1e12, 101_000 - 1e12)];
  const lines = drawSquares(far, { columns: 50, rows: 10 }, kLetters).trimEnd().split('\n');
  assert.ok(lines.length <= 11 && lines.every((line) => line.length <= 50), lines.join('\n'));
  assert.equal(lines[0], 'V');
  assert.match(lines.at(-2) ?? '', /^ +X$/);
  assert.equal(drawSquares([], kWide, kLetters), '');
});

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

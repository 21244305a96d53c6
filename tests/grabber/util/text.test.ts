import assert from 'node:assert/strict';
import { test } from 'node:test';
import { oneLine } from '../../../grabber/src/util/errors.js';
import { printable, printableLine } from '../../../grabber/src/util/text.js';

/** Each range that is folded: its first and last character. */
const kHarmful: Readonly<Record<string, readonly number[]>> = {
  C0: [0x00, 0x08, 0x0b, 0x1f],
  'a carriage return': [0x0d],
  'an escape': [0x1b],
  'DEL and C1': [0x7f, 0x80, 0x9b, 0x9f],
  'line and paragraph separators': [0x2028, 0x2029],
  'bidirectional marks': [0x061c, 0x200e, 0x200f],
  'embeddings and overrides': [0x202a, 0x202b, 0x202c, 0x202d, 0x202e],
  isolates: [0x2066, 0x2067, 0x2068, 0x2069],
};

test('characters that steer a terminal or reorder text become visible', async (t) => {
  for (const [name, codes] of Object.entries(kHarmful)) {
    await t.test(name, () => {
      for (const code of codes) {
        const text = `a${String.fromCharCode(code)}b`;
        const escaped = `a\\u${code.toString(16).padStart(4, '0')}b`;
        assert.equal(printable(text), escaped);
        assert.equal(printableLine(text), escaped);
        assert.equal(oneLine(text), 'a b');
      }
    });
  }
});

test('all other text is left as it is', () => {
  // The neighbours of the ranges, and joiners, which Persian and emoji need.
  const text =
    'Škofja Loka \u00a0\u061b\u200b\u200c\u200d\u2010\u2027\u202f\u2065\u206a 東京 🏔️ \\n';
  assert.equal(printable(text), text);
  assert.equal(printableLine(text), text);
  assert.equal(oneLine(text), text);
});

test('line breaks and tabs stay in a block of text; a line has no line breaks', () => {
  assert.equal(printable('a\tb\nc\n'), 'a\tb\nc\n');
  assert.equal(printableLine('a\tb\nc'), 'a\tb\\u000ac');
});

test('JSON text stays valid and keeps its meaning', () => {
  const value = { name: 'a\u001b[31m\u007f\u009b\u202e\u2028\n"b' };
  for (const text of [JSON.stringify(value), JSON.stringify(value, undefined, 2)]) {
    assert.notEqual(printable(text), text);
    assert.deepEqual(JSON.parse(printable(text)), value);
  }
});

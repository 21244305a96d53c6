import assert from 'node:assert/strict';
import { test } from 'node:test';
import { countLines } from './coverage.js';

const kSource = ['function f(a) {', '  if (a) {', '    g();', '  }', '', '  h();', '}', ''].join(
  '\n',
);
const kBranch = kSource.indexOf('{', kSource.indexOf('if'));

/** A function whose body ran, and a branch in it that ran or not. */
function functions(branch: number): Parameters<typeof countLines>[1] {
  const whole = { startOffset: 0, endOffset: kSource.length - 1, count: 1 };
  const inner = {
    startOffset: kBranch,
    endOffset: kSource.indexOf('}') + 1,
    count: branch,
  };
  return [{ functionName: 'f', isBlockCoverage: true, ranges: [whole, inner] }];
}

test('lines of branches that did not run are not counted, nor empty ones', () => {
  assert.equal(countLines(kSource, functions(1)), 6);
  assert.equal(countLines(kSource, functions(0)), 4);
});

test('without a function that ran there are no lines', () => {
  assert.equal(countLines(kSource, []), 0);
});

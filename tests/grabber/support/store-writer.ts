import { writeSync } from 'node:fs';
import { openStore } from '../../../grabber/src/store/open-store.js';
import { catalogueSquare, kTerms, kVerified, keyOfSquare, storedFile } from './record-fixture.js';

/**
 * Waits for a reader that is slow: process.stdout would queue the text, and a kill would lose
 * reports of calls that have returned.
 */
function report(text: string): void {
  for (let rest = Buffer.from(text); rest.length > 0;) {
    try {
      rest = rest.subarray(writeSync(1, rest));
    } catch (error) {
      if (!(error instanceof Error && 'code' in error && error.code === 'EAGAIN')) throw error;
    }
  }
}

/**
 * A child that tests kill: works through squares one after the other, and reports each call once it
 * has returned.
 */
const [root = '', first = '0'] = process.argv.slice(2);
const store = openStore(root, {}, new AbortController().signal);
for (let e = Number(first); ; ++e) {
  const key = keyOfSquare(`${e}_101`);
  const calls: [string, () => void][] = [
    [
      'known',
      () =>
        void store.squares.learn('si-lss', 'si-lss', 'EPSG:3794', kTerms, [
          catalogueSquare(e, 101),
        ]),
    ],
    ['wanted', () => void store.squares.want([key])],
    ['fetching', () => store.squares.begin(key, 'http://h')],
    ['fetched', () => store.squares.fetched(key, storedFile(key.name))],
    ['verified', () => store.squares.verified(key, kVerified)],
  ];
  for (const [state, call] of calls) {
    call();
    report(`${e} ${state}\n`);
  }
}

import { kMaxSquares, parseSquare, squareAt, type Grid, type Square } from '../sources/square.js';
import { usage } from './usage.js';

/** Becomes a file name in the store. */
const kPlainName = /^[\p{L}\p{N}][\p{L}\p{N} ._()+-]{0,118}(?<! )$/u;

/**
 * Squares of a grid by name, or by the names of two corner squares: `462_101:465_103` is all
 * twelve.
 */
export function squaresByName(names: readonly string[], grid: Grid): Square[] {
  const found = new Map<string, Square>();
  for (const name of names) {
    for (const square of oneOrRange(name, grid)) {
      found.set(square.name, square);
      if (found.size > kMaxSquares) {
        throw usage(
          `read --squares: ${name} makes more than ${kMaxSquares} squares; allowed: at ` +
            `most ${kMaxSquares}`,
        );
      }
    }
  }
  return [...found.values()];
}

function* oneOrRange(text: string, grid: Grid): Generator<Square> {
  const ends = text.split(':');
  if (ends.length > 2) throw usage(`read --squares: "${text}"; allowed: E_N or a range E_N:E_N`);
  const [from, to] = ends.map((name) => parseSquare(name, grid).corner);
  if (from === undefined) return;
  const last = to ?? from;
  if (last.east_m < from.east_m || last.north_m < from.north_m) {
    throw usage(
      `read --squares: "${text}"; allowed: a range from its south-west square to its ` +
        'north-east square',
    );
  }
  for (let north = from.north_m; north <= last.north_m; north += grid.square_m) {
    for (let east = from.east_m; east <= last.east_m; east += grid.square_m) {
      yield squareAt(east, north);
    }
  }
}

/** @return undefined for a name that the store could not give a file */
export function plainSquareOrNone(name: string): Square | undefined {
  return kPlainName.test(name) ? { name, corner: undefined } : undefined;
}

/** A square of which only the name matters. */
export function plainSquare(name: string): Square {
  if (kPlainName.test(name)) return { name, corner: undefined };
  throw usage(
    `read square name: "${name}"; allowed: letters, digits, spaces, and ".", "_", "-", ` +
      '"+", "(" and ")", at most 120, the first a letter or digit',
  );
}

import type { CatalogueSquare } from '../../model/square.js';
import type { Region } from '../../model/store.js';
import { GrabberError } from '../../util/errors.js';
import { compareText } from '../../util/order.js';

/** Whether a square is requested. Squares without bounds are known by their name only. */
export function isInRegion(
  square: Pick<CatalogueSquare, 'name' | 'bounds'>,
  region: Region,
): boolean {
  if (region.names !== undefined) return region.names.has(square.name);
  return square.bounds === null || region.touches(square.bounds);
}

/** From south to north, then west to east; squares without bounds come last, by name. */
export function byPlace(a: CatalogueSquare, b: CatalogueSquare): number {
  if (a.bounds !== null && b.bounds !== null) {
    return a.bounds[1] - b.bounds[1] || a.bounds[0] - b.bounds[0] || byName(a, b);
  }
  if (a.bounds === null && b.bounds === null) return byName(a, b);
  return a.bounds === null ? 1 : -1;
}

function byName(a: CatalogueSquare, b: CatalogueSquare): number {
  return compareText(a.name, b.name);
}

/** @param what such as "list si-clss" */
export function catalogueError(
  what: string,
  found: string,
  allowed: string,
  cause?: unknown,
): GrabberError {
  return new GrabberError(
    'CATALOGUE',
    `${what}: ${found}; allowed: ${allowed}`,
    cause === undefined ? {} : { cause },
  );
}

/** Squares of a catalogue as they come in: the newest of each name, and never more than allowed. */
export class Listing {
  readonly #what: string;
  readonly #maxSquares: number;
  readonly #newest = new Map<string, { readonly square: CatalogueSquare; readonly rank: string }>();

  constructor(what: string, maxSquares: number) {
    this.#what = what;
    this.#maxSquares = maxSquares;
  }

  /** @param rank of two squares with one name the one with the higher rank (by text) is kept */
  add(square: CatalogueSquare, rank: string): void {
    const before = this.#newest.get(square.name);
    if (before !== undefined && before.rank >= rank) return;
    this.#newest.set(square.name, { square, rank });
    if (this.#newest.size > this.#maxSquares) {
      throw catalogueError(
        this.#what,
        `more than ${this.#maxSquares} squares`,
        `at most ${this.#maxSquares} a run; choose less ground`,
      );
    }
  }

  sorted(): CatalogueSquare[] {
    return [...this.#newest.values()].map(({ square }) => square).sort(byPlace);
  }
}

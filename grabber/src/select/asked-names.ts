import type { CatalogueSquare } from '../model/square.js';
import type { Catalogue, Region } from '../model/store.js';
import { plain } from './ad-hoc-catalogue.js';
import { gridSquare } from '../sources/catalogue/template-catalogue.js';
import { parseSquare } from '../sources/square.js';

/**
 * Squares that were asked for by name and that the catalogue does not have come too, last and without addresses, and
 * locate() finds none for them: whoever works through the squares then reports them as missing, and forgets none.
 * @param complete asked at the end: false where a square may be in what could not be read, so that nobody calls it missing
 */
export function withAskedNames(catalogue: Catalogue, square_m: number | null, complete: () => boolean): Catalogue {
  const unlisted = new Set<string>();
  async function* find(region: Region, signal: AbortSignal): AsyncGenerator<CatalogueSquare> {
    const left = new Set(region.names);
    for await (const square of catalogue.find(region, signal)) {
      left.delete(square.name);
      yield square;
    }
    if (!complete()) return;
    for (const name of left) {
      unlisted.add(name);
      yield square_m === null ? plain(name, []) : gridSquare(parseSquare(name, { square_m, extent_m: undefined }), square_m, null, []);
    }
  }
  return {
    find,
    locate: async (square, near, there, signal) =>
      unlisted.has(square.name) ? undefined : await catalogue.locate?.(square, near, there, signal),
  };
}

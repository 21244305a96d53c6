import type { CatalogueSquare } from '../model/square.js';
import type { Catalogue, Region } from '../model/store.js';
import { nameOnlySquare } from './ad-hoc-catalogue.js';
import { gridSquare } from '../sources/catalogue/template-catalogue.js';
import { parseSquare } from '../sources/square.js';

/**
 * Adds the squares that were requested by name and that the catalogue lacks, last and without
 * addresses; locate() finds none for them, so that they are reported as missing.
 * @param complete called at the end: false when unreadable entries may hold a square, which then
 *   must not be reported as missing
 */
export function withRequestedNames(
  catalogue: Catalogue,
  square_m: number | null,
  complete: () => boolean,
): Catalogue {
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
      yield square_m === null
        ? nameOnlySquare(name, [])
        : gridSquare(parseSquare(name, { square_m, extent_m: undefined }), square_m, null, []);
    }
  }
  return {
    find,
    locate: async (square, near, exists, signal) =>
      unlisted.has(square.name)
        ? undefined
        : await catalogue.locate?.(square, near, exists, signal),
  };
}

import type { CatalogueSquare } from '../../model/square.js';
import type { Catalogue, Region } from '../../model/store.js';
import { intersectBounds } from '../../geo/bounds.js';
import { boundsOfSquare } from '../naming.js';
import type { Source } from '../source.js';
import { parseSquare, squareAt, type Grid, type Square } from '../square.js';
import { findBlockVariable, chooseVariables } from '../variables.js';
import { isInRegion, Listing } from './listing.js';
import type { CatalogueSettings } from './options.js';
import { makeAddresses } from './probe.js';

/**
 * Lists the squares of a computed grid without a request, so some of them may not exist.
 * @throws GrabberError USAGE
 */
export function templateCatalogue(source: Source, settings: CatalogueSettings): Catalogue {
  const size = source.square_m ?? 1000;
  const chosen = chooseVariables(source, settings.variables);
  const blockVariable = findBlockVariable(source);
  const block = blockVariable === undefined ? null : (chosen.given[blockVariable] ?? null);
  const addresses = makeAddresses(source, chosen, blockVariable);

  async function* find(region: Region, signal: AbortSignal): AsyncGenerator<CatalogueSquare> {
    const listing = new Listing(`list ${source.id}`, settings.maxSquares);
    for (const square of gridSquares(region, { square_m: size, extent_m: source.extent_m })) {
      const bounds = boundsOfSquare(square, size);
      if (isInRegion({ name: square.name, bounds }, region)) {
        listing.add(gridSquare(square, size, block, addresses.of(square, block)), '');
      }
    }
    for (const square of listing.sorted()) {
      signal.throwIfAborted();
      yield square;
    }
  }

  if (chosen.probed === undefined) return { find };
  return {
    find,
    locate: (square, near, exists, signal) =>
      addresses.locate(
        square,
        parseSquare(square.name, { square_m: size, extent_m: source.extent_m }),
        near,
        exists,
        signal,
      ),
  };
}

export function gridSquare(
  square: Square,
  size: number,
  block: string | null,
  urls: readonly string[],
): CatalogueSquare {
  return {
    name: square.name,
    block,
    bounds: boundsOfSquare(square, size),
    urls,
    bytes: null,
    sha256: null,
    member: null,
    published: null,
  };
}

/**
 * Those named, or all of the box around the region that lie in the grid's extent.
 * @throws GrabberError USAGE for a name that is none
 */
export function* gridSquares(region: Region, grid: Grid): Generator<Square> {
  if (region.names !== undefined) {
    for (const name of region.names) yield parseSquare(name, grid);
    return;
  }
  const size = grid.square_m;
  const box =
    grid.extent_m === undefined ? region.bounds : intersectBounds(region.bounds, grid.extent_m);
  if (box === undefined) return;
  for (let north = Math.floor(box[1] / size) * size; north < box[3]; north += size) {
    for (let east = Math.floor(box[0] / size) * size; east < box[2]; east += size) {
      yield squareAt(east, north);
    }
  }
}

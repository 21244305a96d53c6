import type { CatalogueSquare, Catalogue, Region } from '../../model/store.js';
import { intersectBounds } from '../../geo/bounds.js';
import { boundsOfSquare } from '../naming.js';
import type { Source } from '../source.js';
import { parseSquare, squareAt, type Grid, type Square } from '../square.js';
import { makeAddresses, toGrid } from '../addresses.js';
import { isInRegion, Listing, type CatalogueSettings } from './listing.js';

/**
 * Lists the squares of a computed grid without a request, so some of them may not exist.
 * @throws GrabberError USAGE
 */
export function templateCatalogue(source: Source, settings: CatalogueSettings): Catalogue {
  const grid = toGrid(source);
  const addresses = makeAddresses(source, settings.variables);
  const { block, locate } = addresses;
  function* list(region: Region): Generator<CatalogueSquare> {
    for (const square of gridSquares(region, grid)) {
      yield gridSquare(square, grid.square_m, block, addresses.of(square, block));
    }
  }
  const what = `list ${source.id}`;
  return {
    find: (region, signal) => inOrder(what, settings.maxSquares, list(region), signal),
    locate,
  };
}

/** @throws GrabberError CATALOGUE for more squares than a run may have */
export async function* inOrder(
  what: string,
  maxSquares: number,
  squares: Iterable<CatalogueSquare>,
  signal: AbortSignal,
): AsyncGenerator<CatalogueSquare> {
  const listing = new Listing(what, maxSquares);
  for (const square of squares) listing.add(square, '');
  for (const square of listing.sorted()) {
    signal.throwIfAborted();
    yield square;
  }
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
 * The squares of a grid that are requested.
 * @throws GrabberError USAGE for a name that is none
 */
export function* gridSquares(region: Region, grid: Grid): Generator<Square> {
  for (const square of candidates(region, grid)) {
    const bounds = boundsOfSquare(square, grid.square_m);
    if (isInRegion({ name: square.name, bounds }, region)) yield square;
  }
}

/** Those named, or all of the box around the region that lie in the grid's extent. */
function* candidates(region: Region, grid: Grid): Generator<Square> {
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

import type { CatalogueSquare } from '../model/square.js';
import type { Catalogue, Region } from '../model/store.js';
import { isInRegion, Listing } from '../sources/catalogue/listing.js';
import { gridSquare, gridSquares } from '../sources/catalogue/template-catalogue.js';
import { boundsOfSquare } from '../sources/naming.js';
import { kMaxSquares, type Square } from '../sources/square.js';
import { expandTemplate, type Variables } from '../sources/url-template.js';
import { kAdHocSquareM } from './ad-hoc.js';

/**
 * Squares at an address that was typed.
 * @param plainNames names are just names, no places of a grid
 */
export function adHocCatalogue(template: string, given: Variables, plainNames: boolean): Catalogue {
  const toUrls = (square: Square): string[] => [expandTemplate(template, square, given)];
  async function* find(region: Region, signal: AbortSignal): AsyncGenerator<CatalogueSquare> {
    const listing = new Listing(`list ${template}`, kMaxSquares);
    if (plainNames && region.names !== undefined) {
      for (const name of region.names) {
        listing.add(nameOnlySquare(name, toUrls({ name, corner: undefined })), '');
      }
    } else {
      for (const square of gridSquares(region, { square_m: kAdHocSquareM, extent_m: undefined })) {
        const bounds = boundsOfSquare(square, kAdHocSquareM);
        if (isInRegion({ name: square.name, bounds }, region)) {
          listing.add(gridSquare(square, kAdHocSquareM, null, toUrls(square)), '');
        }
      }
    }
    for (const square of listing.sorted()) {
      signal.throwIfAborted();
      yield square;
    }
  }
  return { find };
}

/** A file of which only the name is known. */
export function nameOnlySquare(name: string, urls: readonly string[]): CatalogueSquare {
  return {
    name,
    block: null,
    bounds: null,
    urls,
    bytes: null,
    sha256: null,
    member: null,
    published: null,
  };
}

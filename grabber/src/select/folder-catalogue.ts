import { pathToFileURL } from 'node:url';
import type { CatalogueSquare } from '../model/square.js';
import type { Catalogue, Region } from '../model/store.js';
import { byPlace, isInRegion } from '../sources/catalogue/listing.js';
import { gridSquare, gridSquares } from '../sources/catalogue/template-catalogue.js';
import { fileNameReader } from '../sources/naming.js';
import type { Source } from '../sources/source.js';
import type { Square } from '../sources/square.js';
import { GrabberError } from '../util/errors.js';
import { nameOnlySquare } from './ad-hoc-catalogue.js';
import { chooseBest, findPointFiles, type PointFile } from './point-files.js';
import { plainSquareOrNone } from './square-names.js';
import { usage } from './usage.js';

export type FolderCatalogue = {
  readonly catalogue: Catalogue;
  /** Files whose name is none of the source's. */
  readonly ignored: readonly string[];
};

type SquareFiles = { readonly square: Square; readonly files: PointFile[] };

/**
 * Point clouds below a folder; addresses are file: ones. With a source whose squares have a grid,
 * file names give the place, and squares of a region that the folder lacks come without an address:
 * they are holes.
 */
export async function openFolder(
  folder: string,
  source: Source | undefined,
  signal: AbortSignal,
): Promise<FolderCatalogue> {
  const size = source?.square_m;
  const readName =
    source === undefined || size === undefined ? plainSquareOrNone : fileNameReader(source);
  const bySquare = new Map<string, SquareFiles>();
  const ignored: string[] = [];
  for (const file of await findPointFiles(folder, signal)) {
    const square = readName(file.stem);
    if (square === undefined) {
      ignored.push(file.path);
      continue;
    }
    const same = bySquare.get(square.name);
    if (same === undefined) bySquare.set(square.name, { square, files: [file] });
    else same.files.push(file);
  }
  if (bySquare.size === 0) {
    const named = source === undefined ? '' : ` named as those of ${source.id}`;
    throw usage(
      `read folder ${folder}: it holds no files of squares; allowed: at least one .laz, ` +
        `.las or .zlas${named}`,
    );
  }

  async function* find(region: Region, stop: AbortSignal): AsyncGenerator<CatalogueSquare> {
    const found = new Map<string, CatalogueSquare>();
    for (const { square, files } of bySquare.values()) {
      const one =
        size === undefined ? nameOnlySquare(square.name, []) : gridSquare(square, size, null, []);
      if (isInRegion(one, region)) {
        found.set(one.name, { ...one, urls: [chooseAddress(square.name, files)] });
      }
    }
    for (const one of listHoles(region, source)) if (!found.has(one.name)) found.set(one.name, one);
    for (const one of [...found.values()].sort(byPlace)) {
      stop.throwIfAborted();
      yield one;
    }
  }
  return { catalogue: { find, locate: () => Promise.resolve(undefined) }, ignored };
}

function chooseAddress(name: string, files: readonly PointFile[]): string {
  const [file, second] = chooseBest(files);
  if (file === undefined || second !== undefined) {
    throw new GrabberError(
      'AMBIGUOUS_FILE',
      `copy square ${name}: ${file?.path ?? ''} and ${second?.path ?? ''} both claim it; ` +
        'allowed: one file',
    );
  }
  return pathToFileURL(file.path).href;
}

/** All squares a region of limited size should have. */
function* listHoles(region: Region, source: Source | undefined): Generator<CatalogueSquare> {
  if (source?.square_m === undefined || !Number.isFinite(region.bounds[0])) return;
  for (const square of gridSquares(region, {
    square_m: source.square_m,
    extent_m: source.extent_m,
  })) {
    const one = gridSquare(square, source.square_m, null, []);
    if (isInRegion(one, region)) yield one;
  }
}

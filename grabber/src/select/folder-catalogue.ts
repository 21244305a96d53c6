import { pathToFileURL } from 'node:url';
import { readdir } from 'node:fs/promises';
import { join } from 'node:path';
import type { CatalogueSquare, Catalogue, Region } from '../model/store.js';
import { byPlace, isInRegion } from '../sources/catalogue/listing.js';
import { gridSquare, gridSquares } from '../sources/catalogue/template-catalogue.js';
import { fileNameReader } from '../sources/naming.js';
import type { Source } from '../sources/source.js';
import type { Square } from '../sources/square.js';
import { GrabberError, usage, causedError } from '../util/errors.js';
import { nameOnlySquare } from './ad-hoc.js';
import { plainSquareOrNone } from './region.js';
import { toGrid } from '../sources/addresses.js';

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
    const { files } = bySquare.get(square.name) ?? { files: [] };
    bySquare.set(square.name, { square, files: [...files, file] });
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
  for (const square of gridSquares(region, toGrid(source))) {
    yield gridSquare(square, source.square_m, null, []);
  }
}

/** Best first: of one square's files the one that can be used as it is and is smallest. */
const kExtensions = ['laz', 'las', 'zlas'] as const;
type Extension = (typeof kExtensions)[number];

const kPointFile = /^(.+?)(?:\.copc)?\.(laz|las|zlas)$/i;

export type PointFile = {
  readonly path: string;
  readonly stem: string;
  readonly extension: Extension;
};

/**
 * Every LAZ, LAS and zLAS file below a folder, sorted by path; files and folders whose name starts
 * with a dot are none.
 */
export async function findPointFiles(folder: string, signal: AbortSignal): Promise<PointFile[]> {
  const files: PointFile[] = [];
  const waiting = [folder];
  for (let next = waiting.pop(); next !== undefined; next = waiting.pop()) {
    signal.throwIfAborted();
    for (const entry of await listFolder(next)) {
      if (entry.name.startsWith('.')) continue;
      const path = join(next, entry.name);
      if (entry.isDirectory()) waiting.push(path);
      const match = entry.isDirectory() ? null : kPointFile.exec(entry.name);
      if (match?.[1] === undefined || match[2] === undefined) continue;
      files.push({ path, stem: match[1], extension: match[2].toLowerCase() as Extension });
    }
  }
  return files.sort((a, b) => (a.path < b.path ? -1 : 1));
}

async function listFolder(folder: string) {
  try {
    return await readdir(folder, { withFileTypes: true });
  } catch (error) {
    throw causedError('USAGE', `read folder ${folder}`, error, 'a folder that can be read');
  }
}

/**
 * Those of the best kind there is.
 * @param files of one square
 */
export function chooseBest(files: readonly PointFile[]): readonly PointFile[] {
  const extension = kExtensions.find((wanted) => files.some((file) => file.extension === wanted));
  return files.filter((file) => file.extension === extension);
}

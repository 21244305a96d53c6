import { findPointFiles, type LocalFile } from '../fetch/local-origin.js';
import { profileOf, type SourceProfile } from '../sources/profile.js';
import type { Source } from '../sources/source.js';
import { squareAt, type Square } from '../sources/square.js';
import { stemReader } from '../sources/url-template.js';
import { adHocProfile, chosenSquares, findSource, plainSquare, usage, type SelectionOptions } from './selection.js';

export type LocalSelection = {
  readonly profile: SourceProfile;
  readonly squares: readonly Square[];
  /** By square name. */
  readonly files: ReadonlyMap<string, readonly LocalFile[]>;
  /** Files whose name is not one of the source's. */
  readonly ignored: readonly string[];
};

/** Squares of a folder: all of its files, or those chosen by --squares or --bbox. */
export async function localSelection(
  folder: string,
  options: SelectionOptions,
  sources: ReadonlyMap<string, Source>,
  signal: AbortSignal,
): Promise<LocalSelection> {
  const source = findSource(options, sources);
  const needless = {
    '--url-template': options.urlTemplate,
    '--block': options.block,
    '--set': options.set,
    '--missing-status': options.missingStatus,
  };
  const clash = Object.entries(needless).find(([, value]) => value !== undefined);
  if (clash !== undefined)
    throw usage(`read folder ${folder}: ${clash[0]} with --from; allowed: only for web addresses`);
  if (source === undefined && options.bbox !== undefined) {
    throw usage(
      'choose squares: --bbox with --from but without --source; allowed: with --source, whose file names tell the place',
    );
  }
  const chosen = chosenSquares(options, source, source === undefined);
  const readSquare = source === undefined ? plainSquareOf : gridSquareOf(source);

  const files = new Map<string, LocalFile[]>();
  const found: Square[] = [];
  const ignored: string[] = [];
  for (const file of await findPointFiles(folder, signal)) {
    const square = readSquare(file);
    if (square === undefined) {
      ignored.push(file.path);
      continue;
    }
    const same = files.get(square.name);
    if (same === undefined) {
      files.set(square.name, [file]);
      found.push(square);
    } else {
      same.push(file);
    }
  }
  if (chosen === undefined && found.length === 0) {
    throw usage(
      `read folder ${folder}: it holds no files of squares; allowed: at least one .laz, .las or .zlas${source === undefined ? '' : ` named as those of ${source.id}`}`,
    );
  }
  return {
    profile: source === undefined ? adHocProfile(options, 'local') : profileOf(source),
    squares: chosen ?? found,
    files,
    ignored,
  };
}

function plainSquareOf(file: LocalFile): Square {
  return plainSquare(file.stem);
}

function gridSquareOf(source: Source): (file: LocalFile) => Square | undefined {
  const readStem = stemReader(source.url);
  return (file) => {
    const corner = readStem(file.stem);
    return corner === undefined ? undefined : squareAt(corner.east_m, corner.north_m);
  };
}

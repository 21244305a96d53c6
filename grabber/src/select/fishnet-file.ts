import { readVectorFile, type VectorFeature } from '../geo/vector-file.js';
import type { CatalogueSquare } from '../model/store.js';
import { makeAddresses, findBlockVariable } from '../sources/addresses.js';
import { gridSquare } from '../sources/catalogue/template-catalogue.js';
import { byPlace } from '../sources/catalogue/listing.js';
import { onGrid } from '../sources/naming.js';
import { listVariables, type Source } from '../sources/source.js';
import type { Square, Variables } from '../sources/square.js';
import { GrabberError } from '../util/errors.js';

/**
 * Names of the columns; left out, those of the official fishnets of Slovenia, and a block or centre
 * may lack.
 */
export type FishnetFields = {
  readonly [field in keyof typeof kOfficial]?: string | undefined;
};

const kOfficial = { name: 'NAME', block: 'BLOK', x: 'CENTERX', y: 'CENTERY' } as const;
/** `462_101`, `TM_462_101`, `GK_462_101` */
const kName = /^(?:[A-Za-z]{1,8}_)?(\d{1,5})_(\d{1,5})$/;
const kMaxRows = 1_000_000;

/**
 * Squares of a fishnet file: Shapefile, bare DBF, GeoJSON, GeoPackage.
 * @throws GrabberError FISHNET; no row is left out
 */
export async function readFishnet(
  file: string,
  source: Source,
  fields: FishnetFields,
  given: Variables,
  signal: AbortSignal,
): Promise<CatalogueSquare[]> {
  const size = source.square_m;
  if (size === undefined) {
    throw fishnetError(file, `source ${source.id} has no grid`, 'sources with square_m');
  }
  const features = await readVectorFile(file, { code: 'FISHNET', what: 'read fishnet' }, signal);
  if (features.length === 0 || features.length > kMaxRows) {
    throw fishnetError(file, `${features.length} rows`, `1 to ${kMaxRows}`);
  }
  const readRow = rowReader(file, source, size, fields, given, listColumns(features));
  const squares = new Map<string, CatalogueSquare>();
  features.forEach((feature, index) => {
    const square = readRow(feature, index + 1);
    const before = squares.get(square.name);
    if (before !== undefined && before.block !== square.block) {
      throw fishnetError(
        file,
        `row ${index + 1}: square ${square.name} of blocks ${before.block} and ${square.block}`,
        'one block',
      );
    }
    squares.set(square.name, square);
  });
  return [...squares.values()].sort(byPlace);
}

function rowReader(
  file: string,
  source: Source,
  size: number,
  fields: FishnetFields,
  given: Variables,
  columns: ReadonlySet<string>,
) {
  const column = {
    name: findColumn('name', fields, columns, true, file),
    block: findColumn('block', fields, columns, false, file),
    x: findColumn('x', fields, columns, false, file),
    y: findColumn('y', fields, columns, false, file),
  };
  const addresses = makeAddresses(source, given);
  const blockVariable = findBlockVariable(source);
  return (feature: VectorFeature, row: number): CatalogueSquare => {
    const name = cell(feature, column.name);
    const square = squareFromName(name, size);
    if (square === undefined) {
      throw fishnetError(
        file,
        `row ${row}: name "${name ?? ''}"`,
        'E_N in kilometres, such as 462_101 or TM_462_101',
      );
    }
    checkCentre(file, row, square, size, cell(feature, column.x), cell(feature, column.y));
    const block = knownBlock(source, blockVariable, cell(feature, column.block), file, row);
    return gridSquare(square, size, block, addresses.of(square, block));
  };
}

function listColumns(features: readonly VectorFeature[]): ReadonlySet<string> {
  return new Set(features.flatMap((feature) => Object.keys(feature.properties ?? {})));
}

function findColumn(
  what: keyof typeof kOfficial,
  fields: FishnetFields,
  columns: ReadonlySet<string>,
  needed: boolean,
  file: string,
): string | undefined {
  const wanted = fields[what] ?? kOfficial[what];
  const found = [...columns].find((column) => column.toLowerCase() === wanted.toLowerCase());
  if (found === undefined && (needed || fields[what] !== undefined)) {
    throw fishnetError(
      file,
      `no column ${wanted}`,
      `one of ${[...columns].join(', ') || 'none, it has no columns'} (--${what}-field)`,
    );
  }
  return found;
}

function cell(feature: VectorFeature, column: string | undefined): string | undefined {
  const value = column === undefined ? undefined : feature.properties?.[column];
  return typeof value === 'string' || typeof value === 'number' ? String(value).trim() : undefined;
}

function squareFromName(name: string | undefined, size: number): Square | undefined {
  const match = kName.exec(name ?? '');
  return match === null
    ? undefined
    : onGrid(Number(match[1]) * 1000, Number(match[2]) * 1000, size);
}

/** Detects a fishnet of another grid, or with swapped axes, before its names fill a store. */
function checkCentre(
  file: string,
  row: number,
  square: Square,
  size: number,
  x: string | undefined,
  y: string | undefined,
): void {
  if (x === undefined || y === undefined || square.corner === undefined) return;
  const { east_m, north_m } = square.corner;
  const inside = (value: string, low: number): boolean =>
    Number(value) > low && Number(value) < low + size;
  if (inside(x, east_m) && inside(y, north_m)) return;
  throw fishnetError(
    file,
    `row ${row}: the centre of square ${square.name} is ${x},${y}`,
    `within ${east_m},${north_m},${east_m + size},${north_m + size}`,
  );
}

/** Spelled as the source's addresses have it: a fishnet may say 35 or B_35 for b_35. */
function knownBlock(
  source: Source,
  variable: string | undefined,
  block: string | undefined,
  file: string,
  row: number,
): string | null {
  if (block === undefined || block === '') return null;
  const values = variable === undefined ? undefined : listVariables(source)[variable]?.values;
  if (values === undefined) return block;
  const lowerCase = block.toLowerCase();
  const found =
    values.find((value) => value.toLowerCase() === lowerCase) ??
    values.find((value) => value.replace(/^\D+/, '') === lowerCase);
  if (found === undefined) {
    throw fishnetError(file, `row ${row}: block "${block}"`, `one of ${values.join(', ')}`);
  }
  return found;
}

function fishnetError(file: string, found: string, allowed: string): GrabberError {
  return new GrabberError('FISHNET', `read fishnet ${file}: ${found}; allowed: ${allowed}`);
}

import type { BoundsM } from '../model/store.js';
import { squareAt, type Square, stemReader } from './square.js';
import { listTemplates, type Source } from './source.js';

/**
 * Reads the place of a square out of the name a source gives it; undefined when the name is not of
 * that form.
 */
export type NameReader = (name: string) => Square | undefined;

/**
 * @param pattern groups E and N (kilometres) or x and y (metres); not anchored
 * @param corner the one that they refer to
 */
export function patternReader(pattern: string, corner: 'sw' | 'nw', square_m: number): NameReader {
  const reader = new RegExp(pattern, 'i');
  return (name) => {
    const groups = reader.exec(name)?.groups;
    if (groups === undefined) return undefined;
    const east_m =
      groups['E'] !== undefined ? Number(groups['E']) * 1000 : Number(groups['x'] ?? NaN);
    const north_m =
      groups['N'] !== undefined ? Number(groups['N']) * 1000 : Number(groups['y'] ?? NaN);
    return onGrid(east_m, corner === 'nw' ? north_m - square_m : north_m, square_m);
  };
}

/**
 * Reads file names of a source, without their extension, as its addresses or its catalogue have
 * them.
 */
export function fileNameReader(source: Source): NameReader {
  const { access, square_m } = source;
  if (square_m === undefined) return () => undefined;
  const readers: NameReader[] = listTemplates(source).map((template) => {
    const read = stemReader(template);
    return (stem) => {
      const corner = read(stem);
      return corner === undefined ? undefined : onGrid(corner.east_m, corner.north_m, square_m);
    };
  });
  if (access.kind !== 'template' && access.name_pattern !== undefined) {
    readers.push(patternReader(access.name_pattern, access.name_corner, square_m));
  }
  return (stem) => {
    for (const read of readers) {
      const square = read(stem);
      if (square !== undefined) return square;
    }
    return undefined;
  };
}

/** @return undefined when the corner is none of the grid's */
export function onGrid(east_m: number, north_m: number, square_m: number): Square | undefined {
  const fits = (value: number): boolean => Number.isSafeInteger(value) && value % square_m === 0;
  return fits(east_m) && fits(north_m) ? squareAt(east_m, north_m) : undefined;
}

/** @return null for a square without a corner */
export function boundsOfSquare(square: Square, square_m: number): BoundsM | null {
  if (square.corner === undefined) return null;
  const { east_m, north_m } = square.corner;
  return [east_m, north_m, east_m + square_m, north_m + square_m];
}

import type { BoundsM } from '../model/square.js';
import { GrabberError } from '../util/errors.js';

/**
 * A square of a source's kilometre grid, or a file known only by its name (then without a corner).
 */
export type Square = {
  readonly name: string;
  /** South-west corner, metres in the source's CRS. */
  readonly corner: { readonly east_m: number; readonly north_m: number } | undefined;
};

export type { BoundsM };

/** What is known of the grid; ad-hoc templates have no extent. */
export type Grid = {
  readonly square_m: number;
  readonly extent_m: BoundsM | undefined;
};

/** A typing error must not become a million requests to a portal. */
export const kMaxSquares = 20_000;

const kGridName = /^(-?\d{1,5})_(-?\d{1,5})$/;

export function squareAt(east_m: number, north_m: number): Square {
  return { name: `${east_m / 1000}_${north_m / 1000}`, corner: { east_m, north_m } };
}

/** @param name `E_N`, the south-west corner in kilometres, such as 462_101 */
export function parseSquare(name: string, grid: Grid): Square {
  const match = kGridName.exec(name);
  if (match === null) {
    throw new GrabberError(
      'USAGE',
      `read square name: "${name}"; allowed: E_N in kilometres, such as 462_101`,
    );
  }
  const square = squareAt(Number(match[1]) * 1000, Number(match[2]) * 1000);
  const { east_m, north_m } = square.corner ?? { east_m: 0, north_m: 0 };
  if (east_m % grid.square_m !== 0 || north_m % grid.square_m !== 0) {
    throw new GrabberError(
      'USAGE',
      `read square name: "${name}"; allowed: multiples of the square size, ` +
        `${grid.square_m / 1000} km`,
    );
  }
  checkExtent(
    `read square name: "${name}"`,
    [east_m, north_m, east_m + grid.square_m, north_m + grid.square_m],
    grid,
  );
  return square;
}

/** Catches degrees, swapped axes and the wrong country before any request is sent. */
function checkExtent(shown: string, box: BoundsM, grid: Grid): void {
  if (grid.extent_m === undefined) return;
  const [west, south, east, north] = grid.extent_m;
  if (box[0] < east && box[2] > west && box[1] < north && box[3] > south) return;
  throw new GrabberError(
    'USAGE',
    `${shown} lies outside the source; allowed: ${west},${south},${east},${north} ` +
      '(west,south,east,north in metres)',
  );
}

import type { BoundsM } from '../model/square.js';
import { GrabberError } from '../util/errors.js';

/** The picture to make: a grid of square pixels in one CRS. */
export type Target = {
  readonly crs: string;
  /** Whole pixels. */
  readonly bounds: BoundsM;
  readonly resolution_m: number;
  readonly width_px: number;
  readonly height_px: number;
};

const kMaxPixels = 20_000;

/**
 * A square with ground around it. The grid of pixels goes through the square's south-west corner,
 * so that squares which share an edge share their pixels too wherever the resolution divides the
 * square; the margin is widened to whole pixels.
 */
export function makeTarget(
  square: BoundsM,
  crs: string,
  resolution_m: number,
  margin_m: number,
): Target {
  const [west, south, east, north] = square;
  const around = Math.ceil(margin_m / resolution_m - 1e-9);
  const across = Math.ceil((east - west) / resolution_m - 1e-9);
  const up = Math.ceil((north - south) / resolution_m - 1e-9);
  const width_px = across + 2 * around;
  const height_px = up + 2 * around;
  if (!(width_px >= 1 && height_px >= 1 && width_px <= kMaxPixels && height_px <= kMaxPixels)) {
    throw new GrabberError(
      'USAGE',
      `cut an orthophoto of ${square.join(', ')} at ${resolution_m} m: ${width_px} x ` +
        `${height_px} pixels; allowed: 1 to ${kMaxPixels} each (--resolution-m, --margin-m)`,
    );
  }
  const left = west - around * resolution_m;
  const bottom = south - around * resolution_m;
  const bounds: BoundsM = [
    left,
    bottom,
    left + width_px * resolution_m,
    bottom + height_px * resolution_m,
  ];
  return { crs, bounds, resolution_m, width_px, height_px };
}

/** A part of a target's pixels, counted from its north-west corner. */
export type Block = {
  readonly x_px: number;
  readonly y_px: number;
  readonly width_px: number;
  readonly height_px: number;
};

/**
 * Splits a picture into parts that a server will draw; nearly equal ones, row by row from the
 * north-west.
 */
export function makeBlocks(target: Target, max_px: number): Block[] {
  const columns = edges(target.width_px, max_px);
  const rows = edges(target.height_px, max_px);
  return rows.slice(0, -1).flatMap((y, row) =>
    columns.slice(0, -1).map((x, column) => ({
      x_px: x,
      y_px: y,
      width_px: (columns[column + 1] ?? x) - x,
      height_px: (rows[row + 1] ?? y) - y,
    })),
  );
}

export function boundsOfBlock(target: Target, block: Block): BoundsM {
  const [west, , , north] = target.bounds;
  const step = target.resolution_m;
  return [
    west + block.x_px * step,
    north - (block.y_px + block.height_px) * step,
    west + (block.x_px + block.width_px) * step,
    north - block.y_px * step,
  ];
}

export function overlaps(a: BoundsM, b: BoundsM): boolean {
  return a[0] < b[2] && a[2] > b[0] && a[1] < b[3] && a[3] > b[1];
}

function edges(length_px: number, max_px: number): number[] {
  const parts = Math.ceil(length_px / max_px);
  return Array.from({ length: parts + 1 }, (_unused, part) =>
    Math.round((length_px * part) / parts),
  );
}

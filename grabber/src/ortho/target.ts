import { usage } from '../util/errors.js';
import type { BoundsM } from '../model/store.js';
import type { Gdal } from './gdal.js';

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
    throw usage(
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

function edges(length_px: number, max_px: number): number[] {
  const parts = Math.ceil(length_px / max_px);
  return Array.from({ length: parts + 1 }, (_unused, part) =>
    Math.round((length_px * part) / parts),
  );
}

const kPointsPerEdge = 8;
const kPad_px = 4;

/**
 * The pixels to request from a server that draws in another CRS than the target's: they enclose it,
 * and are as fine. In the target's own CRS it is the target itself, pixel by pixel.
 */
export async function requestGrid(
  target: Target,
  crs: string,
  gdal: Gdal,
  signal: AbortSignal,
): Promise<Target> {
  if (crs === target.crs) return target;
  const { bounds, stretch } = await boundsIn(target, crs, gdal, signal);
  const step = target.resolution_m * stretch;
  const [west, south, east, north] = bounds;
  const pad = kPad_px * step;
  return makeTarget([west - pad, south - pad, east + pad, north + pad], crs, step, 0);
}

/**
 * @return the box of the target in another CRS, and how many of its units a metre of the target has
 */
export async function boundsIn(
  target: Target,
  crs: string,
  gdal: Gdal,
  signal: AbortSignal,
): Promise<{ bounds: BoundsM; stretch: number }> {
  if (crs === target.crs) return { bounds: target.bounds, stretch: 1 };
  const [west, south, east, north] = target.bounds;
  const ring: [number, number][] = [];
  for (let i = 0; i < kPointsPerEdge; ++i) {
    const t = i / kPointsPerEdge;
    const x = west + (east - west) * t;
    const y = south + (north - south) * t;
    ring.push([x, south], [east, y], [east - (x - west), north], [west, north - (y - south)]);
  }
  const projected = await gdal.transform(ring, target.crs, crs, signal);
  const xs = projected.map(([x]) => x);
  const ys = projected.map(([, y]) => y);
  // Along the southern edge, so that a turned grid is not taken for a coarse one.
  const first = projected[0] ?? [0, 0];
  const corner = projected[1] ?? [0, 0];
  const stretch = Math.hypot(corner[0] - first[0], corner[1] - first[1]) / (east - west);
  return { bounds: [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)], stretch };
}

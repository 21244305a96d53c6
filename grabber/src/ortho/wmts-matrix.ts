import type { BoundsM } from '../model/square.js';
import { GrabberError } from '../util/errors.js';
import type { Target } from './target.js';

/** A grid of tiles of one resolution; tile (0, 0) is the north-western one. */
export type TileMatrix = {
  readonly id: string;
  /** Units of the CRS a pixel. */
  readonly resolution_m: number;
  readonly left_m: number;
  readonly top_m: number;
  /** Width, and height too where that is not given. */
  readonly tile_px: number;
  readonly tile_height_px?: number | undefined;
  readonly columns: number;
  readonly rows: number;
};

export type TileRange = {
  readonly column: number;
  readonly row: number;
  readonly columns: number;
  readonly rows: number;
};

const kMaxTiles = 4000;
/** Scale denominators are rounded numbers. */
const kScaleTolerance = 1.01;

/** The coarsest matrix that is as fine as wanted; else the finest there is. */
export function chooseMatrix(
  matrices: readonly TileMatrix[],
  wanted: number,
): TileMatrix | undefined {
  const byStep = [...matrices].sort((a, b) => b.resolution_m - a.resolution_m);
  return byStep.find((matrix) => matrix.resolution_m <= wanted * kScaleTolerance) ?? byStep.at(-1);
}

/** Pixels across and down. */
export function tileSize({ tile_px, tile_height_px = tile_px }: TileMatrix): [number, number] {
  return [tile_px, tile_height_px];
}

/** @return the tiles that touch `bounds`, as far as the matrix goes; undefined when none does */
export function tilesIn(matrix: TileMatrix, bounds: BoundsM): TileRange | undefined {
  const [width, height] = tileSize(matrix).map((side_px) => side_px * matrix.resolution_m) as [
    number,
    number,
  ];
  const [west, south, east, north] = bounds;
  // Room for one pixel around, which resampling reads.
  const pad = matrix.resolution_m;
  const column = Math.max(0, Math.floor((west - pad - matrix.left_m) / width));
  const row = Math.max(0, Math.floor((matrix.top_m - north - pad) / height));
  const columns =
    Math.min(matrix.columns, Math.ceil((east + pad - matrix.left_m) / width)) - column;
  const rows = Math.min(matrix.rows, Math.ceil((matrix.top_m - south + pad) / height)) - row;
  if (columns < 1 || rows < 1) return undefined;
  if (columns * rows > kMaxTiles) {
    throw new GrabberError(
      'ORTHO',
      `gather tiles of matrix ${matrix.id}: ${columns * rows} of them; allowed: at most ` +
        `${kMaxTiles} a square (--resolution-m)`,
    );
  }
  return { column, row, columns, rows };
}

/** The pixels of a range of tiles. */
export function gridOfTiles(matrix: TileMatrix, range: TileRange, crs: string): Target {
  const [width_px, height_px] = tileSize(matrix);
  const width = width_px * matrix.resolution_m;
  const height = height_px * matrix.resolution_m;
  const west = matrix.left_m + range.column * width;
  const north = matrix.top_m - range.row * height;
  return {
    crs,
    bounds: [west, north - range.rows * height, west + range.columns * width, north],
    resolution_m: matrix.resolution_m,
    width_px: range.columns * width_px,
    height_px: range.rows * height_px,
  };
}

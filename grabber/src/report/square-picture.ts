import type { BoundsM, State } from '../model/square.js';
import {
  background,
  foreground,
  kStateSymbols,
  kReset,
  kShownFirst,
  legend,
  type PictureStyle,
} from './state-symbols.js';

export type PlacedState = { readonly state: State; readonly bounds: BoundsM };
export type PictureSize = { readonly columns: number; readonly rows: number };

/** States by picture element, rows from north to south. */
type Raster = { readonly width: number; readonly height: number; readonly ranks: Uint8Array };
const kEmpty = 255;

/**
 * A small picture of squares, north up, a legend below. In colour a character shows two elements
 * (half blocks), so that a square is about square; without, a letter shows both. Squares are put
 * together where the terminal has fewer places than the ground.
 */
export function drawSquares(
  squares: readonly PlacedState[],
  size: PictureSize,
  style: PictureStyle,
): string {
  const raster = rasterize(squares, Math.max(1, size.columns), Math.max(2, 2 * size.rows));
  if (raster === undefined) return '';
  const lines: string[] = [];
  for (let row = 0; row < raster.height; row += 2) {
    lines.push(style.colour ? colouredLine(raster, row) : letterLine(raster, row));
  }
  const present = new Set(squares.map((square) => square.state));
  return `${[...lines, legend(present, style)].join('\n')}\n`;
}

function rasterize(
  squares: readonly PlacedState[],
  maxColumns: number,
  maxRows: number,
): Raster | undefined {
  const first = squares[0];
  if (first === undefined) return undefined;
  let [west, south, east, north] = first.bounds;
  let unit = Infinity;
  for (const { bounds } of squares) {
    west = Math.min(west, bounds[0]);
    south = Math.min(south, bounds[1]);
    east = Math.max(east, bounds[2]);
    north = Math.max(north, bounds[3]);
    unit = Math.min(unit, bounds[2] - bounds[0]);
  }
  // Whole squares share an element, so that a pattern of states does not depend on how the picture
  // happens to fall.
  const step =
    unit *
    Math.max(
      1,
      Math.ceil((east - west) / unit / maxColumns),
      Math.ceil((north - south) / unit / maxRows),
    );
  const width = Math.max(1, Math.ceil((east - west) / step - 1e-9));
  const height = Math.max(1, Math.ceil((north - south) / step - 1e-9));
  const ranks = new Uint8Array(width * height).fill(kEmpty);
  for (const { bounds, state } of squares) {
    const column = Math.min(
      width - 1,
      Math.floor((bounds[0] + bounds[2]) / 2 / step - west / step),
    );
    const row = Math.min(height - 1, Math.floor(north / step - (bounds[1] + bounds[3]) / 2 / step));
    const at = row * width + column;
    ranks[at] = Math.min(ranks[at] ?? kEmpty, kShownFirst.indexOf(state));
  }
  return { width, height, ranks };
}

function rankAt({ width, height, ranks }: Raster, row: number, column: number): number {
  return row < height ? (ranks[row * width + column] ?? kEmpty) : kEmpty;
}

function letterLine(raster: Raster, row: number): string {
  let line = '';
  for (let column = 0; column < raster.width; ++column) {
    const state =
      kShownFirst[Math.min(rankAt(raster, row, column), rankAt(raster, row + 1, column))];
    line += state === undefined ? ' ' : kStateSymbols[state].letter;
  }
  return line.trimEnd();
}

/** Shows the upper element in the foreground colour where there is one, else the lower. */
function halfBlock(upper: State | undefined, lower: State | undefined): string {
  if (upper !== undefined) return '▀';
  return lower === undefined ? ' ' : '▄';
}

function colouredLine(raster: Raster, row: number): string {
  let line = '';
  let style = '';
  for (let column = 0; column < raster.width; ++column) {
    const upper = kShownFirst[rankAt(raster, row, column)];
    const lower = kShownFirst[rankAt(raster, row + 1, column)];
    const shown = upper ?? lower;
    let wanted = shown === undefined ? '' : foreground(kStateSymbols[shown].colour);
    if (upper !== undefined && lower !== undefined) {
      wanted += background(kStateSymbols[lower].colour);
    }
    if (wanted !== style) line += kReset + wanted;
    style = wanted;
    line += halfBlock(upper, lower);
  }
  return line + kReset;
}

import type { Command } from 'commander';
import { type CliContext, formatBytes, formatTable } from './context.js';
import { readStore, storeOption, type StoreOption } from './with-store.js';
import {
  type State,
  type Place,
  type RecordTable,
  type Store,
  type BoundsM,
  kStates,
  type LastError,
  type RecordKey,
} from '../model/store.js';
import { printableLine } from '../util/text.js';
import { uniteBounds } from '../geo/bounds.js';

const kColumns = 80;
const kMaxPictureRows = 40;

type StatusOptions = StoreOption & { readonly json?: boolean };

export function addStatusCommand(program: Command, context: CliContext): void {
  program
    .command('status')
    .description(
      'what the store holds: counts by source and state, a picture of the squares, the last errors',
    )
    .addOption(storeOption())
    .option('--json', 'print JSON, without the picture')
    .action((options: StatusOptions) => statusCommand(options, context));
}

/** Also while a fetch runs. */
function statusCommand(options: StatusOptions, { output, signal }: CliContext): Promise<void> {
  return readStore(options.store, signal, (store) => {
    const status = readStatus(store);
    if (options.json === true) return output.out(`${JSON.stringify(status, undefined, 2)}\n`);
    const { isTTY, columns } = process.stdout;
    const colour = isTTY && (process.env['NO_COLOR'] ?? '') === '';
    const size = {
      columns: Math.max(10, (isTTY && columns > 0 ? columns : kColumns) - 1),
      rows: kMaxPictureRows,
    };
    output.drawn.out(statusText(status, store.squares.places(), size, { colour }));
  });
}

const kErrorsShown = 5;

export type StatusError = RecordKey & LastError & { readonly state: State };

export type TableStatus = {
  readonly tally: ReturnType<RecordTable['tally']>;
  readonly errors: readonly StatusError[];
};
export type Status = {
  readonly store: string;
  readonly squares: TableStatus;
  readonly orthophotos: TableStatus;
};

export function readStatus(store: Store): Status {
  return {
    store: store.root,
    squares: tableStatus(store.squares),
    orthophotos: tableStatus(store.orthophotos),
  };
}

function tableStatus(table: RecordTable): TableStatus {
  const errors = table
    .lastErrors(kErrorsShown)
    .flatMap(({ key, state, lastError }) =>
      lastError === null ? [] : [{ ...key, state, ...lastError }],
    );
  return { tally: table.tally(), errors };
}

/**
 * As text: tables, the latest errors, and a picture of the squares of each source. Only the picture
 * has control characters, its colours; the store's texts are printable.
 */
export function statusText(
  status: Status,
  places: readonly Place[],
  size: PictureSize,
  style: PictureStyle,
): string {
  const parts = [
    tallyText('squares', status.squares),
    tallyText('orthophotos', status.orthophotos),
    ...pictures(places, size, style),
  ];
  const errors = [...status.squares.errors, ...status.orthophotos.errors];
  if (errors.length > 0) {
    const lines = errors.map(
      ({ at, source, name, state, code, message }) =>
        `${printableLine(`${at}  ${source}/${name}  ${state}  ${code}: ${message}`)}\n`,
    );
    parts.push(`last errors\n${lines.join('')}`);
  }
  return parts.filter((part) => part !== '').join('\n');
}

function tallyText(title: string, { tally }: TableStatus): string {
  if (tally.length === 0) return title === 'squares' ? 'no squares yet\n' : '';
  const rows = tally.map(({ source, state, count, bytes, points }) => [
    source,
    state,
    String(count),
    bytes === 0 ? '-' : formatBytes(bytes),
    points === 0 ? '-' : String(points),
  ]);
  return formatTable([title, 'state', 'count', 'size', 'points'], rows);
}

function pictures(places: readonly Place[], size: PictureSize, style: PictureStyle): string[] {
  return [...new Set(places.map(({ source }) => source))].map((source) => {
    const squares = places.filter((place) => place.source === source);
    return `${printableLine(source)}\n${drawSquares(squares, size, style)}`;
  });
}

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
  if (squares.length === 0) return undefined;
  const [west, south, east, north] = uniteBounds(squares.map(({ bounds }) => bounds));
  const unit = squares.reduce(
    (least, { bounds }) => Math.min(least, bounds[2] - bounds[0]),
    Infinity,
  );
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

/**
 * How a state is shown in a terminal: a letter, and a colour of the 256-colour palette near the one
 * that QGIS shows.
 */
export type StateSymbol = { readonly letter: string; readonly colour: number };

export const kStateSymbols: Readonly<Record<State, StateSymbol>> = {
  known: { letter: '.', colour: 245 },
  wanted: { letter: 'w', colour: 221 },
  fetching: { letter: 'f', colour: 208 },
  fetched: { letter: 'F', colour: 75 },
  verified: { letter: 'V', colour: 34 },
  converted: { letter: 'C', colour: 22 },
  missing: { letter: 'm', colour: 97 },
  failed: { letter: 'X', colour: 160 },
};

/**
 * Where several squares share a place of a picture, the first of these that is among them is shown:
 * trouble must not vanish.
 */
export const kShownFirst: readonly State[] = [
  'failed',
  'missing',
  'fetching',
  'fetched',
  'wanted',
  'verified',
  'converted',
  'known',
];

export type PictureStyle = { readonly colour: boolean };

const kEscape = '\u001b[';
export const kReset = `${kEscape}0m`;
export const foreground = (colour: number): string => `${kEscape}38;5;${colour}m`;
export const background = (colour: number): string => `${kEscape}48;5;${colour}m`;

/** What the letters or colours mean, of the states that are there. */
export function legend(present: ReadonlySet<State>, { colour }: PictureStyle): string {
  const parts = kStates
    .filter((state) => present.has(state))
    .map((state) => {
      const { letter, colour: number } = kStateSymbols[state];
      return `${colour ? `${foreground(number)}█${kReset}` : letter} ${state}`;
    });
  return parts.join('  ');
}

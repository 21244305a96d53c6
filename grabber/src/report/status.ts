import { formatBytes, formatTable } from '../cli/output.js';
import type { State } from '../model/square.js';
import type { Place, RecordTable, Store } from '../model/store.js';
import { printableLine } from '../util/printable.js';
import { drawSquares, type PictureSize } from './square-picture.js';
import type { PictureStyle } from './state-symbols.js';

const kErrorsShown = 5;

export type StatusError = {
  readonly source: string;
  readonly grid: string;
  readonly name: string;
  readonly state: State;
  readonly code: string;
  readonly message: string;
  readonly at: string;
};

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
      (error) =>
        printableLine(
          `${error.at}  ${error.source}/${error.name}  ${error.state}  ${error.code}: ` +
            error.message,
        ) + '\n',
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
  const bySource = new Map<string, Place[]>();
  for (const place of places) {
    const others = bySource.get(place.source);
    if (others === undefined) bySource.set(place.source, [place]);
    else others.push(place);
  }
  return [...bySource].map(
    ([source, squares]) => `${printableLine(source)}\n${drawSquares(squares, size, style)}`,
  );
}

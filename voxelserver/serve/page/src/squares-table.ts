import { button, byId, element, setText } from './dom.js';
import { formatCount } from './number-format.js';
import { kStateSigns } from './patterns.js';
import { kSquareStates, type Square } from './squares.js';

const kMostRows = 500;

/** The squares as text, for users who cannot see the map. A name is a link to its place. */
export class SquaresTable {
  readonly #table = byId('squares-table', HTMLTableElement);
  readonly #body = this.#table.tBodies[0]!;
  readonly #onChosen: (square: Square) => void;
  #drawn = '';

  constructor(onChosen: (square: Square) => void) {
    this.#onChosen = onChosen;
  }

  set squares(squares: readonly Square[]) {
    setText(byId('squares-count', HTMLElement), makeSummary(squares));
    const shown = squares.slice(0, kMostRows);
    // Redrawn only when it differs: a focused name must not be lost every ten seconds.
    const key = JSON.stringify(shown.map((s) => [s.name, s.state, s.points, s.error]));
    if (key === this.#drawn) return;
    this.#drawn = key;
    this.#table.hidden = shown.length === 0;
    const focused = [...this.#body.rows].findIndex((row) => row.contains(document.activeElement));
    this.#body.replaceChildren(...shown.map((square) => this.#row(square)));
    if (focused >= 0) this.#body.rows[focused]?.querySelector('button')?.focus();
  }

  #row(square: Square): HTMLTableRowElement {
    const name = square.name === '' ? '(no name)' : square.name;
    const chooser = button(name, () => this.#onChosen(square));
    chooser.className = 'link';
    const error = square.error === '' ? '' : `: ${square.error}`;
    const state = `${kStateSigns[square.state].letter} ${square.state}${error}`;
    const points = square.points === undefined ? '' : formatCount(square.points);
    const cells = [state, points].map((text) => element('td', {}, text));
    return element('tr', {}, element('th', { scope: 'row' }, chooser), ...cells);
  }
}

function makeSummary(squares: readonly Square[]): string {
  if (squares.length === 0) return 'The server has no squares.';
  const parts = kSquareStates.flatMap((state) => {
    const times = squares.filter((square) => square.state === state).length;
    return times === 0 ? [] : [`${formatCount(times)} ${state}`];
  });
  const rest = squares.length > kMostRows ? ` The first ${kMostRows} are listed.` : '';
  return `${formatCount(squares.length)} in all: ${parts.join(', ')}.${rest}`;
}

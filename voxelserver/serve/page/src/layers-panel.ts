import { byId, element, setText, toOptions } from './dom.js';
import { kDiskSign, kMemorySign, kStateSigns, swatch, type Sign } from './patterns.js';
import { formatCount } from './number-format.js';
import { kSquareStates, type CachedBoxes } from './squares.js';

export type LayerName = 'top view' | 'squares' | 'boxes';
export type LayerEvents = {
  readonly onSwitch: (name: LayerName, shown: boolean) => void;
  readonly onLevel: (level: number) => void;
};

/** Switches of the layers, each with its legend. */
export class LayersPanel {
  readonly #boxesText = element('p', { class: 'note' });
  readonly #topText = element('p', { class: 'note' });
  readonly #legends = element('ul', { class: 'legend' });
  readonly #boxLegends = element('ul', { class: 'legend' });

  constructor(levels: number, hasTopView: boolean, events: LayerEvents) {
    const names = Array.from({ length: levels }, (_, level) => `${level}: voxels of ${2 ** level}`);
    const options = toOptions(names.map((name, level) => [String(level), name]));
    const select = element('select', { id: 'level' }, ...options);
    select.addEventListener('change', () => events.onLevel(Number(select.value)));
    const target = byId('layers', HTMLElement);
    if (hasTopView) target.append(row('top view', 'Top view', true, events), this.#topText);
    target.append(
      row('squares', 'LiDAR squares', true, events),
      this.#legends,
      row('boxes', 'Kept boxes', false, events),
      element('p', {}, element('label', { for: 'level' }, 'Level of the boxes '), select),
      this.#boxLegends,
      this.#boxesText,
    );
    this.recolour();
  }

  recolour(): void {
    this.#legends.replaceChildren(...kSquareStates.map((state) => legendItem(kStateSigns[state])));
    this.#boxLegends.replaceChildren(legendItem(kMemorySign), legendItem(kDiskSign));
  }

  /** @param boxes undefined: not shown */
  set boxes(boxes: CachedBoxes | undefined) {
    const rest = boxes?.truncated === true ? ' (more than are drawn)' : '';
    const text = (all: CachedBoxes): string =>
      `${formatCount(all.memory.length)} in memory, ${formatCount(all.disk.length)} on disk${rest}`;
    setText(this.#boxesText, boxes === undefined ? '' : text(boxes));
  }

  set boxesTrouble(text: string) {
    setText(this.#boxesText, text);
  }

  set unfinishedTiles(tiles: number) {
    setText(
      this.#topText,
      tiles === 0 ? '' : 'Some of it is not made yet. Zoom in to have it made.',
    );
  }
}

function row(name: LayerName, title: string, shown: boolean, events: LayerEvents): HTMLElement {
  const box = element('input', { type: 'checkbox', id: `layer-${name.replace(' ', '-')}` });
  box.checked = shown;
  box.addEventListener('change', () => events.onSwitch(name, box.checked));
  return element('p', { class: 'layer' }, box, element('label', { for: box.id }, title));
}

const legendItem = (sign: Sign): HTMLElement => element('li', {}, swatch(sign), sign.label);

import { button, byId, element, setFacts, setText } from './dom.js';
import {
  formatBytes,
  formatCount,
  formatDuration,
  formatSeconds,
  formatShare,
} from './number-format.js';
import { RateChart } from './rate-chart.js';
import type { CacheStats, Stage, Stats } from './replies.js';

const kNothingMade = { running: 0, waiting: 0, aheadWaiting: 0, made: 0, madeAhead: 0 };

type Order = 'reported' | 'name' | 'mean' | 'runs' | 'share';
const kColumns: readonly { readonly order: Order; readonly title: string }[] = [
  { order: 'name', title: 'Step' },
  { order: 'mean', title: 'Mean' },
  { order: 'runs', title: 'Runs' },
  { order: 'share', title: 'Share' },
];

const computeMean = (stage: Stage): number => (stage.count > 0 ? stage.seconds / stage.count : 0);

/** @return the stages in an order; "reported" is the order in which they run */
export function sortedStages(stages: readonly Stage[], order: Order): Stage[] {
  const by: Record<Order, (a: Stage, b: Stage) => number> = {
    reported: () => 0,
    name: (a, b) => a.name.localeCompare(b.name),
    mean: (a, b) => computeMean(b) - computeMean(a),
    runs: (a, b) => b.count - a.count,
    share: (a, b) => b.seconds - a.seconds,
  };
  return [...stages].sort(by[order]);
}

/** What the server does: times of its steps, caches, queue, memory, requests a second. */
export class StatsPanel {
  readonly #chart = new RateChart(byId('rate', HTMLElement));
  readonly #facts = byId('server', HTMLDListElement);
  readonly #body = element('tbody');
  readonly #heads = new Map<Order, HTMLTableCellElement>();
  readonly #none = element('p', {}, 'No step has run yet.');
  readonly #table: HTMLTableElement;
  #order: Order = 'reported';
  #stages: readonly Stage[] = [];

  constructor() {
    const head = element('tr');
    for (const { order, title } of kColumns) {
      const sorter = button(title, () => this.#sort(this.#order === order ? 'reported' : order));
      sorter.title = `Sort by ${title.toLowerCase()}; again: in the order of the server`;
      const cell = element('th', { scope: 'col' }, sorter);
      this.#heads.set(order, cell);
      head.append(cell);
    }
    const caption = element(
      'caption',
      { class: 'hidden-text' },
      'Steps of making boxes: mean time of a run, number of runs, share of all time',
    );
    this.#table = element('table', {}, caption, element('thead', {}, head), this.#body);
    byId('steps', HTMLElement).append(this.#none, this.#table);
    this.#drawSteps();
  }

  update(stats: Stats, nowS: number): void {
    this.#chart.add(nowS, stats.requests);
    setFacts(this.#facts, toFacts(stats));
    this.#stages = stats.stages;
    this.#drawSteps();
  }

  #sort(order: Order): void {
    this.#order = order;
    for (const [name, cell] of this.#heads) {
      if (name === order) {
        cell.setAttribute('aria-sort', name === 'name' ? 'ascending' : 'descending');
      } else cell.removeAttribute('aria-sort');
    }
    this.#drawSteps();
  }

  #drawSteps(): void {
    const stages = sortedStages(this.#stages, this.#order);
    const all = stages.reduce((sum, stage) => sum + stage.seconds, 0);
    this.#none.hidden = stages.length > 0;
    this.#table.hidden = stages.length === 0;
    while (this.#body.rows.length > stages.length) this.#body.lastElementChild?.remove();
    while (this.#body.rows.length < stages.length) this.#body.append(emptyRow());
    stages.forEach((stage, i) => fillRow(this.#body.rows[i]!, stage, all));
  }
}

function emptyRow(): HTMLTableRowElement {
  const bar = element('span', { class: 'bar', 'aria-hidden': 'true' }, element('span'));
  const share = element('td', {}, bar, element('span'));
  const name = element('th', { scope: 'row' });
  return element('tr', {}, name, element('td'), element('td'), share);
}

function fillRow(row: HTMLTableRowElement, stage: Stage, allSeconds: number): void {
  const [name, mean, runs, share] = row.cells;
  setText(name!, stage.name);
  setText(mean!, formatSeconds(computeMean(stage)));
  setText(runs!, formatCount(stage.count));
  const [bar, text] = share!.children;
  (bar!.firstElementChild as HTMLElement).style.width =
    allSeconds > 0 ? `${(100 * stage.seconds) / allSeconds}%` : '0';
  setText(text!, formatShare(stage.seconds, allSeconds));
}

const ofLimit = (bytes: number, limit: number): string =>
  limit > 0 ? `${formatBytes(bytes)} of ${formatBytes(limit)}` : formatBytes(bytes);

function cacheText(cache: CacheStats | undefined): string {
  if (cache === undefined) return '';
  const lookups = cache.hits + cache.misses;
  const hits =
    lookups > 0 ? `, ${formatShare(cache.hits, lookups)} of ${formatCount(lookups)} found` : '';
  return `${ofLimit(cache.bytes, cache.limitBytes)}, ${formatCount(cache.entries)} boxes${hits}`;
}

function toFacts({ making, memory, prepare, ...stats }: Stats): [string, string][] {
  const n = formatCount;
  const failed = (times: number): string => (times > 0 ? `, ${n(times)} failed` : '');
  const sent = stats.replyBytes === undefined ? '' : `, ${formatBytes(stats.replyBytes)} sent`;
  const { running, waiting, aheadWaiting, made, madeAhead } = making ?? kNothingMade;
  const queue = `${n(running)} now, ${n(waiting)} wait, ${n(aheadWaiting)} ahead`;
  const done = `${n(made)}, ${n(madeAhead)} ahead${failed(making?.failed ?? 0)}`;
  const squares = prepare && `${n(prepare.done)} of ${n(prepare.total)}${failed(prepare.failed)}`;
  return [
    ['Running for', formatDuration(stats.uptimeS)],
    ['Requests', `${n(stats.requests)}${sent}`],
    ['Memory', memory ? ofLimit(memory.rssBytes, memory.limitBytes) : ''],
    ['Boxes in memory', cacheText(stats.cache)],
    ['Boxes on disk', stats.disk ? cacheText(stats.disk) : 'not kept'],
    ['Being made', making ? queue : ''],
    ['Made', making ? done : ''],
    ['Squares prepared', squares ?? ''],
  ];
}

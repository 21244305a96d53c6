import { byId, element, setFacts } from './dom.js';
import {
  formatBytes,
  formatCount,
  formatDuration,
  formatSeconds,
  formatShare,
} from './number-format.js';
import type { CacheStats, Stage, Stats } from './replies.js';

const kNothingMade = { running: 0, waiting: 0, aheadWaiting: 0, made: 0, madeAhead: 0 };

/** What the server does: times of its steps, caches, queue, memory, requests. */
export class StatsPanel {
  #drawn = '';
  #before: Stats | undefined;

  update(stats: Stats): void {
    setFacts(byId('server', HTMLDListElement), toFacts(stats, requestsPerS(stats, this.#before)));
    this.#before = stats;
    // Drawn anew only when it differs: a selection must not be lost every second.
    const key = JSON.stringify(stats.stages);
    if (key === this.#drawn) return;
    this.#drawn = key;
    const all = stats.stages.reduce((sum, stage) => sum + stage.seconds, 0);
    const table = byId('steps-table', HTMLTableElement);
    table.tBodies[0]!.replaceChildren(...stats.stages.map((stage) => makeRow(stage, all)));
    table.hidden = stats.stages.length === 0;
    byId('no-steps', HTMLElement).hidden = !table.hidden;
  }
}

/** @return undefined where they cannot be compared, as of a server that was started anew */
function requestsPerS(now: Stats, before: Stats | undefined): number | undefined {
  if (before === undefined || now.uptimeS <= before.uptimeS) return undefined;
  return (now.requests - before.requests) / (now.uptimeS - before.uptimeS);
}

function makeRow({ name, seconds, count }: Stage, allSeconds: number): HTMLTableRowElement {
  const bar = element('span');
  bar.style.width = allSeconds > 0 ? `${(100 * seconds) / allSeconds}%` : '0';
  return element(
    'tr',
    {},
    element('th', { scope: 'row' }, name),
    element('td', {}, formatSeconds(count > 0 ? seconds / count : 0)),
    element('td', {}, formatCount(count)),
    element(
      'td',
      {},
      element('span', { class: 'bar', 'aria-hidden': 'true' }, bar),
      element('span', {}, formatShare(seconds, allSeconds)),
    ),
  );
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

function toFacts(
  { making, memory, prepare, ...stats }: Stats,
  perS: number | undefined,
): [string, string][] {
  const n = formatCount;
  const failed = (times: number): string => (times > 0 ? `, ${n(times)} failed` : '');
  const rate = perS === undefined ? '' : `, ${perS.toFixed(perS < 10 ? 1 : 0)} a second`;
  const sent = stats.replyBytes === undefined ? '' : `, ${formatBytes(stats.replyBytes)} sent`;
  const { running, waiting, aheadWaiting, made, madeAhead } = making ?? kNothingMade;
  const queue = `${n(running)} now, ${n(waiting)} wait, ${n(aheadWaiting)} ahead`;
  const done = `${n(made)}, ${n(madeAhead)} ahead${failed(making?.failed ?? 0)}`;
  const squares = prepare && `${n(prepare.done)} of ${n(prepare.total)}${failed(prepare.failed)}`;
  return [
    ['Running for', formatDuration(stats.uptimeS)],
    ['Requests', `${n(stats.requests)}${rate}${sent}`],
    ['Memory', memory ? ofLimit(memory.rssBytes, memory.limitBytes) : ''],
    ['Boxes in memory', cacheText(stats.cache)],
    ['Boxes on disk', stats.disk ? cacheText(stats.disk) : 'not kept'],
    ['Being made', making ? queue : ''],
    ['Made', making ? done : ''],
    ['Squares prepared', squares ?? ''],
  ];
}

import type { CatalogueSquare, StoreRecord } from '../model/store.js';
import { GrabberError } from '../util/errors.js';
import type { FetchWork } from './run-jobs.js';
import { statusError } from './response-check.js';
import { withRetries } from './retry.js';
import { compareText } from '../util/text.js';

/** @return the record's addresses, best first; empty when its source has no such file */
export async function locateAddresses(
  record: StoreRecord,
  work: FetchWork,
): Promise<readonly string[]> {
  const { job, blocks, signal } = work;
  if (record.urls.length > 0 && job.addressesExpire !== true) return record.urls;
  if (job.locate === undefined) {
    throw new GrabberError(
      'CATALOGUE',
      `find the address of ${record.key.source}/${record.key.name}: the store has none; ` +
        'allowed: a source that can look for it (fetch with --source)',
    );
  }
  const near = blocks.near(record.key.name);
  const exists = (url: string, stop: AbortSignal): Promise<boolean> =>
    isThere(url, record, { ...work, signal: stop });
  const found = await job.locate(asCatalogueSquare(record), near, exists, signal);
  if (found === undefined || found.urls.length === 0) return [];
  job.table.located(record.key, found.block, found.urls);
  blocks.add(record.key.name, found.block);
  return found.urls;
}

function asCatalogueSquare(record: StoreRecord): CatalogueSquare {
  const { key, block, bounds, urls, expectedBytes, expectedSha256, member, published } = record;
  return {
    name: key.name,
    block,
    bounds,
    urls,
    bytes: expectedBytes,
    sha256: expectedSha256,
    member,
    published,
  };
}

/** Sends HEAD, and where a server does not support it, requests the first byte. */
function isThere(
  url: string,
  record: StoreRecord,
  { job, run, signal }: FetchWork,
): Promise<boolean> {
  const attempt = async (): Promise<boolean> => {
    let response = await job.http.head(url, {}, signal);
    await response.discard();
    if ([405, 501].includes(response.status)) {
      const first = { range: 'bytes=0-0', 'accept-encoding': 'identity' };
      response = await job.http.get(url, first, signal);
      await response.discard();
    }
    if (response.status === 200 || response.status === 206) return true;
    if (job.missingStatus.includes(response.status)) return false;
    const error = statusError(url, response, job.missingStatus, run.clock.now());
    if (error.retryAfterMs !== undefined) {
      run.queues.limiter.pause(new URL(url).host, error.retryAfterMs);
    }
    throw error;
  };
  return withRetries(
    () => run.queues.run(new URL(url).host, job.limits, attempt, signal),
    run.policy,
    run.clock,
    (notice) => run.events.retry(record.key, notice),
    signal,
  );
}

const kGridName = /^(-?\d{1,6})_(-?\d{1,6})$/;

/**
 * Records the blocks of squares, so that an unknown block is searched among those of its neighbours
 * first.
 */
export class NearBlocks {
  readonly #byName = new Map<string, string>();
  readonly #counts = new Map<string, number>();

  constructor(records: Iterable<StoreRecord>) {
    for (const { key, block } of records) this.add(key.name, block);
  }

  add(name: string, block: string | null): void {
    if (block === null || this.#byName.has(name)) return;
    this.#byName.set(name, block);
    this.#counts.set(block, (this.#counts.get(block) ?? 0) + 1);
  }

  /**
   * @return blocks of the eight neighbours, then all others, each group with the most frequent
   *   first
   */
  near(name: string): string[] {
    const around = new Map<string, number>();
    const match = kGridName.exec(name);
    for (const east of [-1, 0, 1]) {
      for (const north of [-1, 0, 1]) {
        if (match === null) continue;
        const block = this.#byName.get(`${Number(match[1]) + east}_${Number(match[2]) + north}`);
        if (block !== undefined) around.set(block, (around.get(block) ?? 0) + 1);
      }
    }
    return [...new Set([...byCount(around), ...byCount(this.#counts)])];
  }
}

/** @return the blocks, the most frequent first, equally frequent ones by name */
function byCount(counts: ReadonlyMap<string, number>): string[] {
  const sorted = [...counts].sort(([a, m], [b, n]) => n - m || compareText(a, b));
  return sorted.map(([block]) => block);
}

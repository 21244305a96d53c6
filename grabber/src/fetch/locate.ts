import type { CatalogueSquare, StoreRecord } from '../model/square.js';
import { GrabberError } from '../util/errors.js';
import type { FetchJob, FetchRun } from './fetch-job.js';
import type { NearBlocks } from './near-blocks.js';
import { statusError } from './response-error.js';
import { withRetries } from './retry.js';

/** @return the record's addresses, best first; empty when its source has no such file */
export async function locateAddresses(
  record: StoreRecord,
  job: FetchJob,
  run: FetchRun,
  blocks: NearBlocks,
  signal: AbortSignal,
): Promise<readonly string[]> {
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
    isThere(url, record, job, run, stop);
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
  job: FetchJob,
  run: FetchRun,
  signal: AbortSignal,
): Promise<boolean> {
  const attempt = async (): Promise<boolean> => {
    let response = await job.http.head(url, {}, signal);
    await response.discard();
    if ([405, 501].includes(response.status)) {
      response = await job.http.get(
        url,
        { range: 'bytes=0-0', 'accept-encoding': 'identity' },
        signal,
      );
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

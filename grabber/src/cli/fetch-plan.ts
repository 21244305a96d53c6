import { existsSync } from 'node:fs';
import { dirname, resolve } from 'node:path';
import PQueue from 'p-queue';
import { freeBytes } from '../fetch/disk-space.js';
import { HostRateLimiter } from '../fetch/host-rate-limiter.js';
import type { SourceClient } from '../fetch/http-client.js';
import type { CatalogueSquare } from '../model/square.js';
import type { Selection } from '../select/selection.js';
import { kSystemClock } from '../util/clock.js';
import { kExit } from './exit-codes.js';
import { formatBytes, type Output } from './output.js';

type PlanOptions = {
  store?: string;
  concurrency?: number;
  maxWaitS: number;
  sizes?: boolean;
  json?: boolean;
};

/**
 * Lists what a fetch would request, and whether it would fit on the disk. Changes nothing.
 * @return the exit code
 */
export async function printPlan(
  selection: Selection,
  squares: readonly CatalogueSquare[],
  http: SourceClient,
  options: PlanOptions,
  output: Output,
  signal: AbortSignal,
): Promise<number> {
  const sizes =
    options.sizes === true
      ? await requestSizes(selection, squares, http, options, signal)
      : new Map<string, Size>();
  const totals = { known_bytes: 0, unknown_sizes: 0, missing: 0 };
  for (const square of squares) {
    const size = square.bytes ?? sizes.get(square.name) ?? null;
    if (size === 'missing') totals.missing += 1;
    else if (size === null) totals.unknown_sizes += 1;
    else totals.known_bytes += size;
    const line =
      options.json === true
        ? JSON.stringify(squareEvent(selection.source, square, size))
        : squareLine(square, size);
    output.outLine(line);
  }
  const free_bytes = freeBytes(nearestFolder(resolve(options.store ?? '.')));
  const plan = { event: 'plan', files: squares.length, ...totals, free_bytes };
  const line =
    options.json === true ? JSON.stringify(plan) : planLine(plan, options.sizes === true);
  output.outLine(line);
  return kExit.done;
}

type Plan = {
  readonly files: number;
  readonly known_bytes: number;
  readonly unknown_sizes: number;
  readonly missing: number;
  readonly free_bytes: number;
};

function squareEvent(source: string, square: CatalogueSquare, size: Size | null): object {
  return {
    event: 'square',
    source,
    square: square.name,
    url: square.urls[0] ?? null,
    bytes: size === 'missing' ? null : size,
    missing: size === 'missing',
  };
}

function squareLine(square: CatalogueSquare, size: Size | null): string {
  const shown = typeof size === 'number' ? formatBytes(size) : (size ?? '?');
  return `${square.name}\t${shown}\t${square.urls[0] ?? '(to be looked for)'}`;
}

/** @param requested whether the sizes were requested from the server */
function planLine(plan: Plan, requested: boolean): string {
  const hint = requested ? '' : ' (--sizes requests it)';
  const more = plan.unknown_sizes === 0 ? '' : ` and ${plan.unknown_sizes} of unknown size${hint}`;
  const gone = plan.missing === 0 ? '' : `, ${plan.missing} missing`;
  const known = formatBytes(plan.known_bytes);
  return `${plan.files} squares, ${known}${more}${gone}; ${formatBytes(plan.free_bytes)} free`;
}

type Size = number | 'missing';

async function requestSizes(
  selection: Selection,
  squares: readonly CatalogueSquare[],
  http: SourceClient,
  options: PlanOptions,
  signal: AbortSignal,
): Promise<Map<string, Size>> {
  const sizes = new Map<string, Size>();
  const limiter = new HostRateLimiter(kSystemClock, options.maxWaitS * 1000);
  const queue = new PQueue({
    concurrency: options.concurrency ?? selection.profile.max_concurrent,
  });
  await queue.addAll(
    squares.map((square) => async () => {
      const [url] = square.urls;
      if (square.bytes !== null || url === undefined || url.startsWith('file:')) return;
      await limiter.acquire(new URL(url).host, signal, selection.profile.max_per_s);
      const response = await http.head(url, { 'accept-encoding': 'identity' }, signal);
      await response.discard();
      const length = response.header('content-length');
      if (selection.profile.missing_status.includes(response.status)) {
        sizes.set(square.name, 'missing');
      } else if (response.status === 200 && length !== undefined && /^\d{1,15}$/.test(length)) {
        sizes.set(square.name, Number(length));
      }
    }),
  );
  return sizes;
}

/** The store may not be there yet; its disk is. */
function nearestFolder(folder: string): string {
  return existsSync(folder) || dirname(folder) === folder ? folder : nearestFolder(dirname(folder));
}

import { existsSync } from 'node:fs';
import { dirname, resolve } from 'node:path';
import PQueue from 'p-queue';
import { freeBytes } from '../fetch/disk-space.js';
import { HostGate } from '../fetch/host-gate.js';
import type { SourceClient } from '../fetch/http-client.js';
import type { CatalogueSquare } from '../model/square.js';
import type { Selection } from '../select/selection.js';
import { kSystemClock } from '../util/clock.js';
import { kExit } from './exit-codes.js';
import { formatBytes, type Output } from './output.js';

type PlanOptions = { store?: string; concurrency?: number; maxWaitS: number; sizes?: boolean; json?: boolean };

/** Lists what a fetch would ask for, and whether it would fit. Changes nothing. @return the exit code */
export async function printPlan(
  selection: Selection,
  squares: readonly CatalogueSquare[],
  http: SourceClient,
  options: PlanOptions,
  output: Output,
  signal: AbortSignal,
): Promise<number> {
  const sizes = options.sizes === true ? await askSizes(selection, squares, http, options, signal) : new Map<string, Size>();
  let [known, unknown, missing] = [0, 0, 0];
  for (const square of squares) {
    const size = square.bytes ?? sizes.get(square.name) ?? null;
    const bytes = typeof size === 'number' ? size : null;
    if (size === 'missing') ++missing;
    else if (bytes === null) ++unknown;
    else known += bytes;
    const url = square.urls[0] ?? null;
    if (options.json === true) output.out(`${JSON.stringify({ event: 'square', source: selection.source, square: square.name, url, bytes, missing: size === 'missing' })}\n`);
    else output.out(`${square.name}\t${bytes === null ? (size ?? '?') : formatBytes(bytes)}\t${url ?? '(to be looked for)'}\n`);
  }
  const free_bytes = freeBytes(nearestFolder(resolve(options.store ?? '.')));
  const plan = { event: 'plan', files: squares.length, known_bytes: known, unknown_sizes: unknown, missing, free_bytes };
  if (options.json === true) output.out(`${JSON.stringify(plan)}\n`);
  else {
    const asks = options.sizes === true ? '' : ' (--sizes asks)';
    const more = unknown === 0 ? '' : ` and ${unknown} of unknown size${asks}`;
    const gone = missing === 0 ? '' : `, ${missing} missing`;
    output.out(`${squares.length} squares, ${formatBytes(known)}${more}${gone}; ${formatBytes(free_bytes)} free\n`);
  }
  return kExit.done;
}

type Size = number | 'missing';

async function askSizes(
  selection: Selection,
  squares: readonly CatalogueSquare[],
  http: SourceClient,
  options: PlanOptions,
  signal: AbortSignal,
): Promise<Map<string, Size>> {
  const sizes = new Map<string, Size>();
  const gate = new HostGate(kSystemClock, options.maxWaitS * 1000);
  const queue = new PQueue({ concurrency: options.concurrency ?? selection.profile.max_concurrent });
  await queue.addAll(
    squares.map((square) => async () => {
      const [url] = square.urls;
      if (square.bytes !== null || url === undefined || url.startsWith('file:')) return;
      await gate.pass(new URL(url).host, signal, selection.profile.max_per_s);
      const response = await http.head(url, { 'accept-encoding': 'identity' }, signal);
      await response.discard();
      const length = response.header('content-length');
      if (selection.profile.missing_status.includes(response.status)) sizes.set(square.name, 'missing');
      else if (response.status === 200 && length !== undefined && /^\d{1,15}$/.test(length)) sizes.set(square.name, Number(length));
    }),
  );
  return sizes;
}

/** The store may not be there yet; its disk is. */
function nearestFolder(folder: string): string {
  return existsSync(folder) || dirname(folder) === folder ? folder : nearestFolder(dirname(folder));
}

import { join, dirname, resolve } from 'node:path';
import { existsSync } from 'node:fs';
import type { Command } from 'commander';
import PQueue from 'p-queue';
import { usage, GrabberError } from '../util/errors.js';
import type { SourceClient } from '../fetch/http-client.js';
import { redactError } from '../fetch/redact.js';
import {
  kUsable,
  type CatalogueSquare,
  type RecordKey,
  type StoreRecord,
  type Store,
} from '../model/store.js';
import type { Reporter } from '../progress/reporter.js';
import { select, type Selection, type SelectionOptions } from '../select/selection.js';
import { fileSize, removeIfThere } from '../util/files.js';
import { type CliContext, kExit, chooseWorse, formatBytes, type Output } from './context.js';
import { conversionFor, fillStore, openClient, toAccess, lidarJob } from './fill-store.js';
import { findOrthoSource, kDefaultMargin_m, makeOrthophotos } from './ortho-command.js';
import {
  addRunOptions,
  monitorCatalogue,
  chooseReporter,
  chooseStore,
  type RunOptions,
} from './run-options.js';
import { addSelectionOptions } from './options.js';
import { makeStore, readStore } from './with-store.js';
import { freeBytes } from '../fetch/disk-space.js';
import { HostRateLimiter } from '../fetch/host-queues.js';
import { kSystemClock } from '../util/clock.js';

export type FetchOptions = SelectionOptions &
  RunOptions & { refetch?: boolean; dryRun?: boolean; sizes?: boolean; ortho?: string };

export function addFetchCommand(program: Command, context: CliContext): void {
  const command = addSelectionOptions(
    program.command('fetch').description('download or copy squares into a store'),
    context,
  );
  addRunOptions(command, 'store to fill; made when it is not there')
    .option('--refetch', 'fetch verified squares again, and request missing ones again')
    .option(
      '--ortho <id>',
      'then make an orthophoto for each of the squares, from this source of sources/ortho',
    )
    .option('--dry-run', 'only list the squares, their addresses and sizes')
    .option('--sizes', 'with --dry-run: request unknown sizes from the server')
    .action(async (options: FetchOptions) => context.exit(await fetchCommand(options, context)));
}

/**
 * Fills a store with the requested squares.
 * @return the exit code
 */
async function fetchCommand(options: FetchOptions, context: CliContext): Promise<number> {
  const { output, signal } = context;
  // A wrong name is reported now rather than after hours of fetching.
  if (options.ortho !== undefined) await findOrthoSource(options.ortho, context);
  // No host may be contacted before the selection has determined the source.
  const http = openClient(context, options);
  try {
    const monitor = monitorCatalogue(options, output);
    const selection = await select(options, await context.sources(), http, signal, monitor);
    http.permit(toAccess(selection.profile));
    if (options.dryRun !== true) chooseStore(options);
    const squares = await findSquares(selection, options, signal);
    if (options.dryRun === true) {
      await printPlan(selection, squares, http, options, output, signal);
      return monitor.code();
    }
    const folder = chooseStore(options);
    const names = squares.map(({ name }) => name);
    const reporter = chooseReporter(options, output);
    let code: number;
    try {
      for (const path of selection.ignored) reporter.ignored(path, selection.source);
      const filled = await makeStore(folder, signal, (store) =>
        fetchInto(store, selection, squares, http, options, reporter, context),
      );
      code = chooseWorse(filled, monitor.code());
    } finally {
      reporter.close();
    }
    if (options.ortho === undefined) return code;
    return chooseWorse(code, await addOrthophotos(folder, selection, names, options, context));
  } catch (error) {
    throw redactError(error, http.redact);
  } finally {
    await http.close();
  }
}

/**
 * Makes orthophotos of the fetched squares, with the default options of `ortho`.
 * @return the exit code
 */
async function addOrthophotos(
  store: string,
  { grid }: Selection,
  fetched: readonly string[],
  { ortho: source, retries, timeoutS, json }: FetchOptions,
  context: CliContext,
): Promise<number> {
  const there = new Set(
    await readStore(store, context.signal, (open) =>
      open.squares.list({ source: grid, usable: true }).map(({ key }) => key.name),
    ),
  );
  const names = fetched.filter((name) => there.has(name));
  // None could be fetched, which the run has reported.
  if (names.length === 0) return kExit.done;
  const options = {
    store,
    ...(source === undefined ? {} : { source }),
    grid,
    squares: names,
    as: grid,
    marginM: kDefaultMargin_m,
    retries,
    timeoutS,
    json: json ?? false,
  };
  return makeOrthophotos(options, context);
}

async function findSquares(
  selection: Selection,
  options: FetchOptions,
  signal: AbortSignal,
): Promise<CatalogueSquare[]> {
  const squares: CatalogueSquare[] = [];
  for await (const square of selection.catalogue.find(selection.region, signal)) {
    const foreign = square.urls.find((url) => url.startsWith('file:'));
    if (options.from === undefined && foreign !== undefined) {
      throw new GrabberError(
        'CATALOGUE',
        `read catalogue of ${selection.source}: ${square.name} is at ${foreign}; allowed: ` +
          'web addresses',
      );
    }
    squares.push(square);
  }
  if (squares.length > 0) return squares;
  throw usage(
    `choose squares of ${selection.source}: none lie there; allowed: ground that the source covers`,
  );
}

/**
 * Records the squares in the store and fetches those that are not there.
 * @param squares is emptied once it is recorded, since a whole country's squares take much memory
 * @return the exit code
 */
async function fetchInto(
  store: Store,
  selection: Selection,
  squares: CatalogueSquare[],
  http: SourceClient,
  options: FetchOptions,
  reporter: Reporter,
  context: CliContext,
): Promise<number> {
  const { source, grid, gridCrs, terms, profile, catalogue } = selection;
  const keys = squares.map(({ name }): RecordKey => ({ source, grid, name }));
  if (options.source === undefined && options.refetch !== true) {
    checkSameAddresses(store, keys, squares);
  }
  store.squares.learn(source, grid, gridCrs, terms, squares);
  squares.length = 0;
  store.squares.want(keys, options.refetch);
  const names = keys.map(({ name }) => name);
  const usable = store.squares.list({ source, grid, names, states: kUsable });
  const kept = await countIntact(store, usable, reporter);
  const known_missing = store.squares.count({ source, grid, names, states: ['missing'] });
  const records = store.squares.unfinished({ source, grid, names });
  const local = options.from !== undefined;
  const convert = conversionFor(context);
  const job = lidarJob(records, profile, catalogue, store, http, local, options, convert);
  const excluded = { kept, known_missing, skipped: 0 };
  return fillStore([job], store, excluded, options, reporter, context.signal);
}

/**
 * Without a configured source, names do not identify the origin of a file: the same name from
 * elsewhere is another file.
 */
function checkSameAddresses(
  store: Store,
  keys: readonly RecordKey[],
  squares: readonly CatalogueSquare[],
): void {
  keys.forEach((key, index) => {
    const old = store.squares.get(key);
    const urls = squares[index]?.urls ?? [];
    if (old === undefined || old.file === null || old.url === null || urls.includes(old.url)) {
      return;
    }
    throw new GrabberError(
      'STORE_CONFLICT',
      `fetch square ${key.source}/${key.name} from ${urls[0] ?? 'nowhere'}: the store has ` +
        `it from ${old.url}; allowed: the same address, another --as, or --refetch`,
    );
  });
}

/**
 * Reports the usable files that have their recorded length. A file that is lost or cut is wanted
 * again.
 * @return how many files are intact
 */
async function countIntact(
  store: Store,
  usable: readonly StoreRecord[],
  reporter: Reporter,
): Promise<number> {
  let kept = 0;
  for (const { key, url, file, points, warnings } of usable) {
    const bytes = file === null ? undefined : await fileSize(join(store.root, file.path));
    if (file === null || bytes !== file.bytes) {
      if (file !== null) await removeIfThere(join(store.root, file.path));
      store.squares.forget(key);
      store.squares.want([key]);
      continue;
    }
    ++kept;
    reporter.outcome({
      state: 'kept',
      key,
      url,
      file,
      point_count: points?.pointCount ?? null,
      warnings,
    });
  }
  return kept;
}

/** Lists what a fetch would request, and whether it would fit on the disk. Changes nothing. */
async function printPlan(
  selection: Selection,
  squares: readonly CatalogueSquare[],
  http: SourceClient,
  options: FetchOptions,
  output: Output,
  signal: AbortSignal,
): Promise<void> {
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
    output.outLine(
      options.json === true
        ? JSON.stringify(squareEvent(selection.source, square, size))
        : squareLine(square, size),
    );
  }
  const free_bytes = freeBytes(nearestFolder(resolve(options.store ?? '.')));
  const plan = { event: 'plan', files: squares.length, ...totals, free_bytes };
  output.outLine(
    options.json === true ? JSON.stringify(plan) : planLine(plan, options.sizes === true),
  );
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
  options: FetchOptions,
  signal: AbortSignal,
): Promise<Map<string, Size>> {
  const sizes = new Map<string, Size>();
  const limiter = new HostRateLimiter(kSystemClock, options.maxWaitS * 1000);
  const { profile } = selection;
  const queue = new PQueue({ concurrency: options.concurrency ?? profile.max_concurrent });
  await queue.addAll(
    squares.map((square) => async () => {
      const [url] = square.urls;
      if (square.bytes !== null || url === undefined || url.startsWith('file:')) return;
      await limiter.acquire(new URL(url).host, signal, profile.max_per_s);
      const response = await http.head(url, { 'accept-encoding': 'identity' }, signal);
      await response.discard();
      const length = response.header('content-length');
      if (profile.missing_status.includes(response.status)) {
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

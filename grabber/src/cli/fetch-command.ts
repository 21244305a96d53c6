import { join } from 'node:path';
import type { Command } from 'commander';
import { createHttpClient, kNoAccess, type SourceClient } from '../fetch/http-client.js';
import { redactError } from '../fetch/redact.js';
import {
  kUsable,
  type CatalogueSquare,
  type RecordKey,
  type StoreRecord,
} from '../model/square.js';
import type { Store } from '../model/store.js';
import type { Reporter } from '../progress/reporter.js';
import { select, type Selection, type SelectionOptions } from '../select/selection.js';
import { GrabberError } from '../util/errors.js';
import { fileSize, removeIfThere } from '../util/files.js';
import { userAgent } from '../util/package-info.js';
import type { CliContext } from './context.js';
import { conversionFor, fillStore, type FetchHooks } from './fill-store.js';
import { toAccess, lidarJob } from './lidar-job.js';
import { kExit, chooseWorse } from './exit-codes.js';
import { printPlan } from './fetch-plan.js';
import { findOrthoSource, kDefaultMargin_m, makeOrthophotos } from './ortho-command.js';
import {
  addRunOptions,
  monitorCatalogue,
  chooseReporter,
  chooseStore,
  type RunOptions,
} from './run-options.js';
import { addSelectionOptions } from './selection.js';
import { makeStore, readStore } from './with-store.js';

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
    .action(async (options: FetchOptions) =>
      context.exit(await fetchCommand(options, context, conversionFor(context))),
    );
}

/**
 * Fills a store with the requested squares.
 * @return the exit code
 */
async function fetchCommand(
  options: FetchOptions,
  context: CliContext,
  hooks: FetchHooks,
): Promise<number> {
  const { output, signal } = context;
  // A wrong name is reported now rather than after hours of fetching.
  if (options.ortho !== undefined) await findOrthoSource(options.ortho, context);
  // No host may be contacted before the selection has determined the source.
  const http = createHttpClient({
    userAgent: userAgent(context.info),
    timeout_ms: options.timeoutS * 1000,
    access: kNoAccess,
  });
  try {
    const monitor = monitorCatalogue(options, output);
    const selection = await select(options, await context.sources(), http, signal, monitor);
    http.permit(toAccess(selection.profile));
    if (options.dryRun !== true) chooseStore(options);
    const squares = await findSquares(selection, options, signal);
    if (options.dryRun === true) {
      return chooseWorse(
        await printPlan(selection, squares, http, options, output, signal),
        monitor.code(),
      );
    }
    const folder = chooseStore(options);
    const names = squares.map(({ name }) => name);
    const reporter = chooseReporter(options, output);
    let code: number;
    try {
      for (const path of selection.ignored) reporter.ignored(path, selection.source);
      const filled = await makeStore(folder, signal, (store) =>
        fetchInto(store, selection, squares, http, options, hooks, reporter, signal),
      );
      code = chooseWorse(filled, monitor.code());
    } finally {
      reporter.close();
    }
    return options.ortho === undefined
      ? code
      : chooseWorse(
          code,
          await addOrthophotos(options.ortho, folder, selection, names, options, context),
        );
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
  source: string,
  store: string,
  { grid }: Selection,
  fetched: readonly string[],
  { retries, timeoutS, json }: FetchOptions,
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
    source,
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
  throw new GrabberError(
    'USAGE',
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
  hooks: FetchHooks,
  reporter: Reporter,
  signal: AbortSignal,
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
  const kept = await countIntact(
    store,
    store.squares.list({ source, grid, names, states: kUsable }),
    reporter,
  );
  const known_missing = store.squares.count({ source, grid, names, states: ['missing'] });
  const records = store.squares.unfinished({ source, grid, names });
  const job = lidarJob(
    records,
    profile,
    catalogue,
    store,
    http,
    options.from !== undefined,
    options,
    hooks,
  );
  return fillStore([job], store, { kept, known_missing, skipped: 0 }, options, reporter, signal);
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

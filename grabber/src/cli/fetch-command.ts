import { mkdir } from 'node:fs/promises';
import { resolve } from 'node:path';
import type { Command } from 'commander';
import { fetchSquares, type Tally } from '../fetch/fetch-squares.js';
import { HostGate } from '../fetch/host-gate.js';
import { createHttpClient, type HttpClient } from '../fetch/http-client.js';
import { localOrigin } from '../fetch/local-origin.js';
import type { Origin } from '../fetch/origin.js';
import { remoteOrigin } from '../fetch/remote-origin.js';
import { kBackoff } from '../fetch/retry.js';
import type { SourceProfile } from '../sources/profile.js';
import type { Source } from '../sources/source.js';
import type { Square } from '../sources/square.js';
import { storeLayout } from '../store/layout.js';
import { lockStore } from '../store/lock.js';
import { Manifest } from '../store/manifest.js';
import { kSystemClock } from '../util/clock.js';
import { GrabberError, describeError } from '../util/errors.js';
import { userAgent } from '../util/package-info.js';
import type { CliContext } from './context.js';
import { kExit } from './exit-codes.js';
import { localSelection } from './local-selection.js';
import { integerIn } from './option-parsers.js';
import type { Output } from './output.js';
import { jsonReporter, textReporter, type Reporter } from './reporter.js';
import { addSelectionOptions, remoteSelection, type SelectionOptions } from './selection.js';

export type FetchOptions = SelectionOptions & {
  store: string;
  from?: string;
  concurrency?: number;
  retries: number;
  timeoutS: number;
  maxWaitS: number;
  refetch?: boolean;
  json?: boolean;
};

type Work = {
  readonly profile: SourceProfile;
  readonly squares: readonly Square[];
  readonly origin: Origin;
  readonly retries: number;
  readonly ignored: readonly string[];
};

export function addFetchCommand(program: Command, context: CliContext): void {
  addSelectionOptions(program.command('fetch').description('download or copy squares into a store'))
    .requiredOption('--store <folder>', 'store to fill; made when it is not there')
    .option('--from <folder>', 'take LAZ and LAS files of this folder instead of the web')
    .option(
      '--concurrency <n>',
      "files at a time, 1 to 32 (default: the source's, else 4)",
      integerIn(1, 32, 'files at a time'),
    )
    .option('--retries <n>', 'tries after the first, 0 to 20', integerIn(0, 20, 'tries after the first'), 5)
    .option('--timeout-s <s>', 'longest silence of a server, seconds, 1 to 3600', integerIn(1, 3600, 'seconds'), 60)
    .option(
      '--max-wait-s <s>',
      'longest Retry-After to obey, seconds, 1 to 86400',
      integerIn(1, 86_400, 'seconds'),
      600,
    )
    .option('--refetch', 'fetch again what is verified already')
    .option('--json', 'log one JSON object a line to standard output')
    .action(async (options: FetchOptions) => {
      const { info, output, signal } = context;
      context.exit(await fetchCommand(options, await context.sources(), userAgent(info), output, signal));
    });
}

/** Fills a store. @return the exit code */
async function fetchCommand(
  options: FetchOptions,
  sources: ReadonlyMap<string, Source>,
  userAgent: string,
  output: Output,
  signal: AbortSignal,
): Promise<number> {
  const http = createHttpClient({ userAgent, timeout_ms: options.timeoutS * 1000 });
  try {
    const work =
      options.from === undefined
        ? remoteWork(options, sources, http)
        : await localWork(options.from, options, sources, signal);
    const reporter = options.json === true ? jsonReporter(output) : textReporter(output);
    for (const path of work.ignored) reporter.ignored(path, work.profile.id);
    return exitCodeOf(await fillStore(work, options, reporter, signal));
  } finally {
    await http.close();
  }
}

function remoteWork(options: FetchOptions, sources: ReadonlyMap<string, Source>, http: HttpClient): Work {
  const { profile, squares, urlOf } = remoteSelection(options, sources);
  const gate = new HostGate(kSystemClock, options.maxWaitS * 1000);
  const origin = remoteOrigin({ urlOf, missingStatus: profile.missing_status, http, gate, clock: kSystemClock });
  return { profile, squares, origin, retries: options.retries, ignored: [] };
}

async function localWork(
  from: string,
  options: FetchOptions,
  sources: ReadonlyMap<string, Source>,
  signal: AbortSignal,
): Promise<Work> {
  const folder = resolve(from);
  const { profile, squares, files, ignored } = await localSelection(folder, options, sources, signal);
  // A disk gives the same answer the second time.
  return { profile, squares, origin: localOrigin(folder, files), retries: 0, ignored };
}

async function fillStore(work: Work, options: FetchOptions, reporter: Reporter, signal: AbortSignal): Promise<Tally> {
  const { profile, origin, squares } = work;
  const began = performance.now();
  const store = storeLayout(resolve(options.store));
  await makeStoreFolder(store.root);
  const unlock = await lockStore(store.lock, signal);
  try {
    const manifest = await Manifest.open(store.manifest, signal);
    const context = {
      profile,
      origin,
      store,
      manifest,
      policy: { ...kBackoff, retries: work.retries },
      clock: kSystemClock,
      refetch: options.refetch ?? false,
      onRetry: (square: Square, notice: Parameters<Reporter['retry']>[1]) => reporter.retry(square.name, notice),
    };
    const tally = await fetchSquares(
      squares,
      options.concurrency ?? profile.max_concurrent,
      context,
      reporter.outcome,
      signal,
    );
    reporter.summary({ ...tally, ignored: work.ignored.length, seconds: Math.round(performance.now() - began) / 1000 });
    return tally;
  } finally {
    await unlock();
  }
}

async function makeStoreFolder(root: string): Promise<void> {
  try {
    await mkdir(root, { recursive: true });
  } catch (error) {
    throw new GrabberError(
      'STORE_IO',
      `make store folder ${root}: ${describeError(error)}; allowed: a folder that can be written`,
      { cause: error },
    );
  }
}

function exitCodeOf(tally: Tally): number {
  if (tally.failed > 0) return kExit.failed;
  return tally.missing > 0 ? kExit.holes : kExit.done;
}

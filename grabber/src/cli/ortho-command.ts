import { join } from 'node:path';
import { InvalidArgumentError, type Command } from 'commander';
import { usage, describeError, isOfFile, recordedCode } from '../util/errors.js';
import { loadConfigFolder } from '../config/toml-file.js';
import { removeStaleWork, withWorkFolder } from '../convert/work-folder.js';
import { DiskSpace } from '../fetch/disk-space.js';
import { HostRateLimiter } from '../fetch/host-queues.js';
import { kNoAccess, type Access, type HttpClient } from '../fetch/http-client.js';
import { type Redact, readSecretHeaders } from '../fetch/redact.js';
import { kBackoff, type RetryNotice } from '../fetch/retry.js';
import { type StoreRecord, type Store, kStates } from '../model/store.js';
import { downloader } from '../ortho/download.js';
import {
  gatherFor,
  isMade,
  learnOrthophotos,
  makeOrthophoto,
  orthoKey,
  type OrthoSettings,
  type Made,
} from '../ortho/make-orthophoto.js';
import { localGather } from '../ortho/local.js';
import { kOrthoKind, orthoHosts, orthoPrivateOrigins, type OrthoSource } from '../ortho/schema.js';
import { originOfTemplate } from '../sources/source.js';
import { kSystemClock } from '../util/clock.js';
import { type CliContext, kExit, formatBytes, type Output } from './context.js';
import { parseNameList, parseSourceId, kSilence, limit } from './options.js';
import { storeOption, writeStore } from './with-store.js';
import { openClient } from './fill-store.js';

export type OrthoOptions = {
  store: string;
  source?: string;
  grid?: string;
  squares?: string[];
  all?: boolean;
  from?: string;
  as: string;
  licence?: string;
  attribution?: string;
  resolutionM?: number;
  marginM: number;
  time?: string;
  lossless?: boolean;
  again?: boolean;
  retries: number;
  timeoutS: number;
  dryRun?: boolean;
  json?: boolean;
};

export const kDefaultMargin_m = 20;
/** Longest Retry-After to obey. */
const kMaxWait_ms = 600_000;
/** Resolution for local pictures, for which no source states one. */
const kLocalResolution_m = 0.25;
/** States of LiDAR squares that --all takes. */
const kUsableOrWanted = kStates.filter((state) => state !== 'missing');

export function addOrthoCommand(program: Command, context: CliContext): void {
  program
    .command('ortho')
    .description('make an orthophoto for each square of a store')
    .addOption(storeOption())
    .option('--source <id>', 'source of orthophotos: a file of sources/ortho')
    .option(
      '--from <path>',
      'pictures of this file or folder instead: GeoTIFF, or JPEG and PNG with world files',
    )
    .option('--as <id>', 'with --from: folder name in the store', parseSourceId, 'local')
    .option('--licence <text>', 'with --from: licence to record')
    .option('--attribution <text>', 'with --from: attribution to record')
    .option('--grid <id>', "LiDAR source whose squares to take (default: the store's only one)")
    .option('--squares <names>', 'these squares only, separated by commas', parseNameList)
    .option('--all', 'also squares whose points are not there yet')
    .option(
      '--resolution-m <m>',
      "metres a pixel, 0.01 to 100 (default: the source's)",
      metres(0.01, 100),
    )
    .option(
      '--margin-m <m>',
      'ground around the square, 0 to 1000 metres',
      metres(0, 1000),
      kDefaultMargin_m,
    )
    .option('--time <t>', 'pictures of this year or date, for sources that have several', parseTime)
    .option('--lossless', 'DEFLATE instead of JPEG')
    .option('--again', 'make again what is there')
    .addOption(limit('--retries <n>', 'tries after the first', 0, 20, 'tries after the first', 5))
    .addOption(limit('--timeout-s <s>', kSilence, 1, 3600, 'seconds', 60))
    .option('--dry-run', 'list what would be made')
    .option('--json', 'one JSON object a line on standard output')
    .action(async (options: OrthoOptions) => context.exit(await makeOrthophotos(options, context)));
}

/**
 * An orthophoto for each square that was chosen.
 * @return the exit code
 */
export async function makeOrthophotos(options: OrthoOptions, context: CliContext): Promise<number> {
  const { signal } = context;
  const source = await chooseSource(options, context);
  const reporter = orthoReporter(context.output, options.json ?? false);
  const http = openClient(context, options, accessTo(source));
  try {
    return await writeStore(options.store, signal, async (store) => {
      const squares = chooseSquares(store, options);
      if (options.dryRun === true) {
        for (const square of squares) reporter.would(square.key.name);
        reporter.summary({ made: 0, kept: 0, missing: 0, failed: 0 });
        return kExit.done;
      }
      await removeStaleWork(store.root);
      return await withWorkFolder(store.root, (cache) =>
        makeAll(squares, source, options, store, http, cache, reporter, context),
      );
    });
  } finally {
    await http.close();
  }
}

/**
 * Determines which hosts may be contacted; none for local pictures.
 * @throws GrabberError SECRET when the environment lacks one
 */
function accessTo(source: OrthoSource | undefined): Access {
  if (source === undefined) return kNoAccess;
  return {
    hosts: orthoHosts(source),
    privateOrigins: orthoPrivateOrigins(source),
    secretHeaders: readSecretHeaders(source.secret_headers, process.env),
    secretOrigins: [originOfTemplate(source.access.url)],
  };
}

async function makeAll(
  squares: readonly StoreRecord[],
  source: OrthoSource | undefined,
  options: OrthoOptions,
  store: Store,
  http: HttpClient,
  cacheFolder: string,
  reporter: OrthoReporter,
  context: CliContext,
): Promise<number> {
  const { signal } = context;
  const found = source === undefined ? undefined : gatherFor(source, cacheFolder);
  const settings = makeOrthoSettings(
    source,
    options,
    http,
    cacheFolder,
    found?.gather ?? localGather(options.from ?? '', null),
    reporter,
  );
  learnOrthophotos(store, settings, squares);
  const tally = { made: 0, kept: 0, missing: 0, failed: 0 };
  const todo: StoreRecord[] = [];
  for (const square of squares) {
    const record = store.orthophotos.get(orthoKey(settings.source, square));
    if (record !== undefined && options.again !== true && (await isMade(record, store, settings))) {
      ++tally.kept;
    } else todo.push(square);
  }
  store.orthophotos.want(
    todo.map((square) => orthoKey(settings.source, square)),
    true,
  );
  for (const square of todo) {
    await makeOne(square, store, settings, http.redact, reporter, tally, signal);
    await found?.cache.trim();
  }
  reporter.summary(tally);
  return toExitCode(tally);
}

function toExitCode({ failed, missing }: OrthoTally): number {
  if (failed > 0) return kExit.failed;
  return missing > 0 ? kExit.holes : kExit.done;
}

async function makeOne(
  square: StoreRecord,
  store: Store,
  settings: OrthoSettings,
  redact: Redact,
  reporter: OrthoReporter,
  tally: { made: number; missing: number; failed: number },
  signal: AbortSignal,
): Promise<void> {
  try {
    const made = await makeOrthophoto(square, store, settings, signal);
    if (made.state === 'made') ++tally.made;
    else ++tally.missing;
    reporter.made(square.key.name, made);
  } catch (error) {
    signal.throwIfAborted();
    if (!isOfFile(error)) throw error;
    const code = recordedCode(error);
    const message = redact(describeError(error));
    store.orthophotos.failed(orthoKey(settings.source, square), code, message);
    ++tally.failed;
    reporter.failed(square.key.name, code, message);
  }
}

function makeOrthoSettings(
  source: OrthoSource | undefined,
  options: OrthoOptions,
  http: HttpClient,
  cache: string,
  gather: OrthoSettings['gather'],
  reporter: OrthoReporter,
): OrthoSettings {
  return {
    source: source?.id ?? options.as,
    terms: {
      licence: source?.licence ?? options.licence ?? null,
      attribution: source?.attribution ?? options.attribution ?? null,
    },
    gather,
    download: downloader({
      http,
      policy: { ...kBackoff, retries: options.retries },
      clock: kSystemClock,
      limiter: new HostRateLimiter(kSystemClock, kMaxWait_ms),
      disk: new DiskSpace(cache),
      missingStatus: source?.missing_status ?? [],
      onRetry: (notice) => reporter.retry(notice),
    }),
    concurrency: source?.max_concurrent ?? 1,
    time: options.time,
    resolution_m: options.resolutionM ?? source?.resolution_m ?? kLocalResolution_m,
    margin_m: options.marginM,
    cut: { lossless: options.lossless ?? false, nearInfrared: source?.bands === 'rgbi' },
    cache,
  };
}

async function chooseSource(
  options: OrthoOptions,
  context: CliContext,
): Promise<OrthoSource | undefined> {
  if (options.source === undefined && options.from !== undefined) return undefined;
  if (options.from !== undefined) {
    throw usage('choose orthophotos: --source and --from; allowed: one of them');
  }
  const given = { '--licence': options.licence, '--attribution': options.attribution };
  const term = Object.entries(given).find(([, value]) => value !== undefined)?.[0];
  if (options.source !== undefined && term !== undefined) {
    throw usage(
      `choose orthophotos: ${term} with --source, which has its own; allowed: with --from`,
    );
  }
  return findOrthoSource(options.source, context);
}

/** @throws GrabberError USAGE when there is none of that name, or no name was given */
export async function findOrthoSource(
  id: string | undefined,
  context: CliContext,
): Promise<OrthoSource> {
  const sources = await loadConfigFolder(
    join(context.configFolder(), 'sources', 'ortho'),
    kOrthoKind,
    context.signal,
  );
  const names = [...sources.keys()].join(', ') || 'none, the folder is empty';
  if (id === undefined) {
    throw usage(
      'choose orthophotos: neither --source nor --from is given; allowed: --from <path>, ' +
        `or --source of ${names}`,
    );
  }
  const source = sources.get(id);
  if (source === undefined) {
    throw usage(`choose orthophotos: "${id}"; allowed: ${names}`);
  }
  return source;
}

function chooseSquares(store: Store, options: OrthoOptions): StoreRecord[] {
  const { all, grid: source, squares: names } = options;
  const which = all === true ? { states: kUsableOrWanted } : { usable: true as const };
  const squares = store.squares.list({ ...which, source, names });
  const grids = [...new Set(squares.map((square) => square.key.source))];
  if (grids.length > 1) {
    throw usage(
      `choose squares: the store has those of ${grids.join(', ')}; allowed: one of them ` +
        'with --grid',
    );
  }
  if (squares.length === 0) {
    throw usage(
      `choose squares of ${store.root}: none; allowed: squares that are fetched and ` +
        'verified (--all takes others too)',
    );
  }
  return squares;
}

function metres(low: number, high: number): (text: string) => number {
  return (text) => {
    const value = Number(text);
    if (/^\d+(\.\d+)?$/.test(text) && value >= low && value <= high) return value;
    throw new InvalidArgumentError(`allowed: a number from ${low} to ${high}, metres`);
  };
}

function parseTime(text: string): string {
  if (/^\d{4}(-\d{2}(-\d{2})?)?$/.test(text)) return text;
  throw new InvalidArgumentError('allowed: a year or a date, such as 2023 or 2023-06-21');
}

export type OrthoTally = {
  readonly made: number;
  readonly kept: number;
  readonly missing: number;
  readonly failed: number;
};

/** Reports the progress of orthophotos, as text or as JSON. */
export type OrthoReporter = {
  would(square: string): void;
  made(square: string, made: Made): void;
  failed(square: string, code: string, message: string): void;
  retry(notice: RetryNotice): void;
  summary(tally: OrthoTally): void;
};

/**
 * @param json  one object a line to standard output; else results there and troubles to standard
 * error
 */
export function orthoReporter(output: Output, json: boolean): OrthoReporter {
  return json ? jsonReporter(output) : textReporter(output);
}

function textReporter(output: Output): OrthoReporter {
  return {
    would: (square) => output.outLine(square),
    made(square, made) {
      if (made.state === 'missing') return output.errLine(`hole: ${made.reason}`);
      const { file, image } = made;
      output.outLine(
        `made ${square}  ${formatBytes(file.bytes)}  ${image.width_px} x ` +
          `${image.height_px} pixels  ${file.path}`,
      );
      for (const warning of made.warnings) output.errLine(`warning: ${square}: ${warning}`);
    },
    failed: (square, code, message) => output.errLine(`error: ${square} ${code}: ${message}`),
    retry: ({ error, retry, wait_ms }) =>
      output.errLine(`retry ${retry} in ${(wait_ms / 1000).toFixed(1)} s: ${error.message}`),
    summary: ({ made, kept, missing, failed }) =>
      output.outLine(`${made} made, ${kept} already there, ${missing} missing, ${failed} failed`),
  };
}

function jsonReporter(output: Output): OrthoReporter {
  const line = (fields: Readonly<Record<string, unknown>>): void =>
    output.outLine(JSON.stringify(fields));
  return {
    would: (square) => line({ event: 'would', square }),
    made: (square, made) => line({ event: 'orthophoto', square, ...made }),
    failed: (square, code, message) =>
      line({ event: 'orthophoto', state: 'failed', square, code, message }),
    retry: ({ error, retry, wait_ms }) =>
      line({ event: 'retry', retry, wait_ms, code: error.code, message: error.message }),
    summary: (tally) => line({ event: 'summary', ...tally }),
  };
}

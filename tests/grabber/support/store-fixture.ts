import { mkdir, mkdtemp, readdir, rm, writeFile } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import type { TestContext } from 'node:test';
import { DiskSpace } from '../../../grabber/src/fetch/disk-space.js';
import {
  type FetchJob,
  type FetchRun,
  runJobs,
  syncQueue,
} from '../../../grabber/src/fetch/run-jobs.js';
import { HostRateLimiter, HostQueues } from '../../../grabber/src/fetch/host-queues.js';
import {
  createHttpClient,
  type Access,
  type SourceClient,
} from '../../../grabber/src/fetch/http-client.js';
import {
  checkLidar,
  checkLidarStart,
  kLidarExtensions,
} from '../../../grabber/src/fetch/lidar-check.js';
import type {
  CatalogueSquare,
  RecordKey,
  StoreRecord,
  Store,
} from '../../../grabber/src/model/store.js';
import type { Outcome } from '../../../grabber/src/progress/reporter.js';
import { openStore } from '../../../grabber/src/store/open-store.js';
import type { Clock } from '../../../grabber/src/util/clock.js';

export const kNever = new AbortController().signal;
export const kName = '462_101';
const kTerms = {
  crs: 'EPSG:3794',
  classTable: 'asprs',
  licence: 'CC BY 4.0',
  attribution: 'Somebody',
};

export async function temporaryFolder(t: TestContext): Promise<string> {
  const folder = await mkdtemp(join(tmpdir(), 'terravox-grabber-'));
  t.after(() => rm(folder, { recursive: true, force: true }));
  return folder;
}

export function toKey(name: string): RecordKey {
  return { source: 'test', grid: 'test', name };
}

/** A square of the 1 km grid at these addresses. */
export function makeSquare(
  name: string,
  urls: readonly string[],
  more: Partial<CatalogueSquare> = {},
): CatalogueSquare {
  const [east = NaN, north = NaN] = name.split('_').map((km) => Number(km) * 1000);
  return {
    name,
    block: null,
    bounds: [east, north, east + 1000, north + 1000],
    urls,
    bytes: null,
    sha256: null,
    member: null,
    published: null,
    ...more,
  };
}

export type FixtureOptions = {
  root?: string;
  retries?: number;
  maxWaitMs?: number;
  concurrency?: number;
  max_per_s?: number;
  access?: Partial<Access>;
  job?: Partial<FetchJob>;
  timeout_ms?: number;
  freeBytes?: () => number;
  /** Bytes of the body that the reader has taken. */
  onStored?: (bytes: number) => void;
};

export type Fixture = {
  readonly root: string;
  readonly store: Store;
  readonly clock: FakeClock;
  readonly retries: string[];
  readonly outcomes: Outcome[];
  /** Learns and wants the squares, and runs until all are done. */
  fetch(
    squares: readonly CatalogueSquare[],
    again?: boolean,
    signal?: AbortSignal,
  ): Promise<Outcome[]>;
  /** Continues what is unfinished. */
  resume(): Promise<Outcome[]>;
  record(name?: string): StoreRecord | undefined;
};

/** Counts the bytes of a body that the reader has taken and processed. */
function watched(http: SourceClient, onStored: (bytes: number) => void): SourceClient {
  async function* watch(body: AsyncIterable<Uint8Array>): AsyncGenerator<Uint8Array> {
    let bytes = 0;
    for await (const chunk of body) {
      yield chunk;
      bytes += chunk.length;
      onStored(bytes);
    }
  }
  return {
    head: (url, headers, signal) => http.head(url, headers, signal),
    permit: (access) => http.permit(access),
    redact: http.redact,
    close: () => http.close(),
    get: async (url, headers, signal) => {
      const response = await http.get(url, headers, signal);
      return { ...response, body: watch(response.body) };
    },
  };
}

/**
 * All that a fetch from a server of this machine needs, in a store of its own, with a clock that
 * does not wait.
 */
export async function fetchFixture(
  t: TestContext,
  base: string,
  options: FixtureOptions = {},
): Promise<Fixture> {
  const root = options.root ?? (await temporaryFolder(t));
  const clock = fakeClock('2026-06-21T12:00:00.000Z', 0.5);
  const { host, origin } = new URL(base);
  const access: Access = {
    hosts: [host],
    privateOrigins: [origin],
    secretHeaders: {},
    secretOrigins: [],
    ...options.access,
  };
  const http = watched(
    createHttpClient({
      userAgent: 'terravox-grabber/test',
      timeout_ms: options.timeout_ms ?? 20_000,
      access,
    }),
    options.onStored ?? (() => undefined),
  );
  const store = openStore(root, {}, kNever);
  t.after(async () => {
    store.close();
    await http.close();
  });
  const retries: string[] = [];
  const outcomes: Outcome[] = [];
  const run: FetchRun = {
    root,
    clock,
    policy: {
      retries: options.retries ?? 3,
      base_ms: 1000,
      cap_ms: 60_000,
      max_wait_ms: options.maxWaitMs ?? 600_000,
    },
    queues: new HostQueues(new HostRateLimiter(clock, options.maxWaitMs ?? 600_000)),
    disk: new DiskSpace(
      root,
      options.freeBytes === undefined ? undefined : () => options.freeBytes?.() ?? 0,
    ),
    syncs: syncQueue(),
    events: {
      plan: () => undefined,
      begin: () => undefined,
      bytes: () => undefined,
      retry: (_key, notice) => void retries.push(notice.error.code),
      outcome: (outcome) => void outcomes.push(outcome),
    },
  };
  const work = async (records: readonly StoreRecord[], signal: AbortSignal): Promise<Outcome[]> => {
    outcomes.length = 0;
    const job: FetchJob = {
      kind: 'lidar',
      table: store.squares,
      records,
      http,
      limits: { max_concurrent: options.concurrency ?? 4, max_per_s: options.max_per_s ?? null },
      missingStatus: [404],
      max_bytes: 1024 ** 3,
      allowFiles: false,
      extensions: kLidarExtensions,
      checkStart: checkLidarStart,
      check: checkLidar,
      locate: undefined,
      ...options.job,
    };
    await runJobs([job], run, signal);
    return [...outcomes];
  };
  return {
    root,
    store,
    clock,
    retries,
    outcomes,
    fetch: (squares, again = false, signal = kNever) => {
      store.squares.learn('test', 'test', 'EPSG:3794', kTerms, squares);
      const names = squares.map(({ name }) => name);
      store.squares.want(names.map(toKey), again);
      return work(store.squares.unfinished({ source: 'test', names }), signal);
    },
    resume: () => work(store.squares.unfinished({}), kNever),
    record: (name = kName) => store.squares.get(toKey(name)),
  };
}

/** Leaves an unfinished file of a square, with what is known of how to continue it. */
export async function leavePart(
  root: string,
  part: Buffer | undefined,
  state: { url: string; if_range: string | null; total_bytes: number | null },
  name = kName,
): Promise<void> {
  await mkdir(join(root, 'lidar/test'), { recursive: true });
  if (part !== undefined) await writeFile(join(root, `lidar/test/.${name}.part`), part);
  await writeFile(join(root, `lidar/test/.${name}.part.json`), JSON.stringify(state));
}

/** Names of all files in a store, relative and sorted, without the database. */
export async function storedFiles(root: string): Promise<string[]> {
  const names = await readdir(root, { recursive: true, withFileTypes: true });
  return names
    .filter((entry) => entry.isFile() && !/^(fishnet\.gpkg|\.grabber\.lock)/.test(entry.name))
    .map((entry) =>
      join(entry.parentPath, entry.name)
        .slice(root.length + 1)
        .replaceAll('\\', '/'),
    )
    .sort();
}

export type FakeClock = { -readonly [K in keyof Clock]: Clock[K] } & {
  readonly slept_ms: number[];
};

/** Sleeps take no time here, but move the time on. */
export function fakeClock(start = '2026-06-21T12:00:00.000Z', random = 0): FakeClock {
  let now_ms = Date.parse(start);
  const slept_ms: number[] = [];
  return {
    slept_ms,
    now: () => new Date(now_ms),
    random: () => random,
    sleep: (ms, signal) => {
      signal.throwIfAborted();
      slept_ms.push(ms);
      now_ms += ms;
      return Promise.resolve();
    },
  };
}

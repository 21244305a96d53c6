import { open, mkdir, rm } from 'node:fs/promises';
import { createHash } from 'node:crypto';
import { join } from 'node:path';
import PQueue from 'p-queue';
import { withStoreErrors, type DiskSpace, type Reservation } from '../fetch/disk-space.js';
import type { HostRateLimiter } from '../fetch/host-queues.js';
import type { HttpClient, HttpResponse } from '../fetch/http-client.js';
import { withoutSecrets } from '../fetch/redact.js';
import { statusError } from '../fetch/response-check.js';
import { withRetries, type RetryNotice, type RetryPolicy } from '../fetch/retry.js';
import type { Clock } from '../util/clock.js';
import { GrabberError } from '../util/errors.js';
import { fileSize, decodeText } from '../util/files.js';

export type DownloadSettings = {
  readonly http: HttpClient;
  readonly policy: RetryPolicy;
  readonly clock: Clock;
  readonly limiter: HostRateLimiter;
  /** Of the folder that files go to. */
  readonly disk: DiskSpace;
  readonly missingStatus: readonly number[];
  readonly onRetry: (notice: RetryNotice) => void;
};

/** Fetches small things whole; what fails on the way is tried again from its beginning. */
export type Downloader = {
  /**
   * @return false where the server says that there is none
   * @throws GrabberError, LENGTH past `max_bytes`
   */
  toFile(url: string, path: string, max_bytes: number, signal: AbortSignal): Promise<boolean>;
  /** @return undefined where the server says that there is none */
  text(url: string, max_bytes: number, signal: AbortSignal): Promise<string | undefined>;
};

export function downloader(settings: DownloadSettings): Downloader {
  const again = <T>(attempt: () => Promise<T>, signal: AbortSignal): Promise<T> =>
    withRetries(
      () => withoutSecrets(settings.http.redact, attempt),
      settings.policy,
      settings.clock,
      settings.onRetry,
      signal,
    );

  return {
    toFile: (url, path, max_bytes, signal) =>
      again(async () => {
        const response = await get(url, settings, signal);
        if (response === undefined) return false;
        await store(url, response, path, max_bytes, settings.disk);
        return true;
      }, signal),
    text: (url, max_bytes, signal) =>
      again(async () => {
        const response = await get(url, settings, signal);
        return response === undefined ? undefined : readText(url, response, max_bytes);
      }, signal),
  };
}

/** @return undefined where the server says that there is none */
async function get(
  url: string,
  { http, clock, limiter, missingStatus }: DownloadSettings,
  signal: AbortSignal,
): Promise<HttpResponse | undefined> {
  const { host } = new URL(url);
  await limiter.acquire(host, signal);
  const response = await http.get(url, { 'accept-encoding': 'identity' }, signal);
  if (response.status === 200) return response;
  await response.discard();
  // Status 204 is the answer for a tile without a picture.
  if (response.status === 204 || missingStatus.includes(response.status)) return undefined;
  const error = statusError(url, response, missingStatus, clock.now());
  if (error.retryAfterMs !== undefined) limiter.pause(host, error.retryAfterMs);
  throw error;
}

async function store(
  url: string,
  response: HttpResponse,
  path: string,
  max_bytes: number,
  disk: DiskSpace,
): Promise<void> {
  const reservation = await reserve(url, response, disk);
  try {
    const file = await open(path, 'w');
    try {
      for await (const part of limited(url, response, max_bytes)) {
        reservation.grow(part.length);
        await withStoreErrors(path, () => file.write(part));
      }
    } finally {
      await file.close();
    }
  } finally {
    reservation.release();
  }
}

/**
 * @throws GrabberError DISK_FULL before the body is read, where its length is announced; and later
 *   where it is not
 */
async function reserve(url: string, response: HttpResponse, disk: DiskSpace): Promise<Reservation> {
  try {
    const announced = announcedBytes(response);
    if (announced === undefined) return disk.reserveGrowing(0, url);
    return { grow: () => undefined, release: disk.reserve(announced, url) };
  } catch (error) {
    await response.discard();
    throw error;
  }
}

async function readText(url: string, response: HttpResponse, max_bytes: number): Promise<string> {
  const parts: Uint8Array[] = [];
  for await (const part of limited(url, response, max_bytes)) parts.push(part);
  return decodeText(parts);
}

/** The body, which must be as long as announced and no longer than allowed. */
async function* limited(
  url: string,
  response: HttpResponse,
  max_bytes: number,
): AsyncGenerator<Uint8Array> {
  const announced = announcedBytes(response);
  let bytes = 0;
  for await (const part of response.body) {
    bytes += part.length;
    if (bytes > max_bytes) {
      throw new GrabberError(
        'LENGTH',
        `fetch ${url}: more than ${max_bytes} bytes; allowed: at most that`,
      );
    }
    yield part;
  }
  if (announced !== undefined && announced !== bytes) {
    throw new GrabberError(
      'LENGTH',
      `fetch ${url}: ${bytes} bytes; allowed: ${announced}, as announced`,
      { retryable: true },
    );
  }
}

function announcedBytes(response: HttpResponse): number | undefined {
  const announced = Number(response.header('content-length') ?? Number.NaN);
  return Number.isInteger(announced) && announced >= 0 ? announced : undefined;
}

const kMaxAsset_bytes = 16 * 2 ** 30;
const kMaxKept_bytes = 24 * 2 ** 30;

/**
 * Whole files that squares side by side need; the oldest go when there are too many. One a run and
 * source.
 */
export class AssetCache {
  readonly #folder: string;
  /** In the order of their last use. */
  readonly #kept = new Map<string, { readonly path: Promise<string | undefined>; bytes: number }>();

  constructor(folder: string) {
    this.#folder = folder;
  }

  /**
   * @return where the file lies, undefined where the server says that there is none; callers at
   * once share one download
   */
  async get(url: string, download: Downloader, signal: AbortSignal): Promise<string | undefined> {
    const known = this.#kept.get(url) ?? { path: this.#fetch(url, download, signal), bytes: 0 };
    this.#kept.delete(url);
    this.#kept.set(url, known);
    try {
      const path = await known.path;
      known.bytes = path === undefined ? 0 : ((await fileSize(path)) ?? 0);
      return path;
    } catch (error) {
      this.#kept.delete(url);
      throw error;
    }
  }

  /** Call between squares: what is in use is never removed. */
  async trim(): Promise<void> {
    let bytes = [...this.#kept.values()].reduce((sum, one) => sum + one.bytes, 0);
    for (const [url, one] of this.#kept) {
      if (bytes <= kMaxKept_bytes) return;
      const path = await one.path;
      if (path !== undefined) await rm(path, { force: true });
      bytes -= one.bytes;
      this.#kept.delete(url);
    }
  }

  async #fetch(
    url: string,
    download: Downloader,
    signal: AbortSignal,
  ): Promise<string | undefined> {
    await mkdir(this.#folder, { recursive: true });
    const path = join(this.#folder, `${createHash('sha256').update(url).digest('hex')}.asset`);
    return (await download.toFile(url, path, kMaxAsset_bytes, signal)) ? path : undefined;
  }
}

/**
 * Runs tasks, some at a time. The first failure stops the others, and is thrown only when none of
 * them runs any more: their files are about to be removed.
 * @return the results in the order of the tasks
 */
export async function runAll<T>(
  tasks: readonly ((signal: AbortSignal) => Promise<T>)[],
  concurrency: number,
  signal: AbortSignal,
): Promise<T[]> {
  signal.throwIfAborted();
  const stop = new AbortController();
  const both = AbortSignal.any([signal, stop.signal]);
  const queue = new PQueue({ concurrency });
  let failed = false;
  let reason: unknown;
  const results: T[] = [];
  tasks.forEach((task, index) => {
    void queue.add(async () => {
      if (both.aborted) return;
      try {
        results[index] = await task(both);
      } catch (error) {
        if (!failed) reason = error;
        failed = true;
        stop.abort();
      }
    });
  });
  await queue.onIdle();
  signal.throwIfAborted();
  if (failed) throw reason;
  return results;
}

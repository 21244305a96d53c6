import { open } from 'node:fs/promises';
import { withStoreErrors, type DiskSpace, type Reservation } from '../fetch/disk-space.js';
import type { HostRateLimiter } from '../fetch/host-rate-limiter.js';
import type { HttpClient, HttpResponse } from '../fetch/http-client.js';
import { withoutSecrets } from '../fetch/redact.js';
import { statusError } from '../fetch/response-error.js';
import { withRetries, type RetryNotice, type RetryPolicy } from '../fetch/retry.js';
import type { Clock } from '../util/clock.js';
import { GrabberError } from '../util/errors.js';

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
  return Buffer.concat(parts)
    .toString('utf8')
    .replace(/^\uFEFF/, '');
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

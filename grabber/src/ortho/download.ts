import { open } from 'node:fs/promises';
import { storing, type DiskSpace, type Growing } from '../fetch/disk-space.js';
import type { HostGate } from '../fetch/host-gate.js';
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
  readonly gate: HostGate;
  /** Of the folder that files go to. */
  readonly disk: DiskSpace;
  readonly missingStatus: readonly number[];
  readonly onRetry: (notice: RetryNotice) => void;
};

/** Fetches small things whole; what fails on the way is tried again from its beginning. */
export type Downloader = {
  /** @return false where the server says that there is none @throws GrabberError, LENGTH past `most_bytes` */
  toFile(url: string, path: string, most_bytes: number, signal: AbortSignal): Promise<boolean>;
  /** @return undefined where the server says that there is none */
  text(url: string, most_bytes: number, signal: AbortSignal): Promise<string | undefined>;
};

export function downloader(settings: DownloadSettings): Downloader {
  const { http, policy, clock, gate, missingStatus } = settings;

  async function get(url: string, signal: AbortSignal): Promise<HttpResponse | undefined> {
    const { host } = new URL(url);
    await gate.pass(host, signal);
    const response = await http.get(url, { 'accept-encoding': 'identity' }, signal);
    if (response.status === 200) return response;
    await response.discard();
    // 204: a tile without a picture.
    if (response.status === 204 || missingStatus.includes(response.status)) return undefined;
    const error = statusError(url, response, missingStatus, clock.now());
    if (error.retryAfterMs !== undefined) gate.closeFor(host, error.retryAfterMs);
    throw error;
  }

  async function store(url: string, response: HttpResponse, path: string, most_bytes: number): Promise<void> {
    const room = await reserve(url, response);
    try {
      const file = await open(path, 'w');
      try {
        for await (const part of limited(url, response, most_bytes)) {
          room.grow(part.length);
          await storing(path, () => file.write(part));
        }
      } finally {
        await file.close();
      }
    } finally {
      room.giveBack();
    }
  }

  /** @throws GrabberError DISK_FULL before the body is read, where its length is announced; and later where it is not */
  async function reserve(url: string, response: HttpResponse): Promise<Growing> {
    try {
      const announced = announcedBytes(response);
      if (announced === undefined) return settings.disk.growing(0, url);
      return { grow: () => undefined, giveBack: settings.disk.reserve(announced, url) };
    } catch (error) {
      await response.discard();
      throw error;
    }
  }

  const again = <T>(attempt: () => Promise<T>, signal: AbortSignal): Promise<T> =>
    withRetries(() => withoutSecrets(http.redact, attempt), policy, clock, settings.onRetry, signal);

  return {
    toFile: (url, path, most_bytes, signal) =>
      again(async () => {
        const response = await get(url, signal);
        if (response === undefined) return false;
        await store(url, response, path, most_bytes);
        return true;
      }, signal),
    text: (url, most_bytes, signal) =>
      again(async () => {
        const response = await get(url, signal);
        if (response === undefined) return undefined;
        const parts: Uint8Array[] = [];
        for await (const part of limited(url, response, most_bytes)) parts.push(part);
        return Buffer.concat(parts).toString('utf8').replace(/^\uFEFF/, '');
      }, signal),
  };
}

/** The body, which must be as long as announced and no longer than allowed. */
async function* limited(url: string, response: HttpResponse, most_bytes: number): AsyncGenerator<Uint8Array> {
  const announced = announcedBytes(response);
  let bytes = 0;
  for await (const part of response.body) {
    bytes += part.length;
    if (bytes > most_bytes) {
      throw new GrabberError('LENGTH', `fetch ${url}: more than ${most_bytes} bytes; allowed: at most that`);
    }
    yield part;
  }
  if (announced !== undefined && announced !== bytes) {
    throw new GrabberError('LENGTH', `fetch ${url}: ${bytes} bytes; allowed: ${announced}, as announced`, { retryable: true });
  }
}

function announcedBytes(response: HttpResponse): number | undefined {
  const announced = Number(response.header('content-length') ?? Number.NaN);
  return Number.isInteger(announced) && announced >= 0 ? announced : undefined;
}

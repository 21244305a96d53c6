import { createHash, type Hash } from 'node:crypto';
import { closeSync, constants } from 'node:fs';
import { copyFile, stat } from 'node:fs/promises';
import { fileURLToPath } from 'node:url';
import type { Clock } from '../util/clock.js';
import { GrabberError, systemCode, causedError } from '../util/errors.js';
import { hashFileInto, sha256OfFile } from '../util/files.js';
import { tooLarge, writeBody, decoded } from './body-writer.js';
import { type DiskSpace, type Reservation, withStoreErrors } from './disk-space.js';
import type { HostRateLimiter } from './host-queues.js';
import type { HttpClient, HttpResponse } from './http-client.js';
import {
  findPartial,
  forgetState,
  openPartial,
  rememberState,
  rememberWhole,
  removePartial,
  type Resumable,
} from './partial.js';
import { withoutSecrets, shownUrl } from './redact.js';
import {
  bodyPlan,
  isWhole,
  kRangeRefused,
  type BodyPlan,
  htmlError,
  statusError,
} from './response-check.js';

export type TransferContext = {
  readonly http: HttpClient;
  readonly limiter: HostRateLimiter;
  readonly disk: DiskSpace;
  readonly clock: Clock;
  readonly missingStatus: readonly number[];
  readonly max_bytes: number;
  /** Size by the catalogue, 0 when it gives none; used to reserve disk space only. */
  readonly expected_bytes: number;
  /**
   * @throws GrabberError when a file may not begin so; before hundreds of megabytes are spent on it
   */
  checkStart(shown: string, start: Uint8Array): void;
  /** @param total_bytes of the whole file, undefined = not known */
  onBytes(done_bytes: number, fresh_bytes: number, total_bytes: number | undefined): void;
};

export type TransferResult =
  | { readonly kind: 'complete'; readonly bytes: number; readonly sha256: string }
  /** The source answered that it has no such file. */
  | { readonly kind: 'missing'; readonly reason: string };

/** One attempt to fetch a file; a call after a broken one continues where that stopped. */
export function transferOnce(
  url: string,
  partial: string,
  context: TransferContext,
  signal: AbortSignal,
): Promise<TransferResult> {
  return withoutSecrets(context.http.redact, () => transfer(url, partial, context, signal));
}

async function transfer(
  url: string,
  partial: string,
  context: TransferContext,
  signal: AbortSignal,
): Promise<TransferResult> {
  const found = await findPartial(partial, url, signal);
  const hash = createHash('sha256');
  if (found.kind !== 'nothing') await hashFileInto(hash, partial, signal);
  if (found.kind === 'whole') {
    return { kind: 'complete', bytes: found.bytes, sha256: hash.digest('hex') };
  }
  const resumable = found.kind === 'part' ? found.part : undefined;

  const response = await context.http.get(url, requestHeaders(resumable), signal);
  if (context.missingStatus.includes(response.status)) {
    await response.discard();
    removePartial(partial);
    return { kind: 'missing', reason: `HTTP ${response.status}` };
  }
  if (resumable !== undefined && isWhole(response, resumable)) {
    await response.discard();
    return { kind: 'complete', bytes: resumable.offset_bytes, sha256: hash.digest('hex') };
  }
  const plan = await planTransfer(url, partial, response, resumable, context);
  try {
    if (plan.total_bytes !== undefined && plan.total_bytes > context.max_bytes) {
      throw tooLarge(shownUrl(url), plan.total_bytes, context.max_bytes);
    }
    return await receive(
      url,
      partial,
      response,
      plan,
      plan.offset_bytes > 0 ? hash : createHash('sha256'),
      context,
    );
  } catch (error) {
    // An unread body holds its connection.
    await response.discard();
    throw error;
  }
}

/**
 * Compressed transfer would hide the length and break ranges, and LAZ does not shrink; some servers
 * compress unless the request names another encoding.
 */
function requestHeaders(resumable: Resumable | undefined): Record<string, string> {
  const headers = { 'accept-encoding': 'identity' };
  if (resumable === undefined) return headers;
  return { ...headers, range: `bytes=${resumable.offset_bytes}-`, 'if-range': resumable.if_range };
}

async function planTransfer(
  url: string,
  partial: string,
  response: HttpResponse,
  resumable: Resumable | undefined,
  context: TransferContext,
): Promise<BodyPlan> {
  try {
    if (response.status === kRangeRefused && resumable !== undefined) {
      throw new GrabberError(
        'RESUME_REFUSED',
        `continue ${shownUrl(url)} at byte ${resumable.offset_bytes}: HTTP 416; the next ` +
          'try starts anew',
        { retryable: true },
      );
    }
    if (response.status !== 200 && response.status !== 206) {
      const error = statusError(url, response, context.missingStatus, context.clock.now());
      if (error.retryAfterMs !== undefined) {
        context.limiter.pause(new URL(url).host, error.retryAfterMs);
      }
      throw error;
    }
    return bodyPlan(url, response, resumable);
  } catch (error) {
    await response.discard();
    // A busy server implies nothing about the file; any other refusal makes our part of it useless.
    if (!(error instanceof GrabberError) || error.code !== 'HTTP_STATUS') removePartial(partial);
    throw error;
  }
}

async function receive(
  url: string,
  partial: string,
  response: HttpResponse,
  plan: BodyPlan,
  hash: Hash,
  context: TransferContext,
): Promise<TransferResult> {
  const reservation = reservationFor(plan, context, shownUrl(url));
  try {
    const bytes = await store(url, partial, response, plan, hash, context, reservation);
    if (plan.total_bytes !== undefined && bytes !== plan.total_bytes) {
      refuseLength(url, partial, bytes, plan.total_bytes);
    }
    return { kind: 'complete', bytes, sha256: hash.digest('hex') };
  } catch (error) {
    if (
      error instanceof GrabberError &&
      ['HTML_BODY', 'NOT_LAS', 'TOO_LARGE'].includes(error.code)
    ) {
      removePartial(partial);
    }
    throw error;
  } finally {
    reservation.release();
  }
}

function reservationFor(
  { total_bytes, offset_bytes }: BodyPlan,
  { disk, expected_bytes }: TransferContext,
  shown: string,
): Reservation {
  if (total_bytes === undefined) return disk.reserveGrowing(expected_bytes - offset_bytes, shown);
  return {
    grow: () => undefined,
    release: disk.reserve(Math.max(0, total_bytes - offset_bytes), shown),
  };
}

async function store(
  url: string,
  partial: string,
  response: HttpResponse,
  plan: BodyPlan,
  hash: Hash,
  context: TransferContext,
  reservation: Reservation,
): Promise<number> {
  const { offset_bytes, total_bytes, coding } = plan;
  // An earlier state file would describe the new file as the old one.
  if (offset_bytes === 0) forgetState(partial);
  const fd = openPartial(partial, offset_bytes);
  try {
    // An offset in the unpacked file is none in the compressed body, so it cannot be continued.
    if (offset_bytes === 0 && coding === undefined) {
      rememberState(partial, url, response, total_bytes);
    }
    const onWhole = (bytes: number): void => {
      if (total_bytes === undefined) rememberWhole(partial, url, bytes);
    };
    const body = coding === undefined ? response.body : decoded(response.body, coding, url);
    const onPiece = (piece: Uint8Array, before: number): void => {
      if (before === 0) {
        const html = htmlError(url, response, piece, context.http.redact);
        if (html !== undefined) throw html;
        context.checkStart(shownUrl(url), piece);
      }
      reservation.grow(piece.length);
      context.onBytes(before + piece.length, piece.length, total_bytes);
    };
    const sink = {
      path: partial,
      fd,
      hash,
      offset_bytes,
      max_bytes: context.max_bytes,
      shown: shownUrl(url),
      onPiece,
      onWhole,
    };
    return await writeBody(body, sink, context.clock);
  } finally {
    closeSync(fd);
  }
}

/** @throws GrabberError LENGTH, always */
function refuseLength(url: string, partial: string, bytes: number, total: number): never {
  // Too few bytes can be continued; too many are a different file.
  if (bytes > total) removePartial(partial);
  throw new GrabberError(
    'LENGTH',
    `fetch ${shownUrl(url)}: got ${bytes} bytes; allowed: ${total}, as announced`,
    { retryable: true },
  );
}

/** Takes a file of this machine. File systems that can share blocks copy nothing (reflink). */
export async function copyLocal(
  url: string,
  partial: string,
  context: TransferContext,
  signal: AbortSignal,
): Promise<TransferResult> {
  const path = fileURLToPath(url);
  let bytes: number;
  try {
    const found = await stat(path);
    if (!found.isFile()) throw new Error('not a file');
    bytes = found.size;
  } catch (error) {
    if (systemCode(error) === 'ENOENT') {
      return { kind: 'missing', reason: 'no such file in the folder' };
    }
    throw causedError('LOCAL_FILE', `copy ${path}`, error, 'a file that can be read');
  }
  if (bytes > context.max_bytes) throw tooLarge(path, bytes, context.max_bytes);
  const release = context.disk.reserve(bytes, path);
  try {
    signal.throwIfAborted();
    removePartial(partial);
    await withStoreErrors(partial, () =>
      copyFile(path, partial, constants.COPYFILE_FICLONE | constants.COPYFILE_EXCL),
    );
    context.onBytes(bytes, bytes, bytes);
    return { kind: 'complete', bytes, sha256: await sha256OfFile(partial, signal) };
  } finally {
    release();
  }
}

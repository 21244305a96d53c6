import { createHash, type Hash } from 'node:crypto';
import { open, type FileHandle } from 'node:fs/promises';
import { looksLikeLas } from '../las/header.js';
import type { Square } from '../sources/square.js';
import type { Clock } from '../util/clock.js';
import { GrabberError, describeError } from '../util/errors.js';
import { hashFileInto } from '../util/files.js';
import type { HostGate } from './host-gate.js';
import type { HttpClient, HttpResponse } from './http-client.js';
import type { Origin, TransferResult } from './origin.js';
import { findResumable, rememberState, removePartial, type Resumable } from './partial.js';
import { kRangeRefused, bodyPlan, type BodyPlan } from './response-check.js';
import { htmlError, statusError } from './response-error.js';

export type RemoteOptions = {
  readonly urlOf: (square: Square) => string;
  readonly missingStatus: readonly number[];
  readonly http: HttpClient;
  readonly gate: HostGate;
  readonly clock: Clock;
};

/** Fetches from a web server, one attempt per call; a call after a broken one continues where that stopped. */
export function remoteOrigin(options: RemoteOptions): Origin {
  return {
    urlOf: options.urlOf,
    transfer: (square, partial, signal) => fetchOnce(options.urlOf(square), partial, options, signal),
  };
}

async function fetchOnce(
  url: string,
  partial: string,
  options: RemoteOptions,
  signal: AbortSignal,
): Promise<TransferResult> {
  const host = new URL(url).host;
  await options.gate.pass(host, signal);
  const resumable = await findResumable(partial, url, signal);
  const response = await options.http.get(url, requestHeaders(resumable), signal);

  if (options.missingStatus.includes(response.status)) {
    await response.discard();
    await removePartial(partial);
    return { kind: 'missing', reason: `HTTP ${response.status}` };
  }
  if (response.status === kRangeRefused && resumable !== undefined) {
    await response.discard();
    await removePartial(partial);
    throw new GrabberError(
      'RESUME_REFUSED',
      `continue ${url} at byte ${resumable.offset_bytes}: HTTP 416; the next try starts anew`,
      { retryable: true },
    );
  }
  if (response.status !== 200 && response.status !== 206) {
    await response.discard();
    const error = statusError(url, response, options.missingStatus, options.clock.now());
    if (error.retryAfterMs !== undefined) options.gate.closeFor(host, error.retryAfterMs);
    throw error;
  }

  let plan: BodyPlan;
  try {
    plan = bodyPlan(url, response, resumable);
  } catch (error) {
    await response.discard();
    await removePartial(partial);
    throw error;
  }
  let target: Target;
  try {
    target = await openTarget(partial, plan, signal);
  } catch (error) {
    // Nobody will read the body now, and an unread body holds its connection.
    await response.discard();
    throw error;
  }
  return receive(url, partial, response, plan, target, signal);
}

type Target = { readonly file: FileHandle; readonly hash: Hash };

async function openTarget(partial: string, plan: BodyPlan, signal: AbortSignal): Promise<Target> {
  const hash = createHash('sha256');
  if (plan.offset_bytes > 0) await hashFileInto(hash, partial, signal);
  return { hash, file: await storing(partial, () => open(partial, plan.offset_bytes > 0 ? 'a' : 'w')) };
}

/** Compressed transfer would hide the length and break ranges, and LAZ does not shrink; some servers do it unless told. */
function requestHeaders(resumable: Resumable | undefined): Record<string, string> {
  const headers = { 'accept-encoding': 'identity' };
  if (resumable === undefined) return headers;
  return { ...headers, range: `bytes=${resumable.offset_bytes}-`, 'if-range': resumable.if_range };
}

async function receive(
  url: string,
  partial: string,
  response: HttpResponse,
  plan: BodyPlan,
  { file, hash }: Target,
  signal: AbortSignal,
): Promise<TransferResult> {
  let bytes = plan.offset_bytes;
  try {
    await rememberState(partial, url, response, plan.total_bytes, signal);
    bytes = await appendBody(url, partial, response, { file, hash }, bytes);
    await storing(partial, () => file.sync());
  } catch (error) {
    if (error instanceof GrabberError && (error.code === 'HTML_BODY' || error.code === 'NOT_LAS'))
      await removePartial(partial);
    throw error;
  } finally {
    await file.close();
  }
  if (plan.total_bytes !== undefined && bytes !== plan.total_bytes) {
    // Too few bytes can be continued; too many are a different file.
    if (bytes > plan.total_bytes) await removePartial(partial);
    throw new GrabberError('LENGTH', `fetch ${url}: got ${bytes} bytes; allowed: ${plan.total_bytes}, as announced`, {
      retryable: true,
    });
  }
  return { kind: 'complete', bytes, sha256: hash.digest('hex') };
}

async function appendBody(
  url: string,
  partial: string,
  response: HttpResponse,
  { file, hash }: Target,
  offset: number,
): Promise<number> {
  let bytes = offset;
  for await (const chunk of response.body) {
    // The first bytes tell an error page or a foreign file before hundreds of megabytes are spent on it.
    if (bytes === 0) checkStart(url, response, chunk);
    await storing(partial, () => file.writeFile(chunk));
    hash.update(chunk);
    bytes += chunk.length;
  }
  return bytes;
}

function checkStart(url: string, response: HttpResponse, start: Uint8Array): void {
  const html = htmlError(url, response, start);
  if (html !== undefined) throw html;
  if (start.length >= 4 && !looksLikeLas(start)) {
    const shown = JSON.stringify(Buffer.from(start.subarray(0, 12)).toString('latin1'));
    throw new GrabberError(
      'NOT_LAS',
      `fetch ${url}: the body starts with ${shown}; allowed: "LASF", a LAS or LAZ file`,
    );
  }
}

/** Keeps a full disk apart from a broken network: only the second is worth another try. */
async function storing<T>(path: string, action: () => Promise<T>): Promise<T> {
  try {
    return await action();
  } catch (error) {
    throw new GrabberError('STORE_IO', `write ${path}: ${describeError(error)}`, { cause: error });
  }
}

import { GrabberError } from '../util/errors.js';
import { kCodings, type Coding } from './body-writer.js';
import type { HttpResponse } from './http-client.js';
import type { Resumable } from './partial.js';
import { shownUrl, type Redact } from './redact.js';
import { parseRetryAfter } from './retry.js';
import { decodeText } from '../util/files.js';

export const kRangeRefused = 416;

/** Where the body of a response belongs in the file, and how long the whole file is. */
export type BodyPlan = {
  readonly offset_bytes: number;
  /** Undefined when the server does not send it, or sends the length of a compressed body. */
  readonly total_bytes: number | undefined;
  /** Undefined = as it is. */
  readonly coding: Coding | undefined;
};

/**
 * Whether the server refuses to send a rest since there is none: what we have is the whole file,
 * and is still the same one. Ref: RFC 9110 section 13.1.5: where If-Range does not hold, Range is
 * ignored and not refused.
 */
export function isWhole(response: HttpResponse, resumable: Resumable): boolean {
  const whole =
    response.status === kRangeRefused &&
    response.header('content-range') === `bytes */${resumable.offset_bytes}`;
  return whole && otherValidator(response, resumable) === undefined;
}

/**
 * @throws GrabberError when the body cannot be put anywhere; the partial file is then of no use
 * either
 */
export function bodyPlan(
  url: string,
  response: HttpResponse,
  resumable: Resumable | undefined,
): BodyPlan {
  const coding = readCoding(url, response);
  const length = contentLength(url, response);
  if (response.status === 206) return restPlan(url, response, resumable, coding, length);
  // A server that ignores Range, or whose file has changed since, sends the whole file with 200.
  return { offset_bytes: 0, total_bytes: coding === undefined ? length : undefined, coding };
}

function readCoding(url: string, response: HttpResponse): Coding | undefined {
  const name = (response.header('content-encoding') ?? 'identity').trim().toLowerCase();
  if (name === 'identity' || name === '') return undefined;
  const coding = kCodings.find((one) => one === name);
  if (coding !== undefined) return coding;
  throw new GrabberError(
    'HTTP_PROTOCOL',
    `fetch ${shownUrl(url)}: Content-Encoding is ${name}; allowed: identity, as requested, ` +
      `or ${kCodings.join(', ')}`,
  );
}

function restPlan(
  url: string,
  response: HttpResponse,
  resumable: Resumable | undefined,
  coding: Coding | undefined,
  length: number | undefined,
): BodyPlan {
  if (resumable === undefined) {
    throw new GrabberError(
      'HTTP_PROTOCOL',
      `fetch ${shownUrl(url)}: HTTP 206 without a Range request; allowed: 200`,
    );
  }
  const range = response.header('content-range') ?? '';
  const match = /^bytes (\d{1,15})-(\d{1,15})\/(\d{1,15}|\*)$/.exec(range);
  const total = match?.[3] === undefined || match[3] === '*' ? undefined : Number(match[3]);
  const fits =
    match !== null &&
    coding === undefined &&
    Number(match[1]) === resumable.offset_bytes &&
    (total === undefined || resumable.total_bytes === null || total === resumable.total_bytes);
  if (!fits) {
    throw new GrabberError(
      'RESUME_REFUSED',
      `continue ${shownUrl(url)}: Content-Range is ` +
        `"${range}"${coding === undefined ? '' : `, ${coding}`}; allowed: bytes ` +
        `${resumable.offset_bytes}-.../${resumable.total_bytes ?? '*'}; the next try starts ` +
        'anew',
      { retryable: true },
    );
  }
  checkSameFile(url, response, resumable);
  const rest = length === undefined ? undefined : resumable.offset_bytes + length;
  return {
    offset_bytes: resumable.offset_bytes,
    total_bytes: total ?? resumable.total_bytes ?? rest,
    coding: undefined,
  };
}

/** Checks the validators again: some servers ignore If-Range and send the rest of another file. */
function checkSameFile(url: string, response: HttpResponse, resumable: Resumable): void {
  const other = otherValidator(response, resumable);
  if (other === undefined) return;
  throw new GrabberError(
    'RESUME_REFUSED',
    `continue ${shownUrl(url)} at byte ${resumable.offset_bytes}: ${other}; allowed: ` +
      `${resumable.if_range}, as before; the next try starts anew`,
    { retryable: true },
  );
}

/**
 * @return the validators or length that differ from those before; undefined when the file is the
 * same, or the server sends none of them
 */
function otherValidator(response: HttpResponse, { if_range }: Resumable): string | undefined {
  const name = if_range.startsWith('"') ? 'ETag' : 'Last-Modified';
  const found = response.header(name.toLowerCase());
  return found === undefined || found === if_range ? undefined : `${name} is ${found}`;
}

function contentLength(url: string, response: HttpResponse): number | undefined {
  const value = response.header('content-length');
  if (value === undefined) return undefined;
  if (!/^\d{1,15}$/.test(value)) {
    throw new GrabberError(
      'HTTP_PROTOCOL',
      `fetch ${shownUrl(url)}: Content-Length is "${value}"; allowed: a number of bytes`,
    );
  }
  return Number(value);
}

/** Request timeout, too early, too many requests: as temporary as a 5xx. */
const kTemporary = [408, 425, 429];
const kSniffBytes = 4096;
/** LAS and LAZ files, and ZIP archives. */
const kFileMagics = ['LASF', 'PK\u0003\u0004'];

export function statusError(
  url: string,
  response: HttpResponse,
  missingStatus: readonly number[],
  now: Date,
): GrabberError {
  const missing = missingStatus.length === 0 ? 'none' : missingStatus.join(', ');
  return new GrabberError(
    'HTTP_STATUS',
    `fetch ${shownUrl(url)}: HTTP ${response.status}; allowed: 200, or for "no such square": ` +
      missing,
    whenToRetry(response, now),
  );
}

/** Whether a refused request may succeed later, and when at the earliest. */
export function whenToRetry(
  response: HttpResponse,
  now: Date,
): { retryable: boolean; retryAfterMs: number | undefined } {
  const retryable = response.status >= 500 || kTemporary.includes(response.status);
  const retryAfterMs = retryable ? parseRetryAfter(response.header('retry-after'), now) : undefined;
  return { retryable, retryAfterMs };
}

/**
 * Portals send error pages, log-in pages and "file moved" pages with status 200. Worth another try:
 * most of them are gone once the portal works again.
 */
export function htmlError(
  url: string,
  response: HttpResponse,
  start: Uint8Array,
  redact: Redact,
): GrabberError | undefined {
  // A file with the right signature overrides a wrong Content-Type.
  const magic = Buffer.from(start.subarray(0, 4)).toString('latin1');
  if (kFileMagics.includes(magic)) return undefined;
  const text = decodeText([start.subarray(0, kSniffBytes)]).trimStart();
  const type = response.header('content-type') ?? '';
  const declared = /^\s*(text\/html|application\/xhtml\+xml)/i.test(type);
  if (!declared && !/^<(!doctype|html|head|body|\?xml)/i.test(text)) return undefined;
  const title = /<title[^>]*>([^<]{1,200})/i.exec(redact(text))?.[1];
  const shown =
    title === undefined ? 'an HTML or XML page' : `an HTML page titled "${title.trim()}"`;
  return new GrabberError(
    'HTML_BODY',
    `fetch ${shownUrl(url)}: HTTP 200 but the body is ${shown}; allowed: a LAS or LAZ file`,
    { retryable: true },
  );
}

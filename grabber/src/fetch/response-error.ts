import { GrabberError } from '../util/errors.js';
import type { HttpResponse } from './http-client.js';
import type { Redact } from './redact.js';
import { parseRetryAfter } from './retry.js';
import { shownUrl } from './shown-url.js';

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
  const { status } = response;
  const retryable = status >= 500 || kTemporary.includes(status);
  const retryAfterMs = retryable ? parseRetryAfter(response.header('retry-after'), now) : undefined;
  const missing = missingStatus.length === 0 ? 'none' : missingStatus.join(', ');
  return new GrabberError(
    'HTTP_STATUS',
    `fetch ${shownUrl(url)}: HTTP ${status}; allowed: 200, or for "no such square": ${missing}`,
    {
      retryable,
      ...(retryAfterMs === undefined ? {} : { retryAfterMs }),
    },
  );
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
  const text = Buffer.from(start.subarray(0, kSniffBytes))
    .toString('utf8')
    .replace(/^\uFEFF/, '')
    .trimStart();
  const type = response.header('content-type') ?? '';
  const declared = /^\s*(text\/html|application\/xhtml\+xml)/i.test(type);
  if (!declared && !/^<(!doctype|html|head|body|\?xml)/i.test(text)) return undefined;
  const title = /<title[^>]*>([^<]{1,200})/i.exec(redact(text))?.[1];
  const shown =
    title === undefined ? 'an HTML or XML page' : `an HTML page titled "${title.trim()}"`;
  return new GrabberError(
    'HTML_BODY',
    `fetch ${shownUrl(url)}: HTTP 200 but the body is ${shown}; allowed: a LAS or LAZ file`,
    {
      retryable: true,
    },
  );
}

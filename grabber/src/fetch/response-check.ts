import { GrabberError } from '../util/errors.js';
import type { HttpResponse } from './http-client.js';
import type { Resumable } from './partial.js';

export const kRangeRefused = 416;

/** Where the body of a response belongs in the file, and how long the whole file is. */
export type BodyPlan = {
  readonly offset_bytes: number;
  /** Undefined when the server does not tell. */
  readonly total_bytes: number | undefined;
};

/** @throws GrabberError when the body cannot be put anywhere; the partial file is then of no use either */
export function bodyPlan(url: string, response: HttpResponse, resumable: Resumable | undefined): BodyPlan {
  const encoding = response.header('content-encoding') ?? 'identity';
  if (encoding !== 'identity') {
    throw new GrabberError(
      'HTTP_PROTOCOL',
      `fetch ${url}: Content-Encoding is ${encoding}; allowed: identity, as asked for`,
    );
  }
  const length = contentLength(url, response);
  // A server that ignores Range, or whose file has changed since, sends the whole file with 200.
  if (response.status === 200) return { offset_bytes: 0, total_bytes: length };
  if (resumable === undefined) {
    throw new GrabberError('HTTP_PROTOCOL', `fetch ${url}: HTTP 206 without a Range request; allowed: 200`);
  }
  const range = response.header('content-range') ?? '';
  const match = /^bytes (\d+)-(\d+)\/(\d+|\*)$/.exec(range);
  const total = match?.[3] === undefined || match[3] === '*' ? undefined : Number(match[3]);
  const fits =
    match !== null &&
    Number(match[1]) === resumable.offset_bytes &&
    (total === undefined || resumable.total_bytes === null || total === resumable.total_bytes);
  if (!fits) {
    throw new GrabberError(
      'RESUME_REFUSED',
      `continue ${url}: Content-Range is "${range}"; allowed: bytes ${resumable.offset_bytes}-.../${resumable.total_bytes ?? '*'}; the next try starts anew`,
      { retryable: true },
    );
  }
  const rest = length === undefined ? undefined : resumable.offset_bytes + length;
  return { offset_bytes: resumable.offset_bytes, total_bytes: total ?? rest };
}

function contentLength(url: string, response: HttpResponse): number | undefined {
  const value = response.header('content-length');
  if (value === undefined) return undefined;
  if (!/^\d{1,15}$/.test(value)) {
    throw new GrabberError('HTTP_PROTOCOL', `fetch ${url}: Content-Length is "${value}"; allowed: a number of bytes`);
  }
  return Number(value);
}

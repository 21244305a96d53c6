/**
 * Failures of reading. Everything that reads from the network or decodes what came from it
 * throws a DataError and nothing else, except that a cancelled operation rejects with the reason of
 * its AbortSignal.
 */

/**
 * - `missing`: status 404, or a column of a level that the world does not have
 * - `refused`: status 401 or 403, or another 4xx that no retry can help
 * - `no-range`: the host ignores range requests
 * - `cors`: fetch failed without a reply: the network, or the host does not allow this page to read
 * - `range`: status 416, or a reply with another range than the requested one
 * - `cut`: the body ended early, or the file is shorter than it states
 * - `timeout`: no byte arrived for too long
 * - `changed`: the object is no longer the one of the first reply; what was read must not be mixed
 *   with what is read now
 * - `damaged`: a checksum differs, or bytes are not of the documented format
 * - `too-large`: more than a browser page should hold
 * - `server`: status 429 or 5xx
 */
export type DataErrorKind =
  | 'missing'
  | 'refused'
  | 'no-range'
  | 'cors'
  | 'range'
  | 'cut'
  | 'timeout'
  | 'changed'
  | 'damaged'
  | 'too-large'
  | 'server';

export type DataErrorOptions = {
  readonly cause?: unknown;
  /** Of a reply that was no success. */
  readonly status?: number;
  /** The shortest wait before another attempt that the host asks for, ms. */
  readonly retryAfterMs?: number;
};

export class DataError extends Error {
  readonly kind: DataErrorKind;
  readonly status: number | undefined;
  readonly retryAfterMs: number;

  /** @param message one line: what was attempted, the object, the value, what to do */
  constructor(kind: DataErrorKind, message: string, options: DataErrorOptions = {}) {
    super(message, options.cause === undefined ? undefined : { cause: options.cause });
    this.name = 'DataError';
    this.kind = kind;
    this.status = options.status;
    this.retryAfterMs = options.retryAfterMs ?? 0;
  }
}

/** An error as it is sent from the worker to the page. */
export type Failure = { readonly kind: DataErrorKind; readonly message: string };

export function toFailure(error: DataError): Failure {
  return { kind: error.kind, message: error.message };
}

/** @return the error itself, or, for what no code here throws on purpose, a wrapped one */
export function asDataError(error: unknown): DataError {
  if (error instanceof DataError) return error;
  const text = error instanceof Error ? `${error.name}: ${error.message}` : String(error);
  return new DataError('damaged', `internal error: ${oneLine(text)}; report it`, { cause: error });
}

/** An error of a part of `object`: what was attempted with it and its name come first. */
export function within(object: string, error: unknown): DataError {
  const { kind, message } = asDataError(error);
  return new DataError(kind, `${object}: ${message}`, { cause: error });
}

const kMaxQuoted = 300;

/** Text of unknown origin for a message: without control characters, at most 300 characters. */
export function oneLine(text: string): string {
  const start = text.slice(0, 4 * kMaxQuoted);
  const plain = start.replace(/[\p{Cc}\p{Cf}\p{Zl}\p{Zp}\s]+/gu, ' ').trim();
  return plain.length <= kMaxQuoted ? plain : `${plain.slice(0, kMaxQuoted)} …`;
}

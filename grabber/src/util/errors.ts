import { kHarmful } from './text.js';

/** What went wrong, for programs; the message is for people. */
export type ErrorCode = UserCode | HttpCode | FileCode | StoreCode | PictureCode;
type UserCode = 'USAGE' | 'CONFIG' | 'TEMPLATE' | 'SECRET' | 'CRS' | 'POLYGON_FILE' | 'FISHNET';
type HttpCode = RefusedCode | 'NETWORK' | 'HTTP_STATUS' | 'HTTP_PROTOCOL' | 'LENGTH' | 'TOO_SLOW';
type RefusedCode = 'HOST_REFUSED' | 'REDIRECT' | 'RESUME_REFUSED' | 'RETRY_AFTER_TOO_LONG';
type FileCode = LasCode | 'HTML_BODY' | 'TOO_LARGE' | 'CHECKSUM' | 'ARCHIVE' | 'LOCAL_FILE';
type LasCode = 'NOT_LAS' | 'LAS_HEADER' | 'LAS_TRUNCATED' | 'AMBIGUOUS_FILE' | ConverterCode;
type ConverterCode = 'COMMAND' | 'NO_CONVERTER' | 'CONVERTER';
type StoreCode = `STORE_${'CONFLICT' | 'LOCKED' | 'IO' | 'FORMAT' | 'DAMAGED'}` | 'DISK_FULL';
type PictureCode = 'CATALOGUE' | 'NOT_IMAGE' | 'MAP_SERVICE' | 'ORTHO';

export type GrabberErrorOptions = {
  readonly cause?: unknown;
  /** Whether the same attempt may succeed later without any change. */
  readonly retryable?: boolean | undefined;
  /** Wait that the server requested (Retry-After), in milliseconds. */
  readonly retryAfterMs?: number | undefined;
};

/** Message form: attempt, object, value, allowed range; always one line. */
export class GrabberError extends Error {
  readonly code: ErrorCode;
  readonly retryable: boolean;
  readonly retryAfterMs: number | undefined;

  constructor(code: ErrorCode, message: string, options: GrabberErrorOptions = {}) {
    super(oneLine(message), options.cause === undefined ? undefined : { cause: options.cause });
    this.name = 'GrabberError';
    this.code = code;
    this.retryable = options.retryable ?? false;
    this.retryAfterMs = options.retryAfterMs;
  }
}

/** In characters; what was read may be as long as a file, and readers of files quote it. */
const kMaxLineLength = 4000;

const kFolded = new RegExp(`[${kHarmful}]+`, 'gu');

/**
 * Folds line breaks, control characters and what reorders text, so that text from a server cannot
 * forge log lines, and leaves out the middle of what is longer than a line.
 */
export function oneLine(text: string): string {
  return bothEnds(text, kMaxLineLength).replace(kFolded, ' ').trim();
}

/**
 * A text, or the ends of one with more characters than `most`: what was attempted stands at the
 * beginning of a message, and why it failed often at the end.
 */
export function bothEnds(text: string, most: number): string {
  if (text.length <= most) return text;
  const end = Math.floor(most / 2);
  return `${text.slice(0, most - end - 1)}…${text.slice(-end)}`;
}

/**
 * The message of anything thrown, with the message of its cause, which often holds the real reason.
 */
export function describeError(error: unknown): string {
  if (!(error instanceof Error)) return oneLine(String(error));
  const cause = error.cause;
  const own = error.message === '' ? error.name : error.message;
  if (!(cause instanceof Error)) return oneLine(own);
  const reason = oneLine(cause.message);
  // Messages that quote their cause have it folded.
  return oneLine(own).includes(reason) ? oneLine(own) : oneLine(`${own}: ${reason}`);
}

/** The `code` of a Node.js system error such as ENOENT, or undefined. */
export function systemCode(error: unknown): string | undefined {
  if (error instanceof Error && 'code' in error && typeof error.code === 'string') {
    return error.code;
  }
  return undefined;
}

export function usage(message: string, cause?: unknown): GrabberError {
  return new GrabberError('USAGE', message, { cause });
}

/** An error for what was thrown while `attempt` was made; its message is part of the new one. */
export function causedError(
  code: ErrorCode,
  attempt: string,
  cause: unknown,
  allowed?: string,
): GrabberError {
  const end = allowed === undefined ? '' : `; allowed: ${allowed}`;
  return new GrabberError(code, `${attempt}: ${describeError(cause)}${end}`, { cause });
}

/** The code to record of an error that ends the work on one file, not the run. */
export function recordedCode(error: unknown): ErrorCode {
  return error instanceof GrabberError ? error.code : 'STORE_IO';
}

/** Any other error is a fault in this program, and must not be recorded as a bad file. */
export function isOfFile(error: unknown): boolean {
  return error instanceof GrabberError || systemCode(error) !== undefined;
}

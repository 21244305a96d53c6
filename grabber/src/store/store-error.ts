import { GrabberError, bothEnds, describeError, oneLine } from '../util/errors.js';

/** Longest text of an error that a record keeps; servers may say more. */
const kMaxMessageLength = 2000;

/** A message from anywhere, as one line that fits a record. */
export function recordedMessage(text: string): string {
  return bothEnds(oneLine(text), kMaxMessageLength);
}

/** SQLite's own errors carry codes such as SQLITE_FULL; everything else is passed on as it is. */
export function asStoreError(attempt: string, path: string, error: unknown): unknown {
  const code =
    error instanceof Error && 'code' in error && typeof error.code === 'string' ? error.code : '';
  if (!code.startsWith('SQLITE_')) return error;
  const why = `${attempt} ${path}: ${describeError(error)} (${code})`;
  // The statements are fixed, so a plain SQLITE_ERROR means a table or a column that is not there.
  if (code.startsWith('SQLITE_CORRUPT') || code === 'SQLITE_NOTADB' || code === 'SQLITE_ERROR') {
    return new GrabberError(
      'STORE_DAMAGED',
      `${why}; allowed: a sound GeoPackage that the grabber made`,
      { cause: error },
    );
  }
  return new GrabberError('STORE_IO', why, { cause: error });
}

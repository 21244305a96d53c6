import { GrabberError, bothEnds, describeError, oneLine, systemCode } from '../util/errors.js';
import { sqliteCode } from './sqlite.js';

/** Longest text of an error that a record keeps; servers may say more. */
const kMaxMessageLength = 2000;

/** A message from anywhere, as one line that fits a record. */
export function recordedMessage(text: string): string {
  return bothEnds(oneLine(text), kMaxMessageLength);
}

/** An error of SQLite as one of the store; everything else is passed on as it is. */
export function asStoreError(attempt: string, path: string, error: unknown): unknown {
  // Of a whole number that JavaScript cannot hold.
  const isTooLarge = systemCode(error) === 'ERR_OUT_OF_RANGE';
  const code = isTooLarge ? 'ERR_OUT_OF_RANGE' : sqliteCode(error);
  if (code === undefined) return error;
  const why = `${attempt} ${path}: ${describeError(error)} (${code})`;
  // The statements are fixed, so a plain SQLITE_ERROR means a table or a column that is not there.
  if (isTooLarge || ['SQLITE_CORRUPT', 'SQLITE_NOTADB', 'SQLITE_ERROR'].includes(code)) {
    return new GrabberError(
      'STORE_DAMAGED',
      `${why}; allowed: a sound GeoPackage that the grabber made`,
      { cause: error },
    );
  }
  return new GrabberError('STORE_IO', why, { cause: error });
}

import assert from 'node:assert/strict';
import { GrabberError, type ErrorCode } from '../../../grabber/src/util/errors.js';

/** Messages go to logs and records; an input must not make them as long as it is itself. */
const kMaxMessageLength = 5000;

/**
 * What a reader may do with any input: take it, or refuse it with one of the codes in its contract
 * and a message of one line. Anything else is a fault of the reader.
 * @return what it has read; undefined where it was refused
 */
export async function acceptedOrRefused<T>(
  codes: readonly ErrorCode[],
  read: () => T | Promise<T>,
): Promise<T | undefined> {
  try {
    return await read();
  } catch (error) {
    if (!(error instanceof GrabberError) || !codes.includes(error.code)) {
      throw new Error(`neither taken nor refused with ${codes.join(', ')}`, { cause: error });
    }
    assert.match(error.message, /^\P{Cc}+$/u, 'a message of one line');
    assert.ok(
      error.message.length <= kMaxMessageLength,
      `a message of ${error.message.length} characters`,
    );
    return undefined;
  }
}

import { GrabberError } from '../util/errors.js';

export function usage(message: string, cause?: unknown): GrabberError {
  return new GrabberError('USAGE', message, cause === undefined ? {} : { cause });
}

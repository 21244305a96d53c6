import { GrabberError } from '../util/errors.js';

/**
 * Reads the secret headers of a source from the environment, so that they stand in no file of the
 * project.
 * @param names header = name of an environment variable
 */
export function readSecretHeaders(
  names: Readonly<Record<string, string>>,
  environment: Readonly<Record<string, string | undefined>>,
): Record<string, string> {
  const headers: Record<string, string> = {};
  for (const [header, variable] of Object.entries(names)) {
    const value = environment[variable];
    if (value === undefined || value === '') {
      throw new GrabberError(
        'SECRET',
        `read header ${header}: environment variable ${variable} is not set; allowed: its secret`,
      );
    }
    // Never shown, not even in part.
    if (!/^[\x20-\x7e]{1,4096}$/.test(value)) {
      throw new GrabberError(
        'SECRET',
        `read header ${header}: environment variable ${variable} holds characters that no ` +
          'header may have; allowed: printable ASCII, at most 4096',
      );
    }
    headers[header.toLowerCase()] = value;
  }
  return headers;
}

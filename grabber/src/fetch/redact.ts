import { GrabberError, describeError } from '../util/errors.js';

/** Removes secrets from text for messages, logs or the store. */
export type Redact = (text: string) => string;

/** Shortest beginning of a secret that is hidden; shorter ones may be ordinary words. */
const kMinSecretPart = 8;

/**
 * Hides secrets in text that came from a server, which may send back what it was sent, whole or
 * cut.
 */
export function makeRedactor(secrets: readonly string[]): Redact {
  // "Bearer abc" may come back without its scheme.
  const whole = secrets.flatMap((secret) => [
    secret,
    ...secret.split(' ').filter((word) => word.length >= kMinSecretPart),
  ]);
  const words = new Set(
    whole.flatMap((word) => [word, encodeURIComponent(word), JSON.stringify(word).slice(1, -1)]),
  );
  words.delete('');
  return (text) => [...words].reduce(hide, text);
}

function hide(text: string, word: string): string {
  const start = word.slice(0, kMinSecretPart);
  let shown = '';
  let from = 0;
  for (let at = text.indexOf(start); at >= 0; at = text.indexOf(start, from)) {
    shown += `${text.slice(from, at)}***`;
    from = at + start.length;
    while (from - at < word.length && text[from] === word[from - at]) from += 1;
  }
  return shown + text.slice(from);
}

/** @return the same error when it shows no secret, else a redacted one without its cause */
export function redactError<T>(error: T, redact: Redact): T | GrabberError {
  if (!(error instanceof GrabberError)) return error;
  const text = describeError(error);
  const safe = redact(text);
  if (safe === text) return error;
  const { code, retryable, retryAfterMs } = error;
  return new GrabberError(code, safe, { retryable, retryAfterMs });
}

/** What `action` throws shows no secret. */
export async function withoutSecrets<T>(redact: Redact, action: () => Promise<T>): Promise<T> {
  try {
    return await action();
  } catch (error) {
    throw redactError(error, redact);
  }
}

/**
 * An address as it may stand in messages: without a password, and with its query hidden where the
 * query looks like a signature or key, which redirects to object stores carry.
 */
export function shownUrl(text: string): string {
  if (!URL.canParse(text)) return text.slice(0, 200);
  const url = new URL(text);
  if (url.username !== '' || url.password !== '') {
    url.username = '';
    url.password = '';
  }
  for (const name of [...url.searchParams.keys()]) {
    if (/sig|token|key|secret|credential|password|auth/i.test(name)) {
      url.searchParams.set(name, '...');
    }
  }
  return url.href;
}

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

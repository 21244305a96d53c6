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
  const { retryable, retryAfterMs } = error;
  return new GrabberError(error.code, safe, {
    retryable,
    ...(retryAfterMs === undefined ? {} : { retryAfterMs }),
  });
}

/** What `action` throws shows no secret. */
export async function withoutSecrets<T>(redact: Redact, action: () => Promise<T>): Promise<T> {
  try {
    return await action();
  } catch (error) {
    throw redactError(error, redact);
  }
}

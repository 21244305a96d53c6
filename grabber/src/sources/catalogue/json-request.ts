import type { z } from 'zod';
import { isListed } from '../../fetch/host-policy.js';
import type { HttpClient, HttpResponse } from '../../fetch/http-client.js';
import { withoutSecrets } from '../../fetch/redact.js';
import { parseRetryAfter, withRetries } from '../../fetch/retry.js';
import { GrabberError, describeError } from '../../util/errors.js';
import { catalogueError } from './listing.js';
import type { CatalogueSettings } from './options.js';

/** Who asks, and whom it may ask. */
export type Asker = {
  /** In messages, such as "list si-clss". */
  readonly what: string;
  readonly http: HttpClient;
  readonly hosts: readonly string[];
  readonly settings: CatalogueSettings;
};

const kTemporary = [408, 425, 429];

/** Asks for JSON, several times if need be. @throws GrabberError CATALOGUE */
export async function getJson<T>(asker: Asker, url: string, schema: z.ZodType<T>, signal: AbortSignal): Promise<T> {
  checkHost(asker, url);
  const { policy, clock, limits, onRetry } = asker.settings;
  const text = await withRetries(
    () => withoutSecrets(asker.http.redact, () => asCatalogueError(asker, async () => {
      const response = await asker.http.get(url, { accept: 'application/geo+json, application/json' }, signal);
      if (response.status !== 200) {
        await response.discard();
        throw statusError(asker, url, response);
      }
      return readText(asker, url, response, limits.reply_bytes);
    }, signal)),
    policy,
    clock,
    onRetry,
    signal,
  );
  return parseReply(asker, url, text, schema);
}

/** What the client throws says what broke; that a catalogue broke says what it means. */
async function asCatalogueError<T>(asker: Asker, action: () => Promise<T>, signal: AbortSignal): Promise<T> {
  try {
    return await action();
  } catch (error) {
    signal.throwIfAborted();
    if (!(error instanceof GrabberError) || error.code === 'CATALOGUE') throw error;
    throw new GrabberError('CATALOGUE', `${asker.what}: ${error.message}`, { cause: error, retryable: error.retryable });
  }
}

/** A catalogue may send its reader on, but only to hosts that its configuration names. */
export function checkHost(asker: Asker, url: string): void {
  if (URL.canParse(url) && /^https?:/i.test(url) && isListed(new URL(url), asker.hosts)) return;
  throw catalogueError(asker.what, `it leads to ${url}`, `the hosts ${asker.hosts.join(', ')} (hosts in the source's file)`);
}

function statusError(asker: Asker, url: string, response: HttpResponse): GrabberError {
  const retryable = response.status >= 500 || kTemporary.includes(response.status);
  const retryAfterMs = retryable ? parseRetryAfter(response.header('retry-after'), asker.settings.clock.now()) : undefined;
  return new GrabberError('CATALOGUE', `${asker.what}: ${url} answers HTTP ${response.status}; allowed: 200`, {
    retryable,
    ...(retryAfterMs === undefined ? {} : { retryAfterMs }),
  });
}

async function readText(asker: Asker, url: string, response: HttpResponse, most: number): Promise<string> {
  const chunks: Uint8Array[] = [];
  let bytes = 0;
  for await (const chunk of response.body) {
    bytes += chunk.length;
    if (bytes > most) throw catalogueError(asker.what, `${url} answers more than ${most} bytes`, `at most ${most}`);
    chunks.push(chunk);
  }
  return Buffer.concat(chunks).toString('utf8').replace(/^\uFEFF/, '');
}

function parseReply<T>(asker: Asker, url: string, text: string, schema: z.ZodType<T>): T {
  if (text.trimStart().startsWith('<')) {
    throw catalogueError(asker.what, `${url} answers ${shownMarkup(asker.http.redact(text))}`, 'JSON');
  }
  let raw: unknown;
  try {
    raw = JSON.parse(text);
  } catch (error) {
    throw catalogueError(asker.what, `${url} answers what is no JSON (${describeError(error)})`, 'JSON', error);
  }
  const result = schema.safeParse(raw);
  if (result.success) return result.data;
  const issue = result.error.issues[0];
  const where = issue?.path.map(String).join('.') ?? '';
  throw catalogueError(asker.what, `${url}: ${where || 'the reply'} has ${issue?.message ?? 'another form'}`, 'a reply of the documented form', result.error);
}

/** OWS services report errors as XML with status 200; log-in and error pages come as HTML. */
function shownMarkup(text: string): string {
  const exception = /<(?:\w+:)?(?:ExceptionText|ServiceException)[^>]*>([^<]{1,300})/i.exec(text)?.[1];
  if (exception !== undefined) return `the exception "${exception.trim()}"`;
  const title = /<title[^>]*>([^<]{1,200})/i.exec(text)?.[1];
  return title === undefined ? 'XML or HTML' : `a page titled "${title.trim()}"`;
}

import type { z } from 'zod';
import { isListed } from '../../fetch/host-policy.js';
import type { HttpClient, HttpResponse } from '../../fetch/http-client.js';
import { withoutSecrets } from '../../fetch/redact.js';
import { parseRetryAfter, withRetries } from '../../fetch/retry.js';
import { GrabberError, describeError } from '../../util/errors.js';
import { catalogueError } from './listing.js';
import type { CatalogueSettings } from './options.js';

/** What a request for JSON needs, and the hosts that it may contact. */
export type CatalogueClient = {
  /** In messages, such as "list si-clss". */
  readonly what: string;
  readonly http: HttpClient;
  readonly hosts: readonly string[];
  readonly settings: CatalogueSettings;
};

const kTemporary = [408, 425, 429];

/**
 * Requests JSON, with retries.
 * @throws GrabberError CATALOGUE
 */
export async function getJson<T>(
  client: CatalogueClient,
  url: string,
  schema: z.ZodType<T>,
  signal: AbortSignal,
): Promise<T> {
  checkHost(client, url);
  const { policy, clock, limits, onRetry } = client.settings;
  const text = await withRetries(
    () =>
      withoutSecrets(client.http.redact, () =>
        asCatalogueError(
          client,
          async () => {
            const response = await client.http.get(
              url,
              { accept: 'application/geo+json, application/json' },
              signal,
            );
            if (response.status !== 200) {
              await response.discard();
              throw statusError(client, url, response);
            }
            return readText(client, url, response, limits.reply_bytes);
          },
          signal,
        ),
      ),
    policy,
    clock,
    onRetry,
    signal,
  );
  return parseReply(client, url, text, schema);
}

/** Marks an error of the client as an error of the catalogue. */
async function asCatalogueError<T>(
  client: CatalogueClient,
  action: () => Promise<T>,
  signal: AbortSignal,
): Promise<T> {
  try {
    return await action();
  } catch (error) {
    signal.throwIfAborted();
    if (!(error instanceof GrabberError) || error.code === 'CATALOGUE') throw error;
    throw new GrabberError('CATALOGUE', `${client.what}: ${error.message}`, {
      cause: error,
      retryable: error.retryable,
    });
  }
}

/** A catalogue may send its reader on, but only to hosts that its configuration names. */
export function checkHost(client: CatalogueClient, url: string): void {
  if (URL.canParse(url) && /^https?:/i.test(url) && isListed(new URL(url), client.hosts)) return;
  throw catalogueError(
    client.what,
    `it leads to ${url}`,
    `the hosts ${client.hosts.join(', ')} (hosts in the source's file)`,
  );
}

function statusError(client: CatalogueClient, url: string, response: HttpResponse): GrabberError {
  const retryable = response.status >= 500 || kTemporary.includes(response.status);
  const retryAfterMs = retryable
    ? parseRetryAfter(response.header('retry-after'), client.settings.clock.now())
    : undefined;
  return new GrabberError(
    'CATALOGUE',
    `${client.what}: ${url} answers HTTP ${response.status}; allowed: 200`,
    {
      retryable,
      ...(retryAfterMs === undefined ? {} : { retryAfterMs }),
    },
  );
}

async function readText(
  client: CatalogueClient,
  url: string,
  response: HttpResponse,
  max: number,
): Promise<string> {
  const chunks: Uint8Array[] = [];
  let bytes = 0;
  for await (const chunk of response.body) {
    bytes += chunk.length;
    if (bytes > max) {
      throw catalogueError(client.what, `${url} answers more than ${max} bytes`, `at most ${max}`);
    }
    chunks.push(chunk);
  }
  return Buffer.concat(chunks)
    .toString('utf8')
    .replace(/^\uFEFF/, '');
}

function parseReply<T>(
  client: CatalogueClient,
  url: string,
  text: string,
  schema: z.ZodType<T>,
): T {
  if (text.trimStart().startsWith('<')) {
    throw catalogueError(
      client.what,
      `${url} answers ${shownMarkup(client.http.redact(text))}`,
      'JSON',
    );
  }
  let raw: unknown;
  try {
    raw = JSON.parse(text);
  } catch (error) {
    throw catalogueError(
      client.what,
      `${url} answers what is no JSON (${describeError(error)})`,
      'JSON',
      error,
    );
  }
  const result = schema.safeParse(raw);
  if (result.success) return result.data;
  const issue = result.error.issues[0];
  const where = issue?.path.map(String).join('.') ?? '';
  throw catalogueError(
    client.what,
    `${url}: ${where || 'the reply'} has ${issue?.message ?? 'another form'}`,
    'a reply of the documented form',
    result.error,
  );
}

/** OWS services report errors as XML with status 200; log-in and error pages come as HTML. */
function shownMarkup(text: string): string {
  const exception = /<(?:\w+:)?(?:ExceptionText|ServiceException)[^>]*>([^<]{1,300})/i.exec(
    text,
  )?.[1];
  if (exception !== undefined) return `the exception "${exception.trim()}"`;
  const title = /<title[^>]*>([^<]{1,200})/i.exec(text)?.[1];
  return title === undefined ? 'XML or HTML' : `a page titled "${title.trim()}"`;
}

import type { z } from 'zod';
import { isListed } from '../../fetch/host-policy.js';
import type { HttpClient, HttpResponse } from '../../fetch/http-client.js';
import { withoutSecrets } from '../../fetch/redact.js';
import { withRetries } from '../../fetch/retry.js';
import { GrabberError, describeError } from '../../util/errors.js';
import { catalogueError, type CatalogueSettings } from './listing.js';
import { decodeText } from '../../util/files.js';
import { whenToRetry } from '../../fetch/response-check.js';

/** What a request for JSON needs, and the hosts that it may contact. */
export type CatalogueClient = {
  /** In messages, such as "list si-clss". */
  readonly what: string;
  readonly http: HttpClient;
  readonly hosts: readonly string[];
  readonly settings: CatalogueSettings;
};

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
  const headers = { accept: 'application/geo+json, application/json' };
  const request = async (): Promise<string> => {
    const response = await client.http.get(url, headers, signal);
    if (response.status === 200) return readText(client, url, response, limits.reply_bytes);
    await response.discard();
    throw statusError(client, url, response);
  };
  const attempt = (): Promise<string> =>
    withoutSecrets(client.http.redact, () => asCatalogueError(client, request, signal));
  const text = await withRetries(attempt, policy, clock, onRetry, signal);
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
  return new GrabberError(
    'CATALOGUE',
    `${client.what}: ${url} answers HTTP ${response.status}; allowed: 200`,
    whenToRetry(response, client.settings.clock.now()),
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
  return decodeText(chunks);
}

function parseReply<T>(
  client: CatalogueClient,
  url: string,
  text: string,
  schema: z.ZodType<T>,
): T {
  if (text.trimStart().startsWith('<')) {
    const markup = shownMarkup(client.http.redact(text));
    throw catalogueError(client.what, `${url} answers ${markup}`, 'JSON');
  }
  let raw: unknown;
  try {
    raw = JSON.parse(text);
  } catch (error) {
    const found = `${url} answers what is no JSON (${describeError(error)})`;
    throw catalogueError(client.what, found, 'JSON', error);
  }
  const result = schema.safeParse(raw);
  if (result.success) return result.data;
  const found = `${url}: ${describeIssue(result.error, 'the reply')}`;
  throw catalogueError(client.what, found, 'a reply of the documented form', result.error);
}

/** @param whole what to call all of it, where the problem is not in a part */
export function describeIssue({ issues: [issue] }: z.ZodError, whole: string): string {
  const where = issue?.path.map(String).join('.') ?? '';
  return `${where || whole} has ${issue?.message ?? 'another form'}`;
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

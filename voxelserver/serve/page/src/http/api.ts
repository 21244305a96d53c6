import { isFields, toText } from '../json.js';
import { DataError } from './errors.js';
import { send, statusError, type Http, type Reply } from './http.js';

/** Requests to the voxel server that a page came from, or shows. */

export type Trouble = 'token' | 'busy' | 'missing' | 'refused' | 'gone';
export type TokenStore = Pick<Storage, 'getItem' | 'setItem' | 'removeItem'>;

/** Of the tab's storage: what the user typed on one page of the server is known to the others. */
export const kTokenKey = 'terravox-token';
const kNever = new AbortController().signal;
const kFactsTimeoutMs = 15_000;

export class Api {
  /** With a slash at the end: the server's root, also behind a proxy that adds a path. */
  readonly base: string;
  readonly #http: Http;
  readonly #store: TokenStore;

  /** @param base address of the server, or of a page in its root */
  constructor(base: string, http: Http, store: TokenStore) {
    this.base = new URL('.', base).href;
    this.#http = http;
    this.#store = store;
  }

  setToken(token: string): void {
    if (token === '') this.#store.removeItem(kTokenKey);
    else this.#store.setItem(kTokenKey, token);
  }

  /** @param path relative, such as "v2/world". @throws DataError unless the status is 2xx */
  get(path: string, timeoutMs?: number): Promise<Reply> {
    return this.#ask(path, {}, {}, timeoutMs);
  }

  /** @throws DataError unless the status is 2xx */
  send(method: 'POST' | 'DELETE', path: string, body?: string): Promise<Reply> {
    if (body === undefined) return this.#ask(path, {}, { method });
    return this.#ask(path, { 'Content-Type': 'application/json' }, { method, body });
  }

  async getJson(path: string): Promise<unknown> {
    const reply = await this.get(path, kFactsTimeoutMs);
    return reply.json(`${path}: the answer is no JSON.`);
  }

  async #ask(
    path: string,
    headers: Record<string, string>,
    init: RequestInit,
    timeoutMs = this.#http.timeoutMs,
  ): Promise<Reply> {
    const token = this.#store.getItem(kTokenKey);
    const all = token === null ? headers : { ...headers, Authorization: `Bearer ${token}` };
    const http = { ...this.#http, timeoutMs };
    let reply: Reply;
    try {
      const url = new URL(path, this.base).href;
      reply = await send(http, url, `fetch ${path}`, { ...init, headers: all }, kNever);
    } catch (error) {
      throw new DataError('timeout', 'The server does not answer.', { cause: error });
    }
    if (reply.response.ok) return reply;
    throw statusError(reply, http.environment.clock.now(), await describe(reply));
  }
}

/** What an error means for a user of the server. */
export function toTrouble(error: unknown): Trouble {
  if (!(error instanceof DataError)) return 'refused';
  const { kind, status } = error;
  if (status === 401 || status === 403) return 'token';
  if (kind === 'missing') return 'missing';
  // A proxy whose server is away answers 502 or 504.
  if (status === 502 || status === 504 || kind === 'timeout' || kind === 'cut') return 'gone';
  return status === 503 || status === 429 ? 'busy' : 'refused';
}

// application/problem+json, or whatever a proxy sends: then the status must do.
async function describe(reply: Reply): Promise<string> {
  const json = await reply.json('').catch(() => undefined);
  const parts = isFields(json) ? [toText(json['title']), toText(json['detail'])] : [];
  const text = parts.filter((part) => part !== '').join(': ');
  return text === '' ? `The server answered with status ${reply.status}.` : text.slice(0, 500);
}

export const toMessage = (error: unknown): string =>
  error instanceof Error ? error.message : String(error);

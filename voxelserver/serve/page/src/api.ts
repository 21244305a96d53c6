import { isFields, toText } from './json.js';

/** Client of the server that the page came from: every request of the page goes through here. */

export type Trouble = 'token' | 'busy' | 'missing' | 'refused' | 'gone';

export class ApiError extends Error {
  readonly trouble: Trouble;
  constructor(trouble: Trouble, message: string, cause?: unknown) {
    super(message, cause === undefined ? undefined : { cause });
    this.name = 'ApiError';
    this.trouble = trouble;
  }
}

export type Fetch = (url: string, init: RequestInit) => Promise<Response>;
/** Of the tab's storage: what the user typed on one page of the server is known to the others. */
export const kTokenKey = 'terravox-token';

export class Api {
  /** Where the page lies, with a slash at the end: the server's root, also behind a proxy that adds a path. */
  readonly base: string;
  readonly #fetch: Fetch;
  readonly #store: Pick<Storage, 'getItem' | 'setItem' | 'removeItem'>;

  constructor(
    base: string,
    fetch: Fetch,
    store: Pick<Storage, 'getItem' | 'setItem' | 'removeItem'>,
  ) {
    this.base = new URL('.', base).href;
    this.#fetch = fetch;
    this.#store = store;
  }

  setToken(token: string): void {
    if (token === '') this.#store.removeItem(kTokenKey);
    else this.#store.setItem(kTokenKey, token);
  }

  /** @param path relative, such as "v2/world". @throws ApiError unless the status is 2xx */
  async get(
    path: string,
    options: { readonly timeoutMs?: number; readonly range?: string } = {},
  ): Promise<Response> {
    return this.#ask(path, options.range === undefined ? {} : { Range: options.range }, {
      signal: AbortSignal.timeout(options.timeoutMs ?? 30_000),
    });
  }

  /** @throws ApiError unless the status is 2xx */
  async send(method: 'POST' | 'DELETE', path: string, body?: string): Promise<Response> {
    const signal = AbortSignal.timeout(30_000);
    if (body === undefined) return this.#ask(path, {}, { method, signal });
    return this.#ask(path, { 'Content-Type': 'application/json' }, { method, body, signal });
  }

  async getJson(path: string): Promise<unknown> {
    const reply = await this.get(path, { timeoutMs: 10_000 });
    try {
      return (await reply.json()) as unknown;
    } catch (error) {
      throw new ApiError('refused', `${path}: the answer is no JSON.`, error);
    }
  }

  async #ask(path: string, headers: Record<string, string>, init: RequestInit): Promise<Response> {
    const token = this.#store.getItem(kTokenKey);
    const all = token === null ? headers : { ...headers, Authorization: `Bearer ${token}` };
    let reply: Response;
    try {
      reply = await this.#fetch(new URL(path, this.base).href, { ...init, headers: all });
    } catch (error) {
      throw new ApiError('gone', 'The server does not answer.', error);
    }
    if (reply.ok) return reply;
    throw new ApiError(toTrouble(reply.status), await describe(reply));
  }
}

function toTrouble(status: number): Trouble {
  if (status === 401 || status === 403) return 'token';
  if (status === 404) return 'missing';
  // A proxy whose server is away answers 502 or 504.
  if (status === 502 || status === 504) return 'gone';
  return status === 503 || status === 429 ? 'busy' : 'refused';
}

// application/problem+json, or whatever a proxy sends: then the status must do.
async function describe(reply: Response): Promise<string> {
  try {
    const json = (await reply.json()) as unknown;
    if (isFields(json)) {
      const text = [toText(json['title']), toText(json['detail'])]
        .filter((part) => part !== '')
        .join(': ');
      if (text !== '') return text.slice(0, 500);
    }
  } catch {
    // No JSON.
  }
  return `The server answered with status ${reply.status}.`;
}

export const toMessage = (error: unknown): string =>
  error instanceof Error ? error.message : String(error);

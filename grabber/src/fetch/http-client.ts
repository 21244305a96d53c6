import { Agent, request } from 'undici';
import { GrabberError, describeError } from '../util/errors.js';

export type HttpResponse = {
  readonly status: number;
  /** First value of a header; `name` in lower case. */
  header(name: string): string | undefined;
  /** @throws GrabberError NETWORK while reading */
  readonly body: AsyncIterable<Uint8Array>;
  /** Drops the body without reading all of it. */
  discard(): Promise<void>;
};

/** What the downloads need of HTTP; tests may put their own in its place. */
export type HttpClient = {
  /** Follows redirects. @throws GrabberError NETWORK or REDIRECT, or the signal's reason */
  get(url: string, headers: Readonly<Record<string, string>>, signal: AbortSignal): Promise<HttpResponse>;
  close(): Promise<void>;
};

export type HttpClientOptions = {
  readonly userAgent: string;
  /** Longest wait for a connection, for the headers, and between two pieces of a body. */
  readonly timeout_ms: number;
};

const kMaxRedirects = 5;
const kRedirects = [301, 302, 303, 307, 308];

export function createHttpClient(options: HttpClientOptions): HttpClient {
  const agent = new Agent({
    connect: { timeout: options.timeout_ms },
    headersTimeout: options.timeout_ms,
    bodyTimeout: options.timeout_ms,
  });

  async function getOnce(
    url: string,
    headers: Readonly<Record<string, string>>,
    signal: AbortSignal,
  ): Promise<HttpResponse> {
    try {
      const response = await request(url, {
        dispatcher: agent,
        signal,
        headers: { 'user-agent': options.userAgent, ...headers },
      });
      return {
        status: response.statusCode,
        header: (name) => {
          const value = response.headers[name];
          return Array.isArray(value) ? value[0] : value;
        },
        body: namingErrors(response.body, url, signal),
        discard: () => response.body.dump(),
      };
    } catch (error) {
      throw networkError(url, error, signal);
    }
  }

  return {
    async get(url, headers, signal) {
      let current = url;
      for (let hop = 0; hop <= kMaxRedirects; ++hop) {
        const response = await getOnce(current, headers, signal);
        if (!kRedirects.includes(response.status)) return response;
        await response.discard();
        current = redirectTarget(current, response);
      }
      throw new GrabberError(
        'REDIRECT',
        `fetch ${url}: more than ${kMaxRedirects} redirects, the last to ${current}; allowed: at most ${kMaxRedirects}`,
      );
    },
    close: () => agent.destroy(),
  };
}

function redirectTarget(from: string, response: HttpResponse): string {
  const location = response.header('location');
  const target = location !== undefined && URL.canParse(location, from) ? new URL(location, from) : undefined;
  if (target !== undefined && ['http:', 'https:'].includes(target.protocol)) return target.href;
  throw new GrabberError(
    'REDIRECT',
    `fetch ${from}: status ${response.status} leads to ${location ?? 'nowhere'}; allowed: http(s) addresses`,
  );
}

async function* namingErrors(
  body: AsyncIterable<unknown>,
  url: string,
  signal: AbortSignal,
): AsyncGenerator<Uint8Array> {
  try {
    for await (const chunk of body) yield chunk as Uint8Array;
  } catch (error) {
    throw networkError(url, error, signal);
  }
}

/** Everything the network throws may pass, so it is worth another try; a wish to stop is not an error of the network. */
function networkError(url: string, error: unknown, signal: AbortSignal): unknown {
  if (signal.aborted) return signal.reason;
  return new GrabberError('NETWORK', `fetch ${url}: ${describeError(error)}`, { cause: error, retryable: true });
}

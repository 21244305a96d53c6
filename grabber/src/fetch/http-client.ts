import { Agent, request, type Dispatcher } from 'undici';
import { kSystemClock, type Clock } from '../util/clock.js';
import { GrabberError, describeError } from '../util/errors.js';
import { checkUrl, policedConnector, type HostAccess, type Resolve } from './host-policy.js';
import { Pace } from './pace.js';
import { redactError, redactorOf, withoutSecrets, type Redact } from './redact.js';
import { shownUrl } from './shown-url.js';

export type HttpResponse = {
  readonly status: number;
  /** First value of a header; `name` in lower case. */
  header(name: string): string | undefined;
  /** @throws GrabberError NETWORK or TOO_SLOW while reading */
  readonly body: AsyncIterable<Uint8Array>;
  /** Drops the body without reading all of it, and without waiting for more of it than a moment. Never throws. */
  discard(): Promise<void>;
};

type Headers = Readonly<Record<string, string>>;

/** What catalogues and downloads need of HTTP; tests may put their own in its place. */
export type HttpClient = {
  /** Follows redirects. @throws GrabberError NETWORK, REDIRECT or HOST_REFUSED, or the signal's reason */
  get(url: string, headers: Headers, signal: AbortSignal): Promise<HttpResponse>;
  /** Hides the secrets in text; whoever cuts text of a server does this before. What the client throws shows none. */
  readonly redact: Redact;
  close(): Promise<void>;
};

export type Access = HostAccess & {
  /** Sent to `secretOrigins` only; never on a redirect to another than was asked first. Lower-case names. */
  readonly secretHeaders: Headers;
  /** Scheme, host and port of the addresses that the configuration gives, as URL.origin writes them. */
  readonly secretOrigins: readonly string[];
};

/** A client that speaks to the hosts of one source only. */
export type SourceClient = HttpClient & {
  /** As get, but the answer has no body. */
  head(url: string, headers: Headers, signal: AbortSignal): Promise<HttpResponse>;
  /** Replaces whom it may talk to: a selection knows the hosts of its source only after it was read. */
  permit(access: Access): void;
};

export type HttpClientOptions = {
  readonly userAgent: string;
  /** Longest wait for a connection, for the headers, and between two pieces of a body. */
  readonly timeout_ms: number;
  readonly access: Access;
  readonly resolve?: Resolve;
  /** Judges how fast bodies come; the system's when left out. */
  readonly clock?: Clock;
};

/** Nobody may be talked to, until permit() says otherwise. */
export const kNoAccess: Access = { hosts: [], privateOrigins: [], secretHeaders: {}, secretOrigins: [] };

const kMaxRedirects = 5;
const kRedirects = [301, 302, 303, 307, 308];
/** Servers close idle connections after 5 to 60 s; ours are given up a little earlier. */
const kKeepAlive_ms = 4000;
/** A short rest of a body is read, so that its connection can be used again. */
const kRest_bytes = 16 * 1024;
const kRest_ms = 1000;

export function createHttpClient(options: HttpClientOptions): SourceClient {
  let access = options.access;
  const clock = options.clock ?? kSystemClock;
  const redact: Redact = (text) => redactorOf(Object.values(access.secretHeaders))(text);
  const agent = new Agent({
    connect: policedConnector(() => access, options.timeout_ms, options.resolve),
    headersTimeout: options.timeout_ms,
    bodyTimeout: options.timeout_ms,
    keepAliveTimeout: kKeepAlive_ms,
    pipelining: 1,
  });

  async function askOnce(method: 'GET' | 'HEAD', url: URL, headers: Headers, signal: AbortSignal): Promise<HttpResponse> {
    try {
      const response = await request(url, {
        dispatcher: agent,
        method,
        signal,
        headers: { 'user-agent': options.userAgent, ...headers },
      });
      return {
        status: response.statusCode,
        header: (name) => {
          const value = response.headers[name];
          return Array.isArray(value) ? value[0] : value;
        },
        body: checkedBody(response.body, url.href, clock, redact, signal),
        discard: () => dropBody(response.body),
      };
    } catch (error) {
      throw networkError(url.href, error, signal);
    }
  }

  async function ask(method: 'GET' | 'HEAD', address: string, headers: Headers, signal: AbortSignal): Promise<HttpResponse> {
    signal.throwIfAborted();
    const first = checkUrl(address, access);
    let url = first;
    for (let hop = 0; hop <= kMaxRedirects; ++hop) {
      const trusted = url.origin === first.origin && access.secretOrigins.includes(url.origin);
      const secrets = trusted ? access.secretHeaders : {};
      checkSecretsTravelSafely(url, secrets, access);
      const response = await askOnce(method, url, { ...headers, ...secrets }, signal);
      if (!kRedirects.includes(response.status)) return response;
      await response.discard();
      url = redirectTarget(url, response, access);
    }
    throw new GrabberError(
      'REDIRECT',
      `fetch ${shownUrl(address)}: more than ${kMaxRedirects} redirects, the last to ${shownUrl(url.href)}; allowed: at most ${kMaxRedirects}`,
    );
  }

  return {
    get: (url, headers, signal) => withoutSecrets(redact, () => ask('GET', url, headers, signal)),
    head: (url, headers, signal) => withoutSecrets(redact, () => ask('HEAD', url, headers, signal)),
    permit: (next) => {
      access = next;
    },
    redact,
    close: () => agent.destroy(),
  };
}

function checkSecretsTravelSafely(url: URL, secrets: Headers, access: Access): void {
  const safe = url.protocol === 'https:' || access.privateOrigins.includes(url.origin);
  if (safe || Object.keys(secrets).length === 0) return;
  throw new GrabberError('SECRET', `send secret headers to ${url.host}: over ${url.protocol}; allowed: https:`);
}

function redirectTarget(from: URL, response: HttpResponse, access: Access): URL {
  const location = response.header('location');
  const refuse = (what: string): GrabberError =>
    new GrabberError('REDIRECT', `fetch ${shownUrl(from.href)}: status ${response.status} leads to ${what}`);
  if (location === undefined || !URL.canParse(location, from.href)) throw refuse('nowhere; allowed: http(s) addresses');
  // An absolute address is judged as it is written, since a parsed one hides its disguise.
  const text = URL.canParse(location) ? location : new URL(location, from.href).href;
  const target = checkUrl(text, access);
  if (from.protocol === 'https:' && target.protocol === 'http:') {
    throw refuse(`${shownUrl(target.href)}, without encryption; allowed: https:`);
  }
  return target;
}

type RawBody = Dispatcher.ResponseData['body'];

async function dropBody(body: RawBody): Promise<void> {
  // AbortSignal.timeout would outlive this by its whole time; thousands of holes a second would pile up.
  const stop = new AbortController();
  const timer = setTimeout(() => stop.abort(), kRest_ms);
  try {
    await body.dump({ limit: kRest_bytes, signal: stop.signal });
  } catch {
    // What breaks here is of use to nobody any more.
  } finally {
    clearTimeout(timer);
  }
}

/** Names the address in what the network throws, and gives up on a body that trickles. */
async function* checkedBody(body: RawBody, url: string, clock: Clock, redact: Redact, signal: AbortSignal): AsyncGenerator<Uint8Array> {
  const pace = new Pace(clock, shownUrl(url));
  try {
    for await (const chunk of body as AsyncIterable<Uint8Array>) {
      pace.check(chunk.length);
      yield chunk;
    }
  } catch (error) {
    throw redactError(networkError(url, error, signal), redact);
  }
}

/** Everything the network throws may pass, so it is worth another try; a wish to stop is not an error of the network. */
function networkError(url: string, error: unknown, signal: AbortSignal): unknown {
  if (signal.aborted) return signal.reason;
  const refused = error instanceof GrabberError ? error : error instanceof Error ? error.cause : undefined;
  if (refused instanceof GrabberError) return refused;
  return new GrabberError('NETWORK', `fetch ${shownUrl(url)}: ${describeError(error)}`, { cause: error, retryable: true });
}

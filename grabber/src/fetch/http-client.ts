import { Agent, request, type Dispatcher } from 'undici';
import { kSystemClock, type Clock } from '../util/clock.js';
import { GrabberError, describeError } from '../util/errors.js';
import { checkUrl, policedConnector, type HostAccess, type Resolve } from './host-policy.js';
import { redactError, makeRedactor, withoutSecrets, type Redact, shownUrl } from './redact.js';

export type HttpResponse = {
  readonly status: number;
  /** First value of a header; `name` in lower case. */
  header(name: string): string | undefined;
  /** @throws GrabberError NETWORK or TOO_SLOW while reading */
  readonly body: AsyncIterable<Uint8Array>;
  /**
   * Drops the body without reading all of it, and without waiting for more of it than a moment.
   * Never throws.
   */
  discard(): Promise<void>;
};

type Headers = Readonly<Record<string, string>>;
type Method = 'GET' | 'HEAD';

/** What catalogues and downloads need of HTTP; tests may put their own in its place. */
export type HttpClient = {
  /**
   * Follows redirects.
   * @throws GrabberError NETWORK, REDIRECT or HOST_REFUSED, or the signal's reason
   */
  get(url: string, headers: Headers, signal: AbortSignal): Promise<HttpResponse>;
  /**
   * Hides the secrets in text. Text of a server is redacted before it is cut. Errors that the
   * client throws show no secret.
   */
  readonly redact: Redact;
  close(): Promise<void>;
};

export type Access = HostAccess & {
  /**
   * Headers that are sent to `secretOrigins` only, and never on a redirect to another origin. Names
   * are in lower case.
   */
  readonly secretHeaders: Headers;
  /**
   * Scheme, host and port of the addresses that the configuration gives, as URL.origin writes them.
   */
  readonly secretOrigins: readonly string[];
};

/** A client that contacts the hosts of one source only. */
export type SourceClient = HttpClient & {
  /** As get, but the answer has no body. */
  head(url: string, headers: Headers, signal: AbortSignal): Promise<HttpResponse>;
  /** Replaces the permitted hosts, which are known only after the source was read. */
  permit(access: Access): void;
};

export type HttpClientOptions = {
  readonly userAgent: string;
  /** Longest wait for a connection, for the headers, and between two pieces of a body. */
  readonly timeout_ms: number;
  readonly access: Access;
  readonly resolve?: Resolve;
  /** Clock for the minimum rate of bodies; the system's when left out. */
  readonly clock?: Clock;
};

/** Permits no host, until permit() is called. */
export const kNoAccess: Access = {
  hosts: [],
  privateOrigins: [],
  secretHeaders: {},
  secretOrigins: [],
};

const kMaxRedirects = 5;
const kRedirects = [301, 302, 303, 307, 308];
/** Servers close idle connections after 5 to 60 s; the client closes them a little earlier. */
const kKeepAlive_ms = 4000;
/** A short rest of a body is read, so that its connection can be used again. */
const kRest_bytes = 16 * 1024;
const kRest_ms = 1000;

export function createHttpClient(options: HttpClientOptions): SourceClient {
  return new UndiciClient(options);
}

class UndiciClient implements SourceClient {
  readonly #options: HttpClientOptions;
  readonly #clock: Clock;
  readonly #agent: Agent;
  #access: Access;

  constructor(options: HttpClientOptions) {
    this.#options = options;
    this.#clock = options.clock ?? kSystemClock;
    this.#access = options.access;
    this.#agent = new Agent({
      connect: policedConnector(() => this.#access, options.timeout_ms, options.resolve),
      headersTimeout: options.timeout_ms,
      bodyTimeout: options.timeout_ms,
      keepAliveTimeout: kKeepAlive_ms,
      pipelining: 1,
    });
  }

  readonly redact: Redact = (text) => makeRedactor(Object.values(this.#access.secretHeaders))(text);

  get(url: string, headers: Headers, signal: AbortSignal): Promise<HttpResponse> {
    return withoutSecrets(this.redact, () => this.#follow('GET', url, headers, signal));
  }

  head(url: string, headers: Headers, signal: AbortSignal): Promise<HttpResponse> {
    return withoutSecrets(this.redact, () => this.#follow('HEAD', url, headers, signal));
  }

  permit(access: Access): void {
    this.#access = access;
  }

  close(): Promise<void> {
    return this.#agent.destroy();
  }

  /** Sends a request and follows its redirects. */
  async #follow(
    method: Method,
    address: string,
    headers: Headers,
    signal: AbortSignal,
  ): Promise<HttpResponse> {
    signal.throwIfAborted();
    const access = this.#access;
    const first = checkUrl(address, access);
    let url = first;
    for (let hop = 0; hop <= kMaxRedirects; ++hop) {
      const trusted = url.origin === first.origin && access.secretOrigins.includes(url.origin);
      const secrets = trusted ? access.secretHeaders : {};
      checkSecretsTravelSafely(url, secrets, access);
      const response = await this.#send(method, url, { ...headers, ...secrets }, signal);
      if (!kRedirects.includes(response.status)) return response;
      await response.discard();
      url = redirectTarget(url, response, access);
    }
    throw new GrabberError(
      'REDIRECT',
      `fetch ${shownUrl(address)}: more than ${kMaxRedirects} redirects, the last to ` +
        `${shownUrl(url.href)}; allowed: at most ${kMaxRedirects}`,
    );
  }

  async #send(
    method: Method,
    url: URL,
    headers: Headers,
    signal: AbortSignal,
  ): Promise<HttpResponse> {
    try {
      const response = await request(url, {
        dispatcher: this.#agent,
        method,
        signal,
        headers: { 'user-agent': this.#options.userAgent, ...headers },
      });
      return {
        status: response.statusCode,
        header: (name) => {
          const value = response.headers[name];
          return Array.isArray(value) ? value[0] : value;
        },
        body: checkedBody(response.body, url.href, this.#clock, this.redact, signal),
        discard: () => dropBody(response.body),
      };
    } catch (error) {
      throw networkError(url.href, error, signal);
    }
  }
}

function checkSecretsTravelSafely(url: URL, secrets: Headers, access: Access): void {
  const safe = url.protocol === 'https:' || access.privateOrigins.includes(url.origin);
  if (safe || Object.keys(secrets).length === 0) return;
  throw new GrabberError(
    'SECRET',
    `send secret headers to ${url.host}: over ${url.protocol}; allowed: https:`,
  );
}

function redirectTarget(from: URL, response: HttpResponse, access: Access): URL {
  const location = response.header('location');
  const refuse = (what: string): GrabberError =>
    new GrabberError(
      'REDIRECT',
      `fetch ${shownUrl(from.href)}: status ${response.status} leads to ${what}`,
    );
  if (location === undefined || !URL.canParse(location, from.href)) {
    throw refuse('nowhere; allowed: http(s) addresses');
  }
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
  // AbortSignal.timeout would outlive this by its whole time; thousands of holes a second would
  // pile up.
  const stop = new AbortController();
  const timer = setTimeout(() => stop.abort(), kRest_ms);
  try {
    await body.dump({ limit: kRest_bytes, signal: stop.signal });
  } catch {
    // An error in a body that is dropped does not matter.
  } finally {
    clearTimeout(timer);
  }
}

/** Adds the address to errors of the network, and gives up on a body that is too slow. */
async function* checkedBody(
  body: RawBody,
  url: string,
  clock: Clock,
  redact: Redact,
  signal: AbortSignal,
): AsyncGenerator<Uint8Array> {
  const detector = new StallDetector(clock, shownUrl(url));
  try {
    for await (const chunk of body as AsyncIterable<Uint8Array>) {
      detector.check(chunk.length);
      yield chunk;
    }
  } catch (error) {
    throw redactError(networkError(url, error, signal), redact);
  }
}

/**
 * Network errors are worth a retry; an abort is not a network error.
 * @return the error to throw
 */
function networkError(url: string, error: unknown, signal: AbortSignal): unknown {
  if (signal.aborted) return signal.reason;
  if (error instanceof GrabberError) return error;
  // The connector's refusal of an address arrives as the cause of undici's error.
  if (error instanceof Error && error.cause instanceof GrabberError) return error.cause;
  return new GrabberError('NETWORK', `fetch ${shownUrl(url)}: ${describeError(error)}`, {
    cause: error,
    retryable: true,
  });
}

/**
 * A body that trickles keeps every time-out of silence from firing, and its host's queue from
 * moving.
 */
export const kMinRate_bytes_per_s = 512;
export const kRateWindow_ms = 120_000;

/** Gives up on a body that comes too slowly over a whole window. */
export class StallDetector {
  readonly #clock: Clock;
  readonly #shown: string;
  #since_ms: number;
  #bytes = 0;

  constructor(clock: Clock, shown: string) {
    this.#clock = clock;
    this.#shown = shown;
    this.#since_ms = clock.now().getTime();
  }

  /**
   * @param bytes of the piece that has just come
   * @throws GrabberError TOO_SLOW
   */
  check(bytes: number): void {
    this.#bytes += bytes;
    const now_ms = this.#clock.now().getTime();
    const spent_ms = now_ms - this.#since_ms;
    if (spent_ms < kRateWindow_ms) return;
    const rate = (this.#bytes * 1000) / spent_ms;
    if (rate < kMinRate_bytes_per_s) {
      throw new GrabberError(
        'TOO_SLOW',
        `fetch ${this.#shown}: ${Math.round(rate)} bytes a second over ` +
          `${Math.round(spent_ms / 1000)} s; allowed: at least ${kMinRate_bytes_per_s}`,
        { retryable: true },
      );
    }
    this.#since_ms = now_ms;
    this.#bytes = 0;
  }
}

import { collect } from '../bytes.js';
import { browserEnvironment, type Environment } from './environment.js';
import { DataError, type DataErrorKind } from './errors.js';
import { retryAfterMs } from './retry.js';

/**
 * Single HTTP requests: sends them, watches that they make progress, and reads bodies into memory
 * of a size that is known before.
 */

/** Counts of all requests of a source, growing. */
export type TransferStats = { requests: number; bytes: number };

export type Http = {
  readonly environment: Environment;
  readonly stats: TransferStats;
  /** A request without a new byte for so long ends. */
  readonly timeoutMs: number;
};

/** Of a host of files. */
export const kTimeoutMs = 30_000;
/** A voxel server may have to read its data before the first box. */
export const kServerTimeoutMs = 120_000;

/** A reply whose headers have arrived. The caller must call cancel() or read the body. */
export class Reply {
  readonly response: Response;
  readonly name: string;
  readonly #http: Http;
  readonly #watch: StallWatch;

  constructor(response: Response, name: string, http: Http, watch: StallWatch) {
    this.response = response;
    this.name = name;
    this.#http = http;
    this.#watch = watch;
  }

  get status(): number {
    return this.response.status;
  }

  get headers(): Headers {
    return this.response.headers;
  }

  /** Ends the request without reading (the rest of) its body. */
  cancel(): void {
    this.#watch.close();
    this.#watch.abort();
    // The body of a reply that failed already rejects.
    this.response.body?.cancel().catch(() => undefined);
  }

  /** The chunks of the body. @throws DataError `cut`, `timeout`; the reason of the signal */
  async *chunks(): AsyncGenerator<Uint8Array, void, undefined> {
    const reader = this.response.body?.getReader();
    if (reader === undefined) {
      this.#watch.close();
      return;
    }
    try {
      for (;;) {
        const chunk = await this.#watch.race(reader.read());
        if (chunk.done) return;
        this.#watch.progress();
        this.#http.stats.bytes += chunk.value.length;
        yield chunk.value;
      }
    } catch (error) {
      throw this.#watch.toError(error, this.name, 'cut');
    } finally {
      this.#watch.close();
      this.#watch.abort();
      reader.cancel().catch(() => undefined);
    }
  }

  /**
   * Reads a body of exactly `length` bytes.
   * @throws DataError `cut` for a shorter body, `no-range` for a longer one, as chunks()
   */
  async exactly(length: number): Promise<Uint8Array> {
    const bytes = await collect(this.chunks(), length);
    if (bytes === undefined) {
      throw new DataError('no-range', `${this.name}: more than the ${length} bytes asked for`);
    }
    if (bytes.length < length) {
      const what = `the reply ended after ${bytes.length} of ${length} bytes; try again`;
      throw new DataError('cut', `${this.name}: ${what}`);
    }
    return bytes;
  }

  /** All of the body. @throws as chunks() */
  async bytes(): Promise<Uint8Array<ArrayBuffer>> {
    return (await collect(this.chunks(), Infinity))!;
  }

  /** @param fault what is said of what is no JSON @throws DataError `damaged`; as chunks() */
  async json(fault = `${this.name}: the reply is no JSON`): Promise<unknown> {
    const bytes = await this.bytes();
    try {
      return JSON.parse(new TextDecoder().decode(bytes)) as unknown;
    } catch (error) {
      throw new DataError('damaged', fault, { cause: error });
    }
  }
}

/**
 * Sends a request and waits for the headers of its reply.
 * @param name what is attempted, and the object: the start of messages
 * @throws DataError `cors`, `timeout`; the reason of `signal`
 */
export async function send(
  http: Http,
  url: string,
  name: string,
  init: RequestInit,
  signal: AbortSignal,
): Promise<Reply> {
  const watch = new StallWatch(http, signal);
  http.stats.requests += 1;
  try {
    const sent = http.environment.fetch(url, { ...init, signal: watch.signal });
    const response = await watch.race(sent);
    watch.progress();
    return new Reply(response, name, http, watch);
  } catch (error) {
    watch.close();
    throw watch.toError(error, name, 'cors');
  }
}

/** Ends a request that makes no progress for some time, or whose caller gives up. */
class StallWatch {
  readonly #controller = new AbortController();
  readonly #http: Http;
  readonly #outer: AbortSignal;
  readonly #onAbort = (): void => this.abort();
  #cancelTimer: () => void = () => undefined;
  #hasTimedOut = false;

  constructor(http: Http, outer: AbortSignal) {
    this.#http = http;
    this.#outer = outer;
    if (outer.aborted) this.abort();
    outer.addEventListener('abort', this.#onAbort);
    this.progress();
  }

  get signal(): AbortSignal {
    return this.#controller.signal;
  }

  abort(): void {
    this.#controller.abort();
  }

  /** To be called whenever bytes have arrived. */
  progress(): void {
    this.#cancelTimer();
    this.#cancelTimer = this.#http.environment.clock.after(this.#http.timeoutMs, () => {
      this.#hasTimedOut = true;
      this.abort();
    });
  }

  /** Stops watching. */
  close(): void {
    this.#cancelTimer();
    this.#outer.removeEventListener('abort', this.#onAbort);
  }

  /** Settles as `work` does, or rejects as soon as the request is aborted. */
  race<T>(work: Promise<T>): Promise<T> {
    return new Promise((resolve, reject) => {
      const onAbort = (): void => reject(new Error('aborted'));
      if (this.signal.aborted) onAbort();
      this.signal.addEventListener('abort', onAbort, { once: true });
      work.then(resolve, reject).finally(() => {
        this.signal.removeEventListener('abort', onAbort);
      });
    });
  }

  /** @param kind of an error of fetch or of a body that has no other reason */
  toError(error: unknown, name: string, kind: 'cors' | 'cut'): Error {
    if (error instanceof DataError) return error;
    if (this.#outer.aborted) return this.#outer.reason as Error;
    if (this.#hasTimedOut) {
      const seconds = Math.round(this.#http.timeoutMs / 1000);
      const what = `${name}: nothing arrived for ${seconds} s; check the network`;
      return new DataError('timeout', what, { cause: error });
    }
    const what =
      kind === 'cut'
        ? 'the connection was lost within the reply; try again'
        : 'no reply: the network failed, or the host does not allow this page to read it (CORS); ' +
          'check the network and Access-Control-Allow-Origin of the host';
    return new DataError(kind, `${name}: ${what}`, { cause: error });
  }
}

/**
 * The error of a reply that is no success. Cancels the reply.
 * @param text its message; by default it tells the status and what to do
 */
export function statusError(reply: Reply, nowMs: number, text?: string): DataError {
  reply.cancel();
  const { status, headers } = reply;
  const [kind, advice] = toKind(status);
  const options = { status, retryAfterMs: retryAfterMs(headers, nowMs) };
  return new DataError(kind, text ?? `${reply.name}: status ${status}; ${advice}`, options);
}

/** The client of a page, or of its worker. */
export function makeHttp(environment = browserEnvironment(), timeoutMs = kTimeoutMs): Http {
  return { environment, stats: { requests: 0, bytes: 0 }, timeoutMs };
}

function toKind(status: number): readonly [DataErrorKind, string] {
  if (status === 404 || status === 410) return ['missing', 'check the address'];
  if (status === 401 || status === 403) {
    return ['refused', 'the host does not let this page read it; check its access rules'];
  }
  if (status === 412) return ['changed', 'it was replaced while it was read; load the page again'];
  if (status === 416) return ['range', 'the file is shorter than that; load the page again'];
  if (status === 429 || status >= 500) {
    return ['server', 'the host is overloaded or broken; try again later'];
  }
  if (status >= 400) return ['refused', 'the host refuses this request; check the address'];
  return ['no-range', 'use a host that answers range requests with status 206'];
}

import { DataError } from '../../http/errors.js';
import {
  toCondition,
  parseContentRange,
  readFileState,
  isOtherVersion,
  type FileState,
} from './file-state.js';
import { send, statusError, type Http, type Reply } from '../../http/http.js';
import { withRetries } from '../../http/retry.js';

/**
 * One file on a web server, read by range requests. The first reply pins its version; a reply of
 * another version ends reading for good, as bytes of two versions must not be mixed.
 *
 * The condition (If-Match) goes to the page's own origin only: elsewhere it would take a preflight
 * request that few hosts permit. Each reply is compared with the first one in any case. Without a
 * condition replies may come from the browser's cache: then a reply of another version is requested
 * once more past the cache before it counts.
 */

const kOtherVersion = Symbol('other version');

export class UrlFile {
  readonly url: string;
  readonly #http: Http;
  readonly #declared: number | undefined;
  readonly #isOwnOrigin: boolean;
  #state: FileState | undefined;
  #size: number | undefined;
  #changed: DataError | undefined;

  /** @param bytes size of the file where it is known; undefined: the first reply states it */
  constructor(http: Http, url: string, bytes?: number) {
    this.url = url;
    this.#http = http;
    this.#declared = bytes;
    this.#size = bytes;
    this.#isOwnOrigin = new URL(url).origin === http.environment.origin;
  }

  /** In bytes; undefined before the first reply. */
  get size(): number | undefined {
    return this.#size;
  }

  /**
   * @param length at least 1
   * @return the bytes; fewer than `length` only where the file ends before
   * @throws DataError; the reason of `signal`
   */
  async read(offset: number, length: number, signal: AbortSignal): Promise<Uint8Array> {
    signal.throwIfAborted();
    if (this.#changed !== undefined) throw this.#changed;
    try {
      return await withRetries(this.#http.environment, signal, () =>
        this.#attempt(offset, length, signal),
      );
    } catch (error) {
      if (error instanceof DataError && error.kind === 'changed') this.#changed = error;
      throw error;
    }
  }

  async #attempt(offset: number, length: number, signal: AbortSignal): Promise<Uint8Array> {
    const isFirst = this.#state === undefined;
    const found = await this.#request(offset, length, isFirst ? 'no-store' : 'default', signal);
    if (found !== kOtherVersion) return found;
    // With a condition no cache is asked.
    if (this.#hasCondition()) throw this.#changedError('it is another version');
    const again = await this.#request(offset, length, 'reload', signal);
    if (again === kOtherVersion) throw this.#changedError('it is another version');
    return again;
  }

  async #request(
    offset: number,
    length: number,
    cache: RequestCache,
    signal: AbortSignal,
  ): Promise<Uint8Array | typeof kOtherVersion> {
    const last = offset + length - 1;
    const headers = { Range: `bytes=${offset}-${last}`, ...this.#condition() };
    const name = `fetch ${this.url}, bytes ${offset} to ${last}`;
    const reply = await send(this.#http, this.url, name, { headers, cache }, signal);
    switch (reply.status) {
      case 206:
        return this.#readPart(reply, offset, length);
      case 412:
        reply.cancel();
        throw this.#changedError('the host reports another version');
      case 416:
        return this.#notSatisfiable(reply);
      default:
        throw statusError(reply, this.#http.environment.clock.now());
    }
  }

  async #readPart(
    reply: Reply,
    offset: number,
    length: number,
  ): Promise<Uint8Array | typeof kOtherVersion> {
    const range = parseContentRange(reply.headers);
    const size = range?.size ?? this.#size;
    if (range === undefined || size === undefined) {
      reply.cancel();
      const what =
        'the reply has no Content-Range with a size that this page may read; a host of another ' +
        'origin must send Access-Control-Expose-Headers: Content-Range, ETag';
      throw new DataError('no-range', `${reply.name}: ${what}`);
    }
    const state = readFileState(reply.headers, range.size);
    if (this.#isOther(state)) {
      reply.cancel();
      return kOtherVersion;
    }
    const end = Math.min(offset + length, size);
    if (range.first !== offset || range.last !== end - 1) {
      reply.cancel();
      const got = `${range.first} to ${range.last} of ${size}`;
      throw new DataError('range', `${reply.name}: the reply has bytes ${got}; check the host`);
    }
    this.#pin(state, size);
    return reply.exactly(end - offset);
  }

  #notSatisfiable(reply: Reply): typeof kOtherVersion {
    const state = readFileState(reply.headers, parseContentRange(reply.headers)?.size);
    const isOther = this.#state !== undefined && this.#isOther(state);
    const error = statusError(reply, this.#http.environment.clock.now());
    if (isOther) return kOtherVersion;
    throw error;
  }

  #condition(): Record<string, string> {
    return this.#state !== undefined && this.#isOwnOrigin ? toCondition(this.#state) : {};
  }

  #hasCondition(): boolean {
    return Object.keys(this.#condition()).length > 0;
  }

  #isOther(state: FileState): boolean {
    return this.#state !== undefined && isOtherVersion(this.#state, state);
  }

  #pin(state: FileState, size: number): void {
    if (this.#declared !== undefined && this.#declared !== size) {
      throw this.#changedError(`it has ${size} bytes; the list of parts states ${this.#declared}`);
    }
    this.#state ??= state;
    this.#size ??= size;
  }

  #changedError(what: string): DataError {
    return new DataError(
      'changed',
      `read ${this.url}: ${what}: it was replaced; load the page again`,
    );
  }
}

import assert from 'node:assert/strict';
import { Archive } from '../../../voxelserver/serve/page/src/viewer/data/archive.js';
import { makeHttp, type Http } from '../../../voxelserver/serve/page/src/http/http.js';
import type { Environment, Fetch } from '../../../voxelserver/serve/page/src/http/environment.js';
import { RangeFile } from '../../../voxelserver/serve/page/src/viewer/data/range-file.js';

export const kOpen = new AbortController().signal;

/** A client that sends its requests there. */
export const toHttp = (fetch: Fetch): Http =>
  makeHttp({ fetch, clock: new FakeClock(), random: () => 0.5, origin: 'http://h' });

/** Time that passes only when nothing else happens: then the next timer is due. */
export class FakeClock {
  readonly waits: number[] = [];
  #now = 1_700_000_000_000;
  readonly #timers = new Set<{ at: number; run: () => void }>();

  now(): number {
    return this.#now;
  }

  after(ms: number, run: () => void): () => void {
    const timer = { at: this.#now + ms, run };
    this.#timers.add(timer);
    return () => this.#timers.delete(timer);
  }

  /** Lets time pass until the work is done. */
  async finish<T>(work: Promise<T>): Promise<T> {
    let isDone = false;
    const done = (): void => void (isDone = true);
    work.then(done, done);
    for (let idle = 0; !isDone; ++idle) {
      await new Promise((resolve) => setImmediate(resolve));
      if (idle > 20 && this.#runNext()) idle = 0;
      assert.ok(idle < 10_000, 'nothing happens any more');
    }
    return work;
  }

  #runNext(): boolean {
    const [next] = [...this.#timers].sort((a, b) => a.at - b.at);
    if (next === undefined) return false;
    this.#timers.delete(next);
    if (next.at > this.#now) this.waits.push(next.at - this.#now);
    this.#now = next.at;
    next.run();
    return true;
  }
}

export type Handler = (url: string, init: RequestInit) => Response | Promise<Response>;

export type Asked = { readonly url: string; readonly init: RequestInit };

/** Files on a web server, and switches for what may go wrong. */
export class FakeHost {
  readonly clock = new FakeClock();
  readonly files = new Map<string, Uint8Array>();
  readonly asked: Asked[] = [];
  etag: string | undefined = '"one"';
  /** Answers instead of the files, one after the other; undefined: as usual. */
  readonly next: (Handler | undefined)[] = [];
  handler: Handler = (url, init) => this.#answer(url, init);
  readonly environment: Environment = {
    clock: this.clock,
    random: () => 0.5,
    origin: 'http://host',
    fetch: (url, init) => this.#fetch(url, init),
  };
  readonly http = {
    environment: this.environment,
    stats: { requests: 0, bytes: 0 },
    timeoutMs: 30_000,
  };

  constructor(files: Readonly<Record<string, Uint8Array>> = {}) {
    for (const [url, bytes] of Object.entries(files)) this.files.set(url, bytes);
  }

  file(place: ConstructorParameters<typeof RangeFile>[1] = 'http://host/a'): RangeFile {
    return new RangeFile(this.http, place);
  }

  async open(url = 'http://host/a'): Promise<Archive> {
    return this.clock.finish(Archive.open(this.file(url), kOpen));
  }

  async #fetch(url: string, init: RequestInit): Promise<Response> {
    this.asked.push({ url, init });
    init.signal?.throwIfAborted();
    return (this.next.shift() ?? this.handler)(url, init);
  }

  #answer(url: string, init: RequestInit): Response {
    const bytes = this.files.get(url);
    if (bytes === undefined) return new Response('no', { status: 404 });
    const headers = new Headers(init.headers);
    if ((headers.get('If-Match') ?? this.etag) !== this.etag) {
      return new Response('', { status: 412 });
    }
    const own: Record<string, string> = this.etag === undefined ? {} : { ETag: this.etag };
    const [, from, to] = /bytes=(\d+)-(\d+)/.exec(headers.get('Range') ?? '') ?? [];
    if (Number(from) >= bytes.length) {
      return new Response('', {
        status: 416,
        headers: { ...own, 'Content-Range': `bytes */${bytes.length}` },
      });
    }
    const end = Math.min(Number(to) + 1, bytes.length);
    const range = `bytes ${from}-${end - 1}/${bytes.length}`;
    return new Response(bytes.slice(Number(from), end), {
      status: 206,
      headers: { ...own, 'Content-Range': range },
    });
  }
}

export const status =
  (code: number, headers: Record<string, string> = {}): Handler =>
  () =>
    new Response(code === 204 ? null : 'x', { status: code, headers });

/** A body that never ends, or fails; it has these bytes before. */
export function brokenBody(
  bytes: number,
  how: 'hangs' | 'fails' | 'ends',
): ReadableStream<Uint8Array> {
  return new ReadableStream<Uint8Array>({
    pull(controller) {
      if (bytes > 0) controller.enqueue(new Uint8Array(bytes));
      if (how === 'fails') controller.error(new TypeError('network'));
      if (how === 'ends') controller.close();
      return how === 'hangs' ? new Promise(() => undefined) : undefined;
    },
  });
}

export const makePart = (body: BodyInit, range: string, etag = '"one"'): Response =>
  new Response(body, { status: 206, headers: { 'Content-Range': range, ETag: etag } });

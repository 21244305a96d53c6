import { Archive } from './archive.js';
import { ArchiveSource } from './archive-source.js';
import {
  bytesOfColumn,
  nameOfColumn,
  type ColumnKey,
  type BoxSource,
  type Column,
} from './columns.js';
import type { Environment } from '../../http/environment.js';
import { asDataError, DataError, toFailure, oneLine } from '../../http/errors.js';
import { kServerTimeoutMs, makeHttp, type Http } from '../../http/http.js';
import {
  kMaxUntakenBytes,
  kMaxWanted,
  type FromWorker,
  type Place,
  type ToWorker,
} from './protocol.js';
import { RangeFile } from './range-file.js';
import { Scheduler } from './scheduler.js';
import { ServerSource } from './server-source.js';

/**
 * Batches of a voxel server at once: each may take minutes, and browsers have six connections to a
 * host, one of which the page needs to ask how far the server is.
 */
const kMaxBatches = 4;

/** Sends a message to the page. @param transfer buffers that the page owns from then on */
export type Post = (message: FromWorker, transfer: ArrayBuffer[]) => void;

/** Handles the messages of one page: opens a source and runs a scheduler over it. */
export class Session {
  readonly #post: Post;
  readonly #base: string;
  readonly #http: Http;
  readonly #stopped = new AbortController();
  #isOpen = false;
  #scheduler: Scheduler | undefined;
  /** The newest list, until the source is open. */
  #early: readonly ColumnKey[] = [];
  #untakenBytes = 0;
  /** Columns that were sent and not taken, in this order. */
  readonly #untaken: string[] = [];
  #onTaken: (() => void)[] = [];

  /** @param base what relative addresses are relative to */
  constructor(post: Post, environment: Environment, base: string) {
    this.#post = post;
    this.#base = base;
    this.#http = makeHttp(environment);
  }

  handle(message: ToWorker): void {
    switch (message.type) {
      case 'open':
        if (!this.#isOpen) void this.#open(message.place);
        this.#isOpen = true;
        return;
      case 'want':
        this.#want(message.columns);
        return;
      case 'taken':
        this.#take(message.bytes);
        return;
      case 'stats':
        this.#post({ type: 'stats', stats: { ...this.#http.stats } }, []);
        return;
    }
  }

  /** Cancels all requests; nothing is sent any more. */
  stop(): void {
    this.#stopped.abort();
    this.#scheduler?.stop();
  }

  async #open(place: Place): Promise<void> {
    try {
      const source = await this.#openSource(place, this.#stopped.signal);
      this.#stopped.signal.throwIfAborted();
      this.#post({ type: 'opened', facts: source.facts }, []);
      const events = {
        whenReady: () => this.#whenTaken(),
        onColumn: (column: Column) => this.#send(column),
        onFailed: (column: ColumnKey, error: DataError) => this.#sendFailure(column, error),
        onEnded: (error: DataError) => this.#end(error),
      };
      const most = 'server' in place ? kMaxBatches : undefined;
      this.#scheduler = new Scheduler(source, events, most);
      this.#scheduler.want(this.#early);
    } catch (error) {
      if (!this.#stopped.signal.aborted) this.#end(asDataError(error));
    }
  }

  async #openSource(place: Place, signal: AbortSignal): Promise<BoxSource> {
    if ('server' in place) {
      const http = { ...this.#http, timeoutMs: kServerTimeoutMs };
      const server = this.#address(place.server);
      return ServerSource.open(http, { ...place, server }, signal);
    }
    const where =
      'url' in place
        ? this.#address(place.url)
        : place.parts.map(({ url, bytes }) => ({ url: this.#address(url), bytes }));
    const archive = await Archive.open(new RangeFile(this.#http, where), signal);
    return new ArchiveSource(archive, this.#http.environment.clock);
  }

  /** @throws DataError for what is no http(s) address */
  #address(text: string): string {
    try {
      const url = new URL(text, this.#base);
      if (url.protocol === 'http:' || url.protocol === 'https:') return url.href;
    } catch {
      // Not an address at all.
    }
    throw new DataError('missing', `open ${oneLine(text)}: not an address of http or https`);
  }

  #want(columns: readonly ColumnKey[]): void {
    // A list may have been made before a column arrived at the page that is on its way there.
    const sent = new Set(this.#untaken);
    const wanted = columns.slice(0, kMaxWanted).filter((key) => !sent.has(nameOfColumn(key)));
    if (this.#scheduler === undefined) this.#early = wanted;
    else this.#scheduler.want(wanted);
  }

  #send(column: Column): void {
    const transfer: ArrayBuffer[] = [];
    const bytes = bytesOfColumn(column);
    for (const box of column.boxes) {
      if (typeof box === 'string') continue;
      transfer.push(box.cells.buffer, box.first.buffer);
      transfer.push(box.attributes.buffer, box.classes.buffer);
    }
    this.#untakenBytes += bytes;
    this.#untaken.push(nameOfColumn(column));
    this.#post({ type: 'column', column, bytes }, transfer);
  }

  async #whenTaken(): Promise<void> {
    while (this.#untakenBytes > kMaxUntakenBytes) {
      await new Promise<void>((resolve) => this.#onTaken.push(resolve));
    }
  }

  #take(bytes: number): void {
    this.#untakenBytes = Math.max(0, this.#untakenBytes - bytes);
    this.#untaken.shift();
    const waiting = this.#onTaken;
    this.#onTaken = [];
    for (const resume of waiting) resume();
  }

  #sendFailure(column: ColumnKey, error: DataError): void {
    this.#post({ type: 'failed', column, failure: toFailure(error) }, []);
  }

  #end(error: DataError): void {
    this.#post({ type: 'ended', failure: toFailure(error) }, []);
  }
}

import { nameOfBox, type BoxKey } from './box-arrays.js';
import { BatchStream, type BatchRecord } from './batch-stream.js';
import { readBoxFrame } from './box-frame.js';
import {
  ColumnBuilder,
  listKeys,
  type ColumnKey,
  type BoxSource,
  type ColumnBox,
  type ColumnResult,
} from './columns.js';
import { wait } from '../../http/environment.js';
import { asDataError, DataError, oneLine, within, type DataErrorKind } from '../../http/errors.js';
import { boxRange, columnHeight, hasLevel, isEmpty, readFacts, type Facts } from './facts.js';
import { send, statusError, type Http, type Reply } from '../../http/http.js';
import { waitBeforeRetry, withRetries } from '../../http/retry.js';
import type { Place } from './protocol.js';
import { Turns } from './turns.js';

/**
 * Columns of a voxel server (docs/formats/http.md): batches of boxes. The edition of the first
 * reply goes with every request, so that boxes of two states of the server's data are never mixed.
 */

/** Of the coarsest level that is requested; all of them are wanted for a whole picture. */
const kMaxCoarsestColumns = 4096;
/** The server may be making what was requested, or come back: no attempt is the last one. */
const kPatient: ReadonlySet<DataErrorKind> = new Set(['server', 'timeout', 'cors']);
/** A column has all boxes between the heights of the bounds; most of them may be air. */
const kMaxBatchBoxes = 32;
const kEdition = 'Terravox-Edition';

type LoadingColumn = { readonly builder: ColumnBuilder; missing: number };
/** The boxes that are still to come. */
type Pending = Map<string, { readonly key: BoxKey; readonly column: LoadingColumn }>;

/** Its address is absolute. */
type ServerPlace = Extract<Place, { readonly server: string }>;

export class ServerSource implements BoxSource {
  readonly facts: Facts;
  readonly #http: Http;
  readonly #base: URL;
  readonly #headers: Readonly<Record<string, string>>;
  readonly #edition: string | undefined;
  readonly #turns: Turns;

  private constructor(
    http: Http,
    base: URL,
    headers: Readonly<Record<string, string>>,
    edition: string | undefined,
    facts: Facts,
  ) {
    this.facts = facts;
    this.#http = http;
    this.#base = base;
    this.#headers = edition === undefined ? headers : { ...headers, [kEdition]: edition };
    this.#edition = edition;
    this.#turns = new Turns(http.environment.clock);
  }

  /**
   * @throws DataError; the reason of `signal`
   */
  static async open(http: Http, place: ServerPlace, signal: AbortSignal): Promise<ServerSource> {
    const base = new URL(place.server);
    if (!base.pathname.endsWith('/')) base.pathname += '/';
    const headers: Record<string, string> =
      place.token === undefined ? {} : { Authorization: `Bearer ${place.token}` };
    const url = new URL('v2/world', base).href;
    return withRetries(http.environment, signal, async () => {
      const reply = await send(http, url, `fetch ${url}`, { headers, cache: 'no-store' }, signal);
      if (reply.status !== 200) throw refusal(reply, http.environment.clock.now());
      const whole = { world: readFacts(await reply.bytes(), base.href), damage: 0 };
      const facts = place.coarsest === undefined ? whole : upTo(place.coarsest, whole);
      const edition = reply.headers.get(kEdition) ?? undefined;
      return new ServerSource(http, base, headers, edition, facts);
    });
  }

  prepare(): Promise<void> {
    return Promise.resolve();
  }

  companions(column: ColumnKey, candidates: readonly ColumnKey[]): readonly ColumnKey[] {
    if (!hasLevel(this.facts, column.level)) return [];
    let boxes = columnHeight(this.facts, column.level);
    const taken: ColumnKey[] = [];
    for (const candidate of candidates) {
      if (!hasLevel(this.facts, candidate.level)) continue;
      boxes += columnHeight(this.facts, candidate.level);
      if (boxes > kMaxBatchBoxes) break;
      taken.push(candidate);
    }
    return taken;
  }

  async *columns(
    columns: readonly ColumnKey[],
    signal: AbortSignal,
  ): AsyncGenerator<ColumnResult, void, undefined> {
    const pending: Pending = new Map();
    for (const key of columns) {
      const result = this.#begin(key, pending);
      if (result !== undefined) yield result;
    }
    let attempts = 0;
    while (pending.size > 0) {
      const before = pending.size;
      try {
        yield* this.#request(pending, signal);
      } catch (error) {
        signal.throwIfAborted();
        const failure = asDataError(error);
        if (failure.kind === 'changed') throw failure;
        attempts = pending.size < before ? 1 : attempts + 1;
        const counted = kPatient.has(failure.kind) ? Math.min(attempts, 2) : attempts;
        const waitMs = waitBeforeRetry(this.#http.environment, failure, counted);
        if (waitMs === undefined) {
          yield* failAll(pending, failure);
          return;
        }
        await wait(this.#http.environment.clock, waitMs, signal);
      }
    }
  }

  /** @return the column, where no box has to be requested for it */
  #begin(column: ColumnKey, pending: Pending): ColumnResult | undefined {
    let keys: BoxKey[];
    try {
      keys = listKeys(column, this.facts);
    } catch (error) {
      return { failed: column, error: asDataError(error) };
    }
    const loading = { builder: new ColumnBuilder(column), missing: keys.length };
    for (const key of keys) pending.set(nameOfBox(key), { key, column: loading });
    return keys.length === 0 ? { column: loading.builder.finish() } : undefined;
  }

  async *#request(
    pending: Pending,
    signal: AbortSignal,
  ): AsyncGenerator<ColumnResult, void, undefined> {
    const keys = [...pending.values()].map(({ key }) => [key.level, key.bx, key.by, key.bz]);
    const url = new URL('v2/boxes', this.#base).href;
    const reply = await send(
      this.#http,
      url,
      `fetch ${keys.length} boxes of ${this.#base.href}`,
      {
        method: 'POST',
        headers: { ...this.#headers, 'Content-Type': 'application/json' },
        body: JSON.stringify({ boxes: keys }),
      },
      signal,
    );
    if (reply.status !== 200) throw refusal(reply, this.#http.environment.clock.now());
    this.#checkEdition(reply);
    const stream = new BatchStream(keys.length);
    let busy: DataError | undefined;
    for await (const chunk of reply.chunks()) {
      for (const record of stream.feed(chunk)) {
        busy ??= busyError(record);
        const result = this.#take(record, pending);
        if (result !== undefined) yield result;
        await this.#turns.give(signal);
      }
    }
    stream.finish();
    if (busy !== undefined) throw busy;
  }

  #checkEdition(reply: Reply): void {
    const edition = reply.headers.get(kEdition);
    // A server may name its edition in no other reply than the first one: it compares, too.
    if (edition === null || this.#edition === undefined || edition === this.#edition) return;
    reply.cancel();
    const what = 'its data have changed; load the page again';
    throw new DataError('changed', `${reply.name}: ${what}`);
  }

  /** @return the column, where this was its last box, or why it fails */
  #take(record: BatchRecord, pending: Pending): ColumnResult | undefined {
    const name = nameOfBox(record.key);
    const found = pending.get(name);
    // Of a column that has failed, or one that was not requested: skipped. What a busy server
    // leaves out stays pending.
    if (found === undefined || busyError(record) !== undefined) return undefined;
    pending.delete(name);
    const { key, column } = found;
    try {
      column.builder.add(key.by, this.#toBox(record));
      column.missing -= 1;
      return column.missing > 0 ? undefined : { column: column.builder.finish() };
    } catch (error) {
      for (const [other, { column: its }] of pending) if (its === column) pending.delete(other);
      return { failed: column.builder.key, error: within(`read ${this.#base.href}`, error) };
    }
  }

  #toBox({ key, status, payload }: BatchRecord): ColumnBox {
    if (status === 200) return readBoxFrame(payload, key, this.#turns);
    if (status === 204) return 'air';
    if (status === 500) return 'hole';
    throw new DataError('damaged', `box ${nameOfBox(key)}: status ${status}; not one of a batch`);
  }
}

function busyError({ key, status, payload }: BatchRecord): DataError | undefined {
  if (status !== 502 && status !== 503) return undefined;
  const reason = oneLine(new TextDecoder().decode(payload));
  return new DataError('server', `box ${nameOfBox(key)}: status ${status}; ${reason}`);
}

// Another token than that of the first reply is required: nothing can be read any more.
function refusal(reply: Reply, nowMs: number): DataError {
  if (reply.status !== 401) return statusError(reply, nowMs);
  reply.cancel();
  const what = 'status 401; the server requires a token, or another one; load the page again';
  return new DataError('changed', `${reply.name}: ${what}`);
}

function upTo(coarsest: number, facts: Facts): Facts {
  const { world } = facts;
  const levels = Math.min(world.levels, coarsest + 1);
  if (isEmpty(world)) return facts;
  const { min, max } = boxRange(world, levels - 1);
  const columns = (max[0] - min[0]) * (max[2] - min[2]);
  if (columns > kMaxCoarsestColumns) {
    throw new DataError(
      'too-large',
      `open a voxel server up to level ${coarsest}: ${columns} columns of it; ` +
        `allowed: up to ${kMaxCoarsestColumns}`,
    );
  }
  return { ...facts, world: { ...world, levels } };
}

function* failAll(pending: Pending, error: DataError): Generator<ColumnResult, void, undefined> {
  const columns = new Set([...pending.values()].map(({ column }) => column));
  for (const { builder } of columns) yield { failed: builder.key, error };
}

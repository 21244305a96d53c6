import {
  nameOfColumn,
  type ColumnKey,
  type BoxSource,
  type Column,
  type ColumnResult,
} from './columns.js';
import { asDataError, type DataError } from '../../http/errors.js';

/**
 * Decides which columns are requested, in which order, and which requests are cancelled. Runs up to
 * six requests at once; each fetches the most wanted column that is not on its way yet, together
 * with others that lie close to it (BoxSource.companions). Knows no network and no clock.
 */

export type SchedulerEvents = {
  /** Resolves when a column may be delivered: until then each request waits with its next one. */
  readonly whenReady: () => Promise<void>;
  /** A column of the newest list. */
  readonly onColumn: (column: Column) => void;
  /**
   * A column of the newest list could not be read. It is requested again when a later list names
   * it.
   */
  readonly onFailed: (column: ColumnKey, error: DataError) => void;
  /** The data have changed: nothing is requested any more. */
  readonly onEnded: (error: DataError) => void;
};

export type SchedulerStats = { readonly waiting: number; readonly requests: number };

const kMaxRequests = 6;
/** How many wanted columns are considered as companions. */
const kLookAhead = 512;

/** One request at a time, for one or more columns. */
type Job = {
  readonly controller: AbortController;
  readonly columns: Map<string, ColumnKey>;
  /** Until the source is prepared for its column, another job may take that as a companion. */
  isPreparing: boolean;
};

export class Scheduler {
  readonly #source: BoxSource;
  readonly #events: SchedulerEvents;
  readonly #maxRequests: number;
  /** What the newest list wants and has not got yet, most wanted first. */
  #wanted = new Map<string, ColumnKey>();
  readonly #jobs = new Set<Job>();
  /** The columns of all jobs. */
  readonly #onTheWay = new Set<string>();
  #hasEnded = false;

  constructor(source: BoxSource, events: SchedulerEvents, maxRequests = kMaxRequests) {
    this.#source = source;
    this.#events = events;
    this.#maxRequests = maxRequests;
  }

  get stats(): SchedulerStats {
    return { waiting: this.#wanted.size, requests: this.#jobs.size };
  }

  /**
   * Replaces the list of wanted columns. Requests none of whose columns is wanted any more are
   * cancelled; columns that are on their way and still wanted are not requested again.
   * @param columns most wanted first
   */
  want(columns: readonly ColumnKey[]): void {
    if (this.#hasEnded) return;
    this.#wanted = new Map(columns.map((column) => [nameOfColumn(column), column]));
    for (const job of [...this.#jobs]) {
      // One whose column another has taken still loads a part of the index, which is shared.
      if (job.isPreparing && job.columns.size === 0) continue;
      if (![...job.columns.keys()].some((name) => this.#wanted.has(name))) this.#cancel(job);
    }
    this.#startJobs();
  }

  /** Cancels everything. */
  stop(): void {
    this.#hasEnded = true;
    this.#wanted.clear();
    for (const job of [...this.#jobs]) this.#cancel(job);
  }

  #startJobs(): void {
    // Each job takes the next free column, so one pass over the list is enough.
    for (const [name, column] of this.#wanted) {
      if (this.#jobs.size >= this.#maxRequests) return;
      if (!this.#onTheWay.has(name)) void this.#run(column);
    }
  }

  async #run(column: ColumnKey): Promise<void> {
    const controller = new AbortController();
    const job: Job = { controller, columns: new Map(), isPreparing: true };
    this.#jobs.add(job);
    this.#add(job, column);
    try {
      await this.#load(job, column);
    } catch (error) {
      // A cancelled job has been forgotten already.
      if (this.#jobs.has(job)) this.#fail(job, asDataError(error));
    }
    this.#forget(job);
    this.#startJobs();
  }

  async #load(job: Job, column: ColumnKey): Promise<void> {
    const { signal } = job.controller;
    await this.#source.prepare(column, this.#free(), signal);
    signal.throwIfAborted();
    job.isPreparing = false;
    // Another job was prepared earlier, and has taken the column.
    if (job.columns.size === 0) return;
    for (const companion of this.#source.companions(column, this.#free())) {
      this.#add(job, companion);
    }
    for await (const result of this.#source.columns([...job.columns.values()], signal)) {
      await this.#events.whenReady();
      signal.throwIfAborted();
      this.#deliver(job, result);
    }
    if (job.columns.size > 0) throw new Error('a source gave no result for a column');
  }

  /** The most wanted columns that are not requested yet. */
  #free(): ColumnKey[] {
    const free: ColumnKey[] = [];
    for (const [name, column] of this.#wanted) {
      if (free.length >= kLookAhead) break;
      if (!this.#onTheWay.has(name) || this.#preparing(name) !== undefined) free.push(column);
    }
    return free;
  }

  #preparing(name: string): Job | undefined {
    return [...this.#jobs].find((job) => job.isPreparing && job.columns.has(name));
  }

  #deliver(job: Job, result: ColumnResult): void {
    const name = nameOfColumn('column' in result ? result.column : result.failed);
    this.#remove(job, name);
    // Only what is still wanted: the list may have changed on the way.
    if (!this.#wanted.delete(name)) return;
    if ('column' in result) this.#events.onColumn(result.column);
    else this.#events.onFailed(result.failed, result.error);
  }

  #fail(job: Job, error: DataError): void {
    if (error.kind === 'changed') {
      this.stop();
      this.#events.onEnded(error);
      return;
    }
    for (const [name, column] of [...job.columns]) {
      this.#remove(job, name);
      if (this.#wanted.delete(name)) this.#events.onFailed(column, error);
    }
  }

  #cancel(job: Job): void {
    this.#forget(job);
    job.controller.abort();
  }

  #forget(job: Job): void {
    for (const name of [...job.columns.keys()]) this.#remove(job, name);
    this.#jobs.delete(job);
  }

  #add(job: Job, column: ColumnKey): void {
    const name = nameOfColumn(column);
    this.#preparing(name)?.columns.delete(name);
    job.columns.set(name, column);
    this.#onTheWay.add(name);
  }

  #remove(job: Job, name: string): void {
    // The column may be on its way in another job by now.
    if (job.columns.delete(name)) this.#onTheWay.delete(name);
  }
}

import type { ColumnKey, Column } from './columns.js';
import type { Failure } from '../../http/errors.js';
import type { TransferStats } from '../../http/http.js';
import type { Facts } from './facts.js';
import type { FilePart } from './range-file.js';

/**
 * Messages between the page and the worker that reads boxes. The page opens one world, then sends a
 * list of wanted columns whenever the view has changed. The worker sends each column of the newest
 * list once, as soon as it is there; the arrays of its boxes are transferred, not copied.
 */

/** What to open; addresses are absolute or relative to the worker's own. */
export type Place =
  | { readonly url: string }
  | { readonly parts: readonly FilePart[] }
  /** @param coarsest level that is requested; coarser ones would take too long */
  | { readonly server: string; readonly token?: string; readonly coarsest?: number };

/** Columns of one list; what exceeds this is ignored. */
export const kMaxWanted = 8192;

export type ToWorker =
  /** Must be the first message; another one is ignored. */
  | { readonly type: 'open'; readonly place: Place }
  /**
   * Replaces the list. Must not name columns that the page has. May be sent before `opened` comes.
   * @param columns most wanted first
   */
  | { readonly type: 'want'; readonly columns: readonly ColumnKey[] }
  /**
   * The page has taken the next column, of so many bytes (`bytes` of its message): each request of
   * the worker pauses while more than kMaxUntakenBytes have been sent and not taken, and columns
   * that are not taken are not sent once more.
   */
  | { readonly type: 'taken'; readonly bytes: number }
  /** Requests a `stats` message. */
  | { readonly type: 'stats' };

export type FromWorker =
  | { readonly type: 'opened'; readonly facts: Facts }
  /** @param bytes of memory that it takes */
  | {
      readonly type: 'column';
      readonly column: Column;
      readonly bytes: number;
    }
  /** One column could not be read. A later list may name it again, better not at once. */
  | {
      readonly type: 'failed';
      readonly column: ColumnKey;
      readonly failure: Failure;
    }
  /** The world could not be opened, or its data have changed. No further message but `stats`. */
  | { readonly type: 'ended'; readonly failure: Failure }
  | { readonly type: 'stats'; readonly stats: TransferStats };

export const kMaxUntakenBytes = 64 * 1024 * 1024;

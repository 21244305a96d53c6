import type { RetryNotice } from '../fetch/retry.js';
import type { RecordKey, StoredFile } from '../model/square.js';

/** How the work on one record ended. */
export type Outcome = { readonly key: RecordKey; readonly url: string | null } & (
  | {
      /**
       * fetched: whole, but not usable before a conversion, which has not been made. kept: was
       * there before the run.
       */
      readonly state: 'verified' | 'converted' | 'fetched' | 'kept';
      readonly file: StoredFile;
      readonly point_count: number | null;
      readonly warnings: readonly string[];
    }
  | { readonly state: 'missing'; readonly reason: string }
  | { readonly state: 'failed'; readonly code: string; readonly message: string }
);

export type OutcomeState = Outcome['state'];
export type Tally = Record<OutcomeState, number>;

/** What is known before the first request. */
export type Plan = {
  readonly files: number;
  readonly kept: number;
  readonly known_bytes: number;
  readonly unknown_sizes: number;
};

export type Summary = Tally & {
  readonly known_missing: number;
  readonly received_bytes: number;
  readonly seconds: number;
};

/**
 * Receives the progress of a run. Called often, so an implementation decides itself what it shows;
 * must not throw.
 */
export type FetchEvents = {
  plan(plan: Plan): void;
  begin(key: RecordKey, url: string): void;
  /** @param total_bytes undefined = not known */
  bytes(
    key: RecordKey,
    done_bytes: number,
    fresh_bytes: number,
    total_bytes: number | undefined,
  ): void;
  retry(key: RecordKey, notice: RetryNotice): void;
  outcome(outcome: Outcome): void;
};

import type PQueue from 'p-queue';
import type { StoreRecord } from '../model/square.js';
import type { Catalogue, RecordTable, Verified } from '../model/store.js';
import type { FetchEvents } from '../progress/events.js';
import type { Clock } from '../util/clock.js';
import type { DiskSpace } from './disk-space.js';
import type { HostQueues, HostLimits } from './host-queues.js';
import type { SourceClient } from './http-client.js';
import type { RetryPolicy } from './retry.js';

/** What was found in a whole file. */
export type Checked = {
  /** The extension that fits the content, without a dot, whatever the address says. */
  readonly extension: string;
  /** Null when the file cannot be read before it is converted. */
  readonly facts: Verified | null;
};

/**
 * Files of one source that are to be brought into the store; LiDAR squares or orthophotos alike.
 */
export type FetchJob = {
  readonly kind: 'lidar' | 'ortho';
  readonly table: RecordTable;
  readonly records: readonly StoreRecord[];
  readonly http: SourceClient;
  readonly limits: HostLimits;
  readonly missingStatus: readonly number[];
  readonly max_bytes: number;
  /**
   * Whether file: addresses may be copied. False for addresses from a web catalogue, which could
   * name any local file.
   */
  readonly allowFiles: boolean;
  /** All that a finished file may have, so that one can be found again. */
  readonly extensions: readonly string[];
  /** @throws GrabberError when the first bytes show that this is no such file */
  checkStart(shown: string, start: Uint8Array): void;
  /** @throws GrabberError when the file at `path` is not whole or not what it claims to be */
  check(path: string, record: StoreRecord, url: string, signal: AbortSignal): Promise<Checked>;
  /** Finds addresses of records that have none. */
  readonly locate: Catalogue['locate'];
  /** Addresses that an earlier run found are of no use. */
  readonly addressesExpire?: boolean;
  /** Brings a checked file into the form that is kept, and changes the record itself. */
  readonly convert?: (record: StoreRecord, signal: AbortSignal) => Promise<void>;
};

/** What all jobs of a run share. */
export type FetchRun = {
  /** Folder of the store. */
  readonly root: string;
  readonly clock: Clock;
  readonly policy: RetryPolicy;
  readonly queues: HostQueues;
  readonly disk: DiskSpace;
  /**
   * Queue for slow disk operations that run next to the downloads: unpacking archives and syncing
   * files.
   */
  readonly syncs: PQueue;
  readonly events: FetchEvents;
};

import { statfsSync } from 'node:fs';
import { GrabberError, systemCode, causedError } from '../util/errors.js';

/** Left free for everything else that lives on the disk. */
export const kReserve_bytes = 256 * 1024 * 1024;

const kSmallPart = 0.01;

/** Space that is reserved ahead for a file of unknown length. */
const kReserveAhead_bytes = 16 * 1024 * 1024;

/**
 * Free bytes for this user on the disk of a folder. Synchronous, since all worker threads may be
 * waiting for that disk.
 */
export function freeBytes(folder: string): number {
  const { bavail, bsize } = statfsSync(folder);
  return bavail * bsize;
}

export type Reservation = {
  /** Before so many more bytes are written. */
  grow(more_bytes: number): void;
  /** To be called when no more will be written. */
  release(): void;
};

/**
 * Tracks the space that running transfers still need, so that many small ones do not fill the disk
 * together.
 */
export class DiskSpace {
  readonly #folder: string;
  readonly #free: (folder: string) => number;
  #promised_bytes = 0;
  /** The free space at the last query; small files reuse it. */
  #free_bytes = 0;
  #since_bytes = Infinity;

  /** @param free injected by tests */
  constructor(folder: string, free: (folder: string) => number = freeBytes) {
    this.#folder = folder;
    this.#free = free;
  }

  /**
   * @return gives the promise back; to be called when the bytes are written or will not be
   * @throws GrabberError DISK_FULL when they would eat into the reserve
   */
  reserve(bytes: number, shown: string): () => void {
    const free = this.#freeNow(bytes);
    const left = free - this.#promised_bytes - kReserve_bytes;
    if (bytes > left) {
      throw new GrabberError(
        'DISK_FULL',
        `write ${shown} to ${this.#folder}: it needs ${bytes} bytes, ${free} are free and ` +
          `${this.#promised_bytes} promised; allowed: ${Math.max(0, left)}, which leaves ` +
          `${kReserve_bytes} for others`,
      );
    }
    this.#promised_bytes += bytes;
    let given = true;
    return () => {
      if (given) this.#promised_bytes -= bytes;
      given = false;
    };
  }

  /**
   * Reserves for what may grow beyond `bytes`, while it does.
   * @throws GrabberError DISK_FULL, as `grow` does
   */
  reserveGrowing(bytes: number, shown: string): Reservation {
    let left = Math.max(bytes, kReserveAhead_bytes);
    let release = this.reserve(left, shown);
    return {
      grow: (more) => {
        left -= more;
        if (left >= 0) return;
        // The reserved bytes are written, so that the free space of the disk includes them now.
        release();
        left = Math.max(more, kReserveAhead_bytes);
        release = this.reserve(left, shown);
      },
      release: () => release(),
    };
  }

  /**
   * Queries the free space, unless the reservations since the last query are a small part of it.
   */
  #freeNow(bytes: number): number {
    this.#since_bytes += bytes;
    if (this.#since_bytes > (this.#free_bytes - kReserve_bytes) * kSmallPart) {
      this.#free_bytes = this.#free(this.#folder);
      this.#since_bytes = bytes;
    }
    return this.#free_bytes;
  }
}

/**
 * Turns errors of file operations into store errors, which are not retried, unlike network errors.
 */
export async function withStoreErrors<T>(path: string, action: () => Promise<T>): Promise<T> {
  try {
    return await action();
  } catch (error) {
    throw storeError(path, error);
  }
}

/**
 * The same for synchronous operations: opening, renaming and small writes cost less than a worker
 * thread would.
 */
export function withStoreErrorsSync<T>(path: string, action: () => T): T {
  try {
    return action();
  } catch (error) {
    throw storeError(path, error);
  }
}

export function storeError(path: string, error: unknown): GrabberError {
  if (error instanceof GrabberError) return error;
  const full = ['ENOSPC', 'EDQUOT'].includes(systemCode(error) ?? '');
  return causedError(full ? 'DISK_FULL' : 'STORE_IO', `write ${path}`, error);
}

/** Whether an error ends the whole run, because every other file would fail in the same way. */
export function stopsRun(error: unknown): boolean {
  return (
    !(error instanceof GrabberError) ||
    ['STORE_IO', 'DISK_FULL', 'STORE_CONFLICT'].includes(error.code)
  );
}

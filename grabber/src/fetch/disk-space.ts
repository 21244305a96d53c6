import { statfsSync } from 'node:fs';
import { GrabberError, describeError, systemCode } from '../util/errors.js';

/** Left free for everything else that lives on the disk. */
export const kReserve_bytes = 256 * 1024 * 1024;

const kSmallPart = 0.01;

/** What grows to a length that nobody knows has so much reserved ahead. */
const kAhead_bytes = 16 * 1024 * 1024;

/** Free bytes for this user on the disk of a folder. Asked at once: another thread may be waiting for that disk. */
export function freeBytes(folder: string): number {
  const { bavail, bsize } = statfsSync(folder);
  return bavail * bsize;
}

export type Growing = {
  /** Before so many more bytes are written. */
  grow(more_bytes: number): void;
  /** To be called when no more will be written. */
  giveBack(): void;
};

/** Knows what the transfers under way still need, so that many small ones do not fill the disk together. */
export class DiskSpace {
  readonly #folder: string;
  readonly #free: (folder: string) => number;
  #promised_bytes = 0;
  /** The last answer of the disk; small files need not ask it each. */
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
        `write ${shown} to ${this.#folder}: it needs ${bytes} bytes, ${free} are free and ${this.#promised_bytes} promised; allowed: ${Math.max(0, left)}, which leaves ${kReserve_bytes} for others`,
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
  growing(bytes: number, shown: string): Growing {
    let left = Math.max(bytes, kAhead_bytes);
    let giveBack = this.reserve(left, shown);
    return {
      grow: (more) => {
        left -= more;
        if (left >= 0) return;
        // What was reserved is written, so that the disk itself knows of it now.
        giveBack();
        left = Math.max(more, kAhead_bytes);
        giveBack = this.reserve(left, shown);
      },
      giveBack: () => giveBack(),
    };
  }

  /** Asks the disk, unless what was reserved since it was asked is a small part of its room. */
  #freeNow(bytes: number): number {
    this.#since_bytes += bytes;
    if (this.#since_bytes > (this.#free_bytes - kReserve_bytes) * kSmallPart) {
      this.#free_bytes = this.#free(this.#folder);
      this.#since_bytes = bytes;
    }
    return this.#free_bytes;
  }
}

/** Keeps trouble of the disk apart from trouble of the network: only the second is worth another try. */
export async function storing<T>(path: string, action: () => Promise<T>): Promise<T> {
  try {
    return await action();
  } catch (error) {
    throw storeError(path, error);
  }
}

/** The same for what is done at once: opening, renaming, small writes, which cost less than a way to another thread and back. */
export function storingNow<T>(path: string, action: () => T): T {
  try {
    return action();
  } catch (error) {
    throw storeError(path, error);
  }
}

export function storeError(path: string, error: unknown): GrabberError {
  if (error instanceof GrabberError) return error;
  const full = ['ENOSPC', 'EDQUOT'].includes(systemCode(error) ?? '');
  return new GrabberError(full ? 'DISK_FULL' : 'STORE_IO', `write ${path}: ${describeError(error)}`, { cause: error });
}

/** What makes the rest of a run pointless: the other files would only fail the same way, after a download. */
export function stopsRun(error: unknown): boolean {
  return !(error instanceof GrabberError) || ['STORE_IO', 'DISK_FULL', 'STORE_CONFLICT'].includes(error.code);
}

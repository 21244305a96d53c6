import { statfs } from 'node:fs/promises';
import { GrabberError, describeError, systemCode } from '../util/errors.js';

/** Left free for everything else that lives on the disk. */
export const kReserve_bytes = 256 * 1024 * 1024;

const kSmallPart = 0.01;

/** Free bytes for this user on the disk of a folder. */
export async function freeBytes(folder: string): Promise<number> {
  const { bavail, bsize } = await statfs(folder);
  return bavail * bsize;
}

/** Knows what the transfers under way still need, so that many small ones do not fill the disk together. */
export class DiskSpace {
  readonly #folder: string;
  readonly #free: (folder: string) => Promise<number>;
  #promised_bytes = 0;
  /** The last answer of the disk; small files need not ask it each. */
  #free_bytes = 0;
  #since_bytes = Infinity;

  /** @param free injected by tests */
  constructor(folder: string, free: (folder: string) => Promise<number> = freeBytes) {
    this.#folder = folder;
    this.#free = free;
  }

  /**
   * @return gives the promise back; to be called when the bytes are written or will not be
   * @throws GrabberError DISK_FULL when they would eat into the reserve
   */
  async reserve(bytes: number, shown: string): Promise<() => void> {
    const free = await this.#freeNow(bytes);
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

  /** Asks the disk, unless what was reserved since it was asked is a small part of its room. */
  async #freeNow(bytes: number): Promise<number> {
    this.#since_bytes += bytes;
    if (this.#since_bytes > (this.#free_bytes - kReserve_bytes) * kSmallPart) {
      this.#free_bytes = await this.#free(this.#folder);
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

export function storeError(path: string, error: unknown): GrabberError {
  if (error instanceof GrabberError) return error;
  const full = ['ENOSPC', 'EDQUOT'].includes(systemCode(error) ?? '');
  return new GrabberError(full ? 'DISK_FULL' : 'STORE_IO', `write ${path}: ${describeError(error)}`, { cause: error });
}

/** What makes the rest of a run pointless: the other files would only fail the same way, after a download. */
export function stopsRun(error: unknown): boolean {
  return !(error instanceof GrabberError) || ['STORE_IO', 'DISK_FULL', 'STORE_CONFLICT'].includes(error.code);
}

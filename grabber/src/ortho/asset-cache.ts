import { createHash } from 'node:crypto';
import { mkdir, rm } from 'node:fs/promises';
import { join } from 'node:path';
import { fileSize } from '../util/files.js';
import type { Downloader } from './download.js';

const kMaxAsset_bytes = 16 * 2 ** 30;
const kMaxKept_bytes = 24 * 2 ** 30;

/**
 * Whole files that squares side by side need; the oldest go when there are too many. One a run and
 * source.
 */
export class AssetCache {
  readonly #folder: string;
  /** In the order of their last use. */
  readonly #kept = new Map<string, { readonly path: Promise<string | undefined>; bytes: number }>();

  constructor(folder: string) {
    this.#folder = folder;
  }

  /**
   * @return where the file lies, undefined where the server says that there is none; callers at
   * once share one download
   */
  async get(url: string, download: Downloader, signal: AbortSignal): Promise<string | undefined> {
    const known = this.#kept.get(url) ?? { path: this.#fetch(url, download, signal), bytes: 0 };
    this.#kept.delete(url);
    this.#kept.set(url, known);
    try {
      const path = await known.path;
      known.bytes = path === undefined ? 0 : ((await fileSize(path)) ?? 0);
      return path;
    } catch (error) {
      this.#kept.delete(url);
      throw error;
    }
  }

  /** Call between squares: what is in use is never removed. */
  async trim(): Promise<void> {
    let bytes = [...this.#kept.values()].reduce((sum, one) => sum + one.bytes, 0);
    for (const [url, one] of this.#kept) {
      if (bytes <= kMaxKept_bytes) return;
      const path = await one.path;
      if (path !== undefined) await rm(path, { force: true });
      bytes -= one.bytes;
      this.#kept.delete(url);
    }
  }

  async #fetch(
    url: string,
    download: Downloader,
    signal: AbortSignal,
  ): Promise<string | undefined> {
    await mkdir(this.#folder, { recursive: true });
    const path = join(this.#folder, `${createHash('sha256').update(url).digest('hex')}.asset`);
    return (await download.toFile(url, path, kMaxAsset_bytes, signal)) ? path : undefined;
  }
}

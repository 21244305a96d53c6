import { DataError } from '../../http/errors.js';
import { join } from '../../bytes.js';
import type { Http } from '../../http/http.js';
import { UrlFile } from './url-file.js';

/** A part of a file that is split into files of known sizes, in order. */
export type FilePart = { readonly url: string; readonly bytes: number };

type Stretch = { readonly offset: number; readonly bytes: Uint8Array };

const kMaxRememberedBytes = 8 * 1024 * 1024;

/**
 * A file behind one URL, or split into parts, read by ranges. Reads of several ranges may run at
 * once. No read takes more memory than the bytes that were asked for, but for what keep() and
 * remember() were called with.
 */
export class RangeFile {
  /** For messages. */
  readonly name: string;
  readonly #files: readonly UrlFile[];
  readonly #kept: Stretch[] = [];
  /** What was remembered last is at the end. */
  readonly #remembered: Stretch[] = [];
  #rememberedBytes = 0;

  /**
   * @param place an absolute URL, or parts
   * @throws DataError `damaged` for parts without a size, or without any parts
   */
  constructor(http: Http, place: string | readonly FilePart[]) {
    if (typeof place === 'string') {
      this.name = place;
      this.#files = [new UrlFile(http, place)];
      return;
    }
    const [first] = place;
    const isSized = place.every(({ bytes }) => Number.isSafeInteger(bytes) && bytes > 0);
    if (first === undefined || !isSized) {
      throw new DataError('damaged', 'open an archive in parts: each part needs its size in bytes');
    }
    this.name = place.length === 1 ? first.url : `${first.url} and ${place.length - 1} more`;
    this.#files = place.map(({ url, bytes }) => new UrlFile(http, url, bytes));
  }

  /** In bytes; undefined before the first reply for a single URL. */
  get size(): number | undefined {
    let sum = 0;
    for (const { size } of this.#files) {
      if (size === undefined) return undefined;
      sum += size;
    }
    return sum;
  }

  /**
   * The start of the file; afterwards its size is known.
   * @return `length` bytes, or all of a smaller file
   * @throws DataError; the reason of `signal`
   */
  async head(length: number, signal: AbortSignal): Promise<Uint8Array> {
    const size = this.size;
    if (size === undefined) return this.#files[0]!.read(0, length, signal);
    return this.read(0, Math.min(length, size), signal);
  }

  /** Keeps bytes that were read: what lies within them takes no request from then on. */
  keep(offset: number, bytes: Uint8Array): void {
    this.#kept.push({ offset, bytes });
  }

  /**
   * As keep(), up to 8 MiB of what was read on the way: what was remembered longest ago leaves.
   * @param bytes are copied
   */
  remember(offset: number, bytes: Uint8Array): void {
    if (bytes.length > kMaxRememberedBytes || this.has(offset, bytes.length)) return;
    this.#remembered.push({ offset, bytes: bytes.slice() });
    this.#rememberedBytes += bytes.length;
    while (this.#rememberedBytes > kMaxRememberedBytes) {
      this.#rememberedBytes -= this.#remembered.shift()!.bytes.length;
    }
  }

  /** Whether these bytes are kept or remembered. */
  has(offset: number, length: number): boolean {
    return this.#find(offset, length) !== undefined;
  }

  /**
   * @param offset, length whole numbers within the file
   * @return exactly `length` bytes
   * @throws DataError, `cut` for a range beyond the end of the file; the reason of `signal`
   */
  async read(offset: number, length: number, signal: AbortSignal): Promise<Uint8Array> {
    if (length === 0) return new Uint8Array(0);
    const kept = this.#find(offset, length);
    if (kept !== undefined) return kept;
    if (this.size !== undefined && offset + length > this.size) {
      throw this.#tooShort(offset, length);
    }
    const pieces: Uint8Array[] = [];
    let start = 0;
    for (const file of this.#files) {
      const end = start + (file.size ?? Infinity);
      const from = Math.max(offset, start);
      const to = Math.min(offset + length, end);
      if (from < to) pieces.push(await this.#readPiece(file, from - start, to - from, signal));
      start = end;
    }
    return pieces.length === 1 ? pieces[0]! : join(pieces);
  }

  #find(offset: number, length: number): Uint8Array | undefined {
    const isWithin = ({ offset: start, bytes }: Stretch): boolean =>
      offset >= start && offset + length <= start + bytes.length;
    const found = this.#kept.find(isWithin) ?? this.#remembered.find(isWithin);
    return found?.bytes.subarray(offset - found.offset, offset - found.offset + length);
  }

  async #readPiece(
    file: UrlFile,
    offset: number,
    length: number,
    signal: AbortSignal,
  ): Promise<Uint8Array> {
    const bytes = await file.read(offset, length, signal);
    if (bytes.length !== length) throw this.#tooShort(offset, length);
    return bytes;
  }

  #tooShort(offset: number, length: number): DataError {
    return new DataError(
      'cut',
      `read ${this.name}, bytes ${offset} to ${offset + length - 1}: ` +
        `it has ${this.size ?? 'fewer'} bytes; upload it again`,
    );
  }
}

import type { BoxKey } from './box-arrays.js';
import { DataError } from '../../http/errors.js';

/** Reads the reply to `POST /v2/boxes` (docs/formats/http.md, "Batch") as it arrives. */

export type BatchRecord = {
  readonly key: BoxKey;
  readonly status: number;
  readonly payload: Uint8Array;
};

const kHeadBytes = 24;
const kMaxBoxFrameBytes = 16 * 1024 * 1024;
const kMaxTextBytes = 64 * 1024;

export class BatchStream {
  readonly #requested: number;
  readonly #head = new Uint8Array(kHeadBytes);
  readonly #words = new DataView(this.#head.buffer);
  #headFilled = 0;
  #payload: Uint8Array | undefined;
  #payloadFilled = 0;
  #taken = 0;
  #isWhole = false;

  /** @param requested how many boxes were requested */
  constructor(requested: number) {
    this.#requested = requested;
  }

  /**
   * @return the records that end in this part of the reply
   * @throws DataError `damaged` for what is no such reply
   */
  *feed(part: Uint8Array): Generator<BatchRecord, void, undefined> {
    let at = 0;
    while (at < part.length) {
      if (this.#isWhole) throw damaged('bytes after the last record');
      at += this.#fill(part.subarray(at));
      const payload = this.#payload;
      if (payload === undefined || this.#payloadFilled < payload.length) continue;
      const record = { key: this.#key(), status: this.#words.getUint32(16, true), payload };
      this.#payload = undefined;
      this.#headFilled = 0;
      if (this.#isLast(record)) continue;
      this.#taken += 1;
      if (this.#taken > this.#requested) throw damaged('more boxes than were requested');
      yield record;
    }
  }

  /** To be called at the end of the reply. @throws DataError `cut` before the last record */
  finish(): void {
    if (this.#isWhole) return;
    const what = `the reply ended after ${this.#taken} of ${this.#requested} boxes; try again`;
    throw new DataError('cut', `read a batch of boxes: ${what}`);
  }

  /** @return how many bytes were taken */
  #fill(part: Uint8Array): number {
    if (this.#payload === undefined) {
      const count = Math.min(part.length, kHeadBytes - this.#headFilled);
      this.#head.set(part.subarray(0, count), this.#headFilled);
      this.#headFilled += count;
      if (this.#headFilled === kHeadBytes) this.#beginPayload();
      return count;
    }
    const count = Math.min(part.length, this.#payload.length - this.#payloadFilled);
    this.#payload.set(part.subarray(0, count), this.#payloadFilled);
    this.#payloadFilled += count;
    return count;
  }

  #beginPayload(): void {
    const length = this.#words.getUint32(20, true);
    const limit = this.#words.getUint32(16, true) === 200 ? kMaxBoxFrameBytes : kMaxTextBytes;
    if (length > limit) throw damaged(`a record of ${length} bytes; allowed: up to ${limit}`);
    this.#payload = new Uint8Array(length);
    this.#payloadFilled = 0;
  }

  #isLast({ key, status, payload }: BatchRecord): boolean {
    if (key.level !== -1) return false;
    const isSound = key.bx === this.#requested && status === 0 && payload.length === 0;
    if (!isSound || this.#taken !== this.#requested) {
      throw damaged(`a last record after ${this.#taken} of ${this.#requested} boxes`);
    }
    this.#isWhole = true;
    return true;
  }

  #key(): BoxKey {
    const number = (index: number): number => this.#words.getInt32(4 * index, true);
    return { level: number(0), bx: number(1), by: number(2), bz: number(3) };
  }
}

function damaged(what: string): DataError {
  return new DataError('damaged', `read a batch of boxes: ${what}`);
}

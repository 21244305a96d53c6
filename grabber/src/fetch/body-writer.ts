import type { Hash } from 'node:crypto';
import { writev, writevSync } from 'node:fs';
import { promisify } from 'node:util';
import { Readable, pipeline } from 'node:stream';
import { createGunzip, createInflate } from 'node:zlib';
import type { Clock } from '../util/clock.js';
import { GrabberError, describeError, systemCode } from '../util/errors.js';
import { withStoreErrors, withStoreErrorsSync } from './disk-space.js';
import { shownUrl } from './redact.js';

/**
 * Minimum batch for a write. Pieces of a body are as small as network packets, and writing each on
 * its own would cost more than the copy.
 */
const kBatch_bytes = 512 * 1024;
/** Longest time until received bytes are written, so that a killed run finds them on the disk. */
const kBatch_ms = 1000;

const writeMany = promisify(writev);

export type BodySink = {
  readonly path: string;
  /** Open for writing, at its end. */
  readonly fd: number;
  readonly hash: Hash;
  /** Before the first piece. */
  readonly offset_bytes: number;
  readonly max_bytes: number;
  readonly shown: string;
  /** Called with every piece, before it is written. */
  onPiece(piece: Uint8Array, bytesBefore: number): void;
  /** Called when the body has ended, before its last bytes are written. */
  onWhole?(bytes: number): void;
};

/**
 * Appends a body to a file and to its hash. The first piece is written at once, so that a killed
 * run has something to continue. A full batch is written by a worker thread while the next one is
 * received, so at most two are in memory; smaller batches are written synchronously, which costs
 * less. When the body fails, everything received is written.
 * @return length of the file, in bytes
 * @throws GrabberError TOO_LARGE, STORE_IO or DISK_FULL, or the error of the body
 */
export async function writeBody(
  body: AsyncIterable<Uint8Array>,
  sink: BodySink,
  clock: Clock,
): Promise<number> {
  let bytes = sink.offset_bytes;
  let batch: Uint8Array[] = [];
  let waiting_bytes = 0;
  let writing: Promise<void> = Promise.resolve();
  let flushedAt_ms = -Infinity;

  const flush = async (): Promise<void> => {
    await writing;
    const pieces = batch;
    const full = waiting_bytes >= kBatch_bytes;
    batch = [];
    waiting_bytes = 0;
    if (full) writing = writeInBackground(sink, pieces);
    else writeNow(sink, pieces);
    // The next await throws its error; until then it must not count as unhandled.
    writing.catch(() => undefined);
    for (const piece of pieces) sink.hash.update(piece);
  };

  try {
    for await (const piece of body) {
      sink.onPiece(piece, bytes);
      bytes += piece.length;
      if (bytes > sink.max_bytes) throw tooLarge(sink.shown, bytes, sink.max_bytes);
      batch.push(piece);
      waiting_bytes += piece.length;
      const now_ms = clock.now().getTime();
      if (waiting_bytes < kBatch_bytes && now_ms - flushedAt_ms < kBatch_ms) continue;
      flushedAt_ms = now_ms;
      await flush();
    }
    sink.onWhole?.(bytes);
  } finally {
    await flush();
    await writing;
  }
  return bytes;
}

async function writeInBackground(sink: BodySink, pieces: readonly Uint8Array[]): Promise<void> {
  for (let left = unwritten(pieces, 0); left.length > 0;) {
    const batch = left;
    const { bytesWritten } = await withStoreErrors(sink.path, () => writeMany(sink.fd, batch));
    left = unwritten(batch, bytesWritten);
  }
}

function writeNow(sink: BodySink, pieces: readonly Uint8Array[]): void {
  for (let left = unwritten(pieces, 0); left.length > 0;) {
    const batch = left;
    left = unwritten(
      batch,
      withStoreErrorsSync(sink.path, () => writevSync(sink.fd, batch)),
    );
  }
}

/** A write may take a part only. */
function unwritten(pieces: readonly Uint8Array[], bytesWritten: number): Uint8Array[] {
  let skip = bytesWritten;
  const left: Uint8Array[] = [];
  for (const piece of pieces) {
    if (skip < piece.length) left.push(piece.subarray(skip));
    skip = Math.max(0, skip - piece.length);
  }
  return left;
}

export function tooLarge(shown: string, bytes: number, max_bytes: number): GrabberError {
  return new GrabberError(
    'TOO_LARGE',
    `fetch ${shown}: it has ${bytes} bytes or more; allowed: ${max_bytes} (--max-file-gib)`,
  );
}

/** Encodings that servers send although identity was requested. */
export const kCodings = ['gzip', 'x-gzip', 'deflate'] as const;
export type Coding = (typeof kCodings)[number];

/**
 * Point clouds shrink three- to tenfold; a stream that grows a hundredfold is meant to fill the
 * disk.
 */
export const kMaxGrowth = 100;
/** Output below this size is never refused. */
export const kGrowthFree_bytes = 64 * 1024 * 1024;

/** @throws GrabberError TOO_LARGE when `grown` bytes out of `packed` cannot be genuine data */
export function checkGrowth(shown: string, packed: number, grown: number): void {
  if (grown <= kGrowthFree_bytes || grown <= packed * kMaxGrowth) return;
  throw new GrabberError(
    'TOO_LARGE',
    `unpack ${shown}: ${packed} bytes have grown to ${grown}; allowed: ${kMaxGrowth} times as many`,
  );
}

/** Undoes a Content-Encoding on the fly. */
export async function* decoded(
  body: AsyncIterable<Uint8Array>,
  coding: Coding,
  url: string,
): AsyncGenerator<Uint8Array> {
  let packed = 0;
  async function* counted(): AsyncGenerator<Uint8Array> {
    for await (const chunk of body) {
      packed += chunk.length;
      yield chunk;
    }
  }
  const unpacker = coding === 'deflate' ? createInflate() : createGunzip();
  pipeline(Readable.from(counted(), { objectMode: false }), unpacker, () => undefined);
  let grown = 0;
  try {
    for await (const chunk of unpacker) {
      grown += (chunk as Buffer).length;
      checkGrowth(shownUrl(url), packed, grown);
      yield chunk as Buffer;
    }
  } catch (error) {
    if (systemCode(error)?.startsWith('Z_') !== true) throw error;
    const why = `unpack ${shownUrl(url)} (${coding}): ${describeError(error)}`;
    throw new GrabberError('HTTP_PROTOCOL', why, { cause: error, retryable: true });
  }
}

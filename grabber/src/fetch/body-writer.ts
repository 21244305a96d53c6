import type { Hash } from 'node:crypto';
import { writev, writevSync } from 'node:fs';
import { promisify } from 'node:util';
import type { Clock } from '../util/clock.js';
import { GrabberError } from '../util/errors.js';
import { storing, storingNow } from './disk-space.js';

/** Pieces of a body are as small as the network's; written one by one, the calls cost more than the bytes. */
const kBatch_bytes = 512 * 1024;
/** A slow line fills no batch for long; what a killed run has received should be on the disk by then. */
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
 * Appends a body to a file and to its hash. The first piece is written at once: from then on a killed run has something
 * to continue. A full batch is written by another thread while the next is received, so at most two are in memory; a
 * smaller one costs less than the way to that thread. When the body breaks, all that came of it is written.
 * @return length of the file
 */
export async function writeBody(body: AsyncIterable<Uint8Array>, sink: BodySink, clock: Clock): Promise<number> {
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
    if (full) writing = writeBeside(sink, pieces);
    else writeNow(sink, pieces);
    // Whoever awaits it next sees its error; until then it must not count as unhandled.
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

async function writeBeside(sink: BodySink, pieces: readonly Uint8Array[]): Promise<void> {
  for (let left = unwritten(pieces, 0); left.length > 0; ) {
    const batch = left;
    const { bytesWritten } = await storing(sink.path, () => writeMany(sink.fd, batch));
    left = unwritten(batch, bytesWritten);
  }
}

function writeNow(sink: BodySink, pieces: readonly Uint8Array[]): void {
  for (let left = unwritten(pieces, 0); left.length > 0; ) {
    const batch = left;
    left = unwritten(batch, storingNow(sink.path, () => writevSync(sink.fd, batch)));
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
  return new GrabberError('TOO_LARGE', `fetch ${shown}: it has ${bytes} bytes or more; allowed: ${max_bytes} (--max-file-gib)`);
}

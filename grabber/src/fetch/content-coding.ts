import { Readable, pipeline } from 'node:stream';
import { createGunzip, createInflate } from 'node:zlib';
import { GrabberError, describeError, systemCode } from '../util/errors.js';
import { shownUrl } from './shown-url.js';

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
    throw new GrabberError(
      'HTTP_PROTOCOL',
      `unpack ${shownUrl(url)} (${coding}): ${describeError(error)}`,
      {
        cause: error,
        retryable: true,
      },
    );
  }
}

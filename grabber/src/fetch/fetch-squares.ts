import PQueue from 'p-queue';
import type { Square } from '../sources/square.js';
import { fetchSquare, type FetchContext, type Outcome } from './fetch-square.js';

export type Tally = Record<Outcome['state'], number>;

/**
 * Fetches squares, at most `concurrency` at a time.
 * When the signal aborts, no further square starts, those under way are stopped, and the signal's reason is thrown
 * after the last of them has closed its files.
 */
export async function fetchSquares(
  squares: readonly Square[],
  concurrency: number,
  context: FetchContext,
  onOutcome: (outcome: Outcome) => void,
  signal: AbortSignal,
): Promise<Tally> {
  const tally: Tally = { verified: 0, kept: 0, missing: 0, failed: 0 };
  const queue = new PQueue({ concurrency });
  // A store that cannot be written ends the whole run: the other squares would only fail the same way, after a download.
  const stop = new AbortController();
  const both = AbortSignal.any([signal, stop.signal]);
  const clear = (): void => queue.clear();
  both.addEventListener('abort', clear, { once: true });

  for (const square of squares) {
    void queue.add(async () => {
      try {
        const outcome = await fetchSquare(square, context, both);
        ++tally[outcome.state];
        onOutcome(outcome);
      } catch (error) {
        stop.abort(error);
      }
    });
  }
  await queue.onIdle();
  both.removeEventListener('abort', clear);
  both.throwIfAborted();
  return tally;
}

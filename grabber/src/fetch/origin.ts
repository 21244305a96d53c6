import type { Square } from '../sources/square.js';

export type TransferResult =
  | { readonly kind: 'complete'; readonly bytes: number; readonly sha256: string }
  /** The origin answered that it has no such square. */
  | { readonly kind: 'missing'; readonly reason: string };

/** Where squares come from. Writes the bytes to a partial file and hashes them; never touches the rest of the store. */
export type Origin = {
  /** Address for the records; does no I/O. */
  urlOf(square: Square): string;
  transfer(square: Square, partial: string, signal: AbortSignal): Promise<TransferResult>;
};

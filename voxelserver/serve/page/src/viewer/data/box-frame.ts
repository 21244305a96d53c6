import { kMaxBoxBytes, readBoxArrays, type BoxArrays, type BoxKey } from './box-arrays.js';
import type { Turns } from './turns.js';
import { unpack } from './zstd.js';

/**
 * Unpacks and reads a box.
 * @param turns is charged with the unpacked bytes; with those of the largest box for a frame that
 * cannot be unpacked
 * @throws DataError
 */
export function readBoxFrame(frame: Uint8Array, key: BoxKey, turns: Turns): BoxArrays {
  let bytes = kMaxBoxBytes;
  try {
    const box = unpack(frame, kMaxBoxBytes);
    bytes = box.length;
    return readBoxArrays(box, key);
  } finally {
    turns.spend(bytes);
  }
}

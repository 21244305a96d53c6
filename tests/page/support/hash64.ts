import type { Hash64 } from '../../../voxelserver/serve/page/src/viewer/data/xxh64.js';

/** Hashes as numbers of any size. */

export const big = ({ low, high }: Hash64): bigint => (BigInt(high) << 32n) | BigInt(low);

export const halves = (value: bigint): Hash64 => ({
  low: Number(value & 0xffffffffn),
  high: Number(value >> 32n),
});

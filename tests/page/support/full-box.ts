import { xxh64 } from '../../../voxelserver/serve/page/src/viewer/data/xxh64.js';
import { zstdFrame, type Key } from './make-archive.js';
import { makeBox } from './make-box.js';

const kVoxels = 1 << 20;
const kCells = 4 + 256 + 16_384;
const kHeaderBytes = 64;
const kAttributeBytes = 8;

/** The largest box that there is: solid, and every voxel has an attribute. Its frame. */
export function fullBoxFrame(key: Key, material = 0): Uint8Array {
  const content = makeBox([{ x: 0, y: 0, z: 0, material: 1 }]);
  const attributesAt = kHeaderBytes + 24 * kCells;
  const box = Buffer.alloc(attributesAt + kAttributeBytes * kVoxels);
  box.set(content.subarray(0, kHeaderBytes));
  box.writeUInt32LE(kCells, 28);
  box.writeUInt32LE(kVoxels, 32);
  for (let i = 0; i < kCells; ++i) {
    box.fill(255, kHeaderBytes + 24 * i, kHeaderBytes + 24 * i + 16);
    const first = i < 260 ? 4 + 64 * i : 64 * (i - 260);
    box.writeUInt32LE(first, kHeaderBytes + 24 * i + 16);
  }
  for (let i = 0; material > 0 && i < kVoxels; ++i) {
    box[attributesAt + kAttributeBytes * i] = material;
  }
  key.forEach((number, i) => box.writeInt32LE(number, 12 + 4 * i));
  const seed = xxh64(box.subarray(0, 56));
  box.writeBigUInt64LE(xxh64(box.subarray(kHeaderBytes), seed), 56);
  return zstdFrame(box);
}

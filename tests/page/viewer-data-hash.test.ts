import assert from 'node:assert/strict';
import { test } from 'node:test';
import { xxh64 } from '../../voxelserver/serve/page/src/viewer/data/xxh64.js';
import { slowXxh64 } from './support/make-archive.js';
import { makeRandom } from './support/test-bytes.js';

// Of xxhash's own sanity check: bytes of this generator, and a prime as the seed.
const kVectors = [
  [0, 0n, 0xef46db3751d8e999n],
  [0, 0x9e3779b1n, 0xac75fda2929b17efn],
  [1, 0n, 0xe934a84adb052768n],
  [1, 0x9e3779b1n, 0x5014607643a9b4c3n],
  [4, 0n, 0x9136a0dca57457een],
  [14, 0n, 0x8282dcc4994e35c8n],
  [14, 0x9e3779b1n, 0xc3bd6bf63deb6df0n],
  [31, 0xfedcba9876543210n, 0x18865f92dd3ab2d4n],
  [32, 0n, 0x18b216492bb44b70n],
  [33, 0x9e3779b1n, 0xe92c292f64bc3071n],
  [63, 0xfedcba9876543210n, 0xed074a73230ebe21n],
  [222, 0n, 0xb641ae8cb691c174n],
  [222, 0x9e3779b1n, 0x20cb8ab7ae10c14an],
] as const;

test('XXH64 gives the official values, with and without a seed', () => {
  const bytes = new Uint8Array(222);
  let state = 0x9e3779b1n;
  for (let i = 0; i < bytes.length; ++i) {
    bytes[i] = Number(state >> 56n);
    state = BigInt.asUintN(64, state * 0x9e3779b185ebca8dn);
  }
  for (const [length, seed, hash] of kVectors) {
    assert.equal(xxh64(bytes.subarray(0, length), seed), hash, `${length}, ${seed}`);
  }
  const random = makeRandom(1);
  for (let length = 0; length < 200; ++length) {
    const some = Uint8Array.from({ length }, () => random(256));
    const seed = BigInt.asUintN(64, slowXxh64(some));
    assert.equal(xxh64(some, seed), slowXxh64(some, seed), `${length}`);
  }
});

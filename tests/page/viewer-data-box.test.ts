import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import {
  findTop,
  kMaterials,
  kUnknownMaterial,
  readBoxArrays,
} from '../../voxelserver/serve/page/src/viewer/data/box-arrays.js';
import { kTextKeys } from '../../voxelserver/serve/page/src/viewer/ui/texts.js';
import { catchKind } from './support/data-errors.js';
import { boxBytes, sealBox, type Key } from './support/make-archive.js';
import { makeBox, type Voxel } from './support/make-box.js';
import { heightAt } from './support/fake-world.js';
import { makeRandom } from './support/test-bytes.js';
import { kVoxels } from './support/small-archive.js';

declare const TERRAVOX_ROOT: string;

const kKey = { level: 1, bx: -2, by: 0, bz: 3 };

const toKey = ({ level, bx, by, bz }: typeof kKey): Key => [level, bx, by, bz];

/** The attribute of a voxel by a walk through the arrays. */
function attributeAt(box: ReturnType<typeof readBoxArrays>, voxel: Voxel): number | undefined {
  let cell = voxel.y >> 6;
  for (const shift of [4, 2, 0]) {
    const part = (value: number): number => (value >> shift) & 3;
    const bit = BigInt(part(voxel.x) + 4 * part(voxel.z) + 16 * part(voxel.y));
    const word = (i: number): bigint => BigInt(box.cells[4 * cell + i]!);
    const detail = word(2) | (word(3) << 32n);
    if (((detail >> bit) & 1n) === 0n) return undefined;
    const before = detail & ((1n << bit) - 1n);
    const index = box.first[cell]! + before.toString(2).replaceAll('0', '').length;
    assert.ok(index < (shift === 0 ? box.attributes : box.first).length);
    if (shift === 0) return box.attributes[index];
    cell = index;
  }
  return undefined;
}

test('arrays of a box hold every voxel with its material, colour and class', () => {
  const bytes = makeBox(kVoxels);
  bytes[bytes.length - 8 * kVoxels.length + 1] = 200;
  const box = readBoxArrays(sealBox(bytes, toKey(kKey)), kKey);
  assert.equal(box.cells.length, 4 * box.first.length);
  assert.equal(box.attributes.length, kVoxels.length);
  assert.equal(box.classes[0], 200);
  for (const voxel of kVoxels) {
    const [r, g, b] = voxel.rgb ?? [0, 0, 0];
    const material = voxel.material > 32 ? 23 : voxel.material;
    const colour = r + g * 2 ** 8 + b * 2 ** 16 + material * 2 ** 24;
    assert.equal(attributeAt(box, voxel), colour + (voxel.rgb ? 2 ** 31 : 0));
  }
  assert.equal(attributeAt(box, { x: 1, y: 0, z: 0, material: 0 }), undefined);
  // From any place of a larger buffer.
  const moved = Buffer.concat([Buffer.alloc(3), bytes]).subarray(3);
  assert.deepEqual(readBoxArrays(moved, kKey), box);
});

test('the top of each column of a box is found', () => {
  const voxels: Voxel[] = [];
  for (let z = 0; z < 64; ++z) {
    for (let x = 0; x < 64; ++x) {
      const colour = z % 2 === 0 ? { rgb: [x, z, 7] as const } : {};
      if ((x * 7 + z * 13) % 11 !== 0) {
        voxels.push({ x, y: heightAt(x, z) % 256, z, material: x % 5, ...colour });
      }
    }
  }
  const box = readBoxArrays(boxBytes(toKey(kKey), voxels), kKey);
  const tops = new Map(voxels.map((voxel) => [`${voxel.x} ${voxel.z}`, voxel]));
  for (let z = 0; z < 64; ++z) {
    for (let x = 0; x < 64; ++x) {
      const voxel = tops.get(`${x} ${z}`);
      const look = voxel && { material: voxel.material, colour: voxel.rgb };
      assert.deepEqual(findTop(box, x, z), voxel && { y: voxel.y, look }, `column ${x}, ${z}`);
    }
  }
});

test('the top of a column is its highest voxel, at any height', () => {
  const random = makeRandom(3);
  const voxels = Array.from({ length: 400 }, () => {
    return { x: random(64), y: random(256), z: random(64), material: 1 + random(32) };
  });
  const places = new Map(voxels.map((voxel) => [`${voxel.x},${voxel.y},${voxel.z}`, voxel]));
  const arrays = readBoxArrays(boxBytes(toKey(kKey), [...places.values()]), kKey);
  for (const voxel of places.values()) {
    const top = findTop(arrays, voxel.x, voxel.z);
    assert.ok(top !== undefined && top.y >= voxel.y);
    assert.equal(attributeAt(arrays, { ...voxel, y: top.y })! >>> 24, top.look?.material);
  }
});

test('the higher of two voxels counts, and rock without a look is still solid', () => {
  const higher = { x: 5, y: 200, z: 6, material: 3 };
  const bytes = makeBox([{ ...higher, y: 3, material: 2 }, higher], [[40, 65, 40]]);
  const box = readBoxArrays(sealBox(bytes, toKey(kKey)), kKey);
  assert.deepEqual(findTop(box, 5, 6), { y: 200, look: { material: 3, colour: undefined } });
  assert.deepEqual(findTop(box, 41, 43), { y: 67, look: undefined });
  assert.equal(findTop(box, 44, 40), undefined);
});

test('the viewer knows as many materials as the programs, and has a name for each', () => {
  const header = readFileSync(join(TERRAVOX_ROOT, 'common/voxel/material.hpp'), 'utf8');
  const numbers = [...header.matchAll(/^ {4}k(\w+) = (\d+),/gm)].map(([, , n]) => Number(n));
  assert.deepEqual(
    numbers,
    numbers.map((_, i) => i),
  );
  assert.equal(kMaterials, numbers.length, 'kMaterials in box-arrays.ts');
  assert.match(header, new RegExp(`^    kUnknown = ${kUnknownMaterial},`, 'm'));
  const names = [...header.matchAll(/\{Material::k\w+,\s*"(\w+)"/g)].map(([, name]) => name!);
  assert.equal(names.length, numbers.length);
  const keys: readonly string[] = kTextKeys;
  assert.deepEqual(
    names.filter((name) => !keys.includes(`material.${name}`)),
    [],
    'materials without a text in texts.ts',
  );
});

test('a box with any changed byte is refused', () => {
  const box = boxBytes(toKey(kKey), kVoxels);
  for (let at = 0; at < box.length; ++at) {
    const changed = box.map((byte, i) => (i === at ? byte ^ 0x10 : byte));
    assert.equal(
      catchKind(() => readBoxArrays(changed, kKey)),
      'damaged',
      `byte ${at}`,
    );
  }
  for (const length of [0, 63, 64, box.length - 1]) {
    assert.equal(
      catchKind(() => readBoxArrays(box.subarray(0, length), kKey)),
      'damaged',
    );
  }
  assert.equal(
    catchKind(() => readBoxArrays(box, { ...kKey, bz: 4 })),
    'damaged',
  );
});

test('a box whose checksum holds is refused when an index leaves the order of the format', () => {
  const good = boxBytes(toKey(kKey), kVoxels);
  const cells = new DataView(good.buffer).getUint32(28, true);
  const change = (at: number, value: number, size = good.length): Uint8Array => {
    const bytes = new Uint8Array(size);
    bytes.set(good.subarray(0, size));
    new DataView(bytes.buffer).setUint32(at, value, true);
    return bytes;
  };
  const lastBrick = 64 + 24 * (cells - 1);
  const cases: [string, Uint8Array][] = [
    ['the first child of a root', change(64 + 16, 5)],
    ['the first attribute of a brick', change(lastBrick + 16, 1)],
    ['detail where there is no mask', change(64, 0)],
    ['a bit of detail more', change(64 + 8, 3)],
    ['a bit of detail less', change(lastBrick + 12, 0)],
    ['more cells than there are', change(28, cells + 1)],
    ['too few cells', change(28, 3)],
    ['too many cells', change(28, 16_645)],
    ['too many attributes', change(32, 1_048_577)],
    ['a cell too many', change(28, cells + 1, good.length + 24)],
    ['an attribute too many', change(32, kVoxels.length + 1, good.length + 8)],
    ['another version', change(8, 2)],
  ];
  assert.equal(
    catchKind(() => readBoxArrays(sealBox(good.slice(), toKey(kKey)), kKey)),
    'none',
  );
  for (const [name, bytes] of cases) {
    assert.equal(
      catchKind(() => readBoxArrays(sealBox(bytes, toKey(kKey)), kKey)),
      'damaged',
      name,
    );
  }
  const level = { ...kKey, level: 21 };
  assert.equal(
    catchKind(() => readBoxArrays(sealBox(good.slice(), toKey(level)), level)),
    'damaged',
  );
});

test('no walk leaves the arrays of a box that was accepted, whatever its cells say', () => {
  const good = boxBytes(toKey(kKey), kVoxels);
  const cells = new DataView(good.buffer).getUint32(28, true);
  const random = makeRandom(13);
  let accepted = 0;
  for (let i = 0; i < 1000; ++i) {
    const bytes = good.slice();
    const at = 64 + random(24 * cells);
    bytes[at]! ^= 1 << random(8);
    sealBox(bytes, toKey(kKey));
    if (catchKind(() => readBoxArrays(bytes, kKey)) !== 'none') continue;
    accepted += 1;
    const box = readBoxArrays(bytes, kKey);
    for (const voxel of kVoxels) {
      const attribute = attributeAt(box, voxel);
      assert.ok(attribute === undefined || attribute <= 0xffffffff);
    }
  }
  // A bit of a mask without detail, and what is reserved, may change.
  assert.ok(accepted > 0 && accepted < 900, `${accepted}`);
});

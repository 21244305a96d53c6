import assert from 'node:assert/strict';
import { test } from 'node:test';
import { encodeFootprint } from '../../../grabber/src/store/geometry.js';
import { readRing } from '../support/record-fixture.js';

/**
 * South-west corners as PROJ has them, by gdaltransform. A tenth of an arc second is three metres.
 */
const kCorners: readonly {
  crs: string;
  corner: readonly [number, number];
  degrees: readonly [number, number];
}[] = [
  { crs: 'EPSG:3794', corner: [462_000, 101_000], degrees: [14.508973, 46.047744] },
  { crs: 'EPSG:28992', corner: [85_000, 446_000], degrees: [4.36788777930765, 51.9979621078331] },
];

test('squares lie on the map where PROJ has them', () => {
  for (const { crs, corner, degrees } of kCorners) {
    const [west, south] = corner;
    const blob = encodeFootprint([west, south, west + 1000, south + 1000], crs);
    assert.ok(blob, crs);
    const [longitude, latitude] = readRing(blob)[0] ?? [0, 0];
    assert.ok(
      Math.abs(longitude - degrees[0]) < 3e-5 && Math.abs(latitude - degrees[1]) < 3e-5,
      `${crs}: ${longitude} ${latitude}`,
    );
  }
});

test('ground in a CRS without a known projection has no polygon', () => {
  for (const crs of ['EPSG:999999', 'EPSG:4326', 'here', null]) {
    assert.equal(encodeFootprint([0, 0, 1, 1], crs), null);
  }
  assert.equal(encodeFootprint(null, 'EPSG:3794'), null);
});
